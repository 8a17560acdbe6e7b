"""What may explain the gap of a part: its own parameters, and effects of the library."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from pneu_rig_ros.gap.candidates import Candidate, Coordinate, effect_candidate
from pneu_rig_ros.gap.parts.part import CHAMBERS, FRICTION, VALVES, Part
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import READING_BALANCES, Balance, Need
from pneu_rig_ros.model.parameters import FRICTION_MODELS, LUGRE, SECTIONS
from pneu_rig_ros.model.quantity import Quantity, specifications

BALANCES = {
    CHAMBERS: (Balance.MASS, Balance.HEAT, *READING_BALANCES),
    FRICTION: (Balance.BRISTLE, Balance.LEVEL, Balance.FILM, Balance.FORCE),
    VALVES: (Balance.SPOOL, Balance.SUPPLY, Balance.MASS, Balance.HEAT),
}
"""Kind of part -> balances whose effects it can show."""
VALVE_PARAMETERS = ('intake_coefficient', 'exhaust_coefficient', 'intake_voltage',
                    'exhaust_voltage')  # fmt: skip
FACTOR = 5.0
"""How far a parameter may be off where the part does not say, either way [-]."""
VOLTAGE_RANGE = 0.15
"""The same for the opening voltages of a valve [V]."""
LADDER = (0.1, 1.0, 10.0, 60.0)
"""Multiples of an effect's probes that are tried: a part may be of any size [-]."""
SMALLEST = 1e-4
"""Lower end of a strength that cannot be zero to a logarithm, share of where a fit starts [-]."""


def parameters(part: Part) -> list[Candidate]:
    """Return the parameters that may be wrong: those of the file, else the usual ones."""
    ranges = dict(part.refit) or {name: _range(part, name) for name in _usual(part)}
    # what is zero is switched off: no factor makes it another value
    return [
        _parameter(part, name, low, high) for name, (low, high) in ranges.items() if low < high
    ]


def _usual(part: Part) -> Iterator[str]:
    """Yield the parameters of a kind of part."""
    if part.kind == FRICTION:
        yield from ('friction.coulomb_force', 'friction.element_stiffness')
        if part.hypothesis.model.friction.viscous_coefficient > 0.0:
            yield 'friction.viscous_coefficient'
        if part.hypothesis.model.friction.model >= LUGRE:
            yield from ('friction.breakaway_force', 'friction.stribeck_velocity')
        return
    if not part.shut:
        yield from (f'valve.{name}' for name in VALVE_PARAMETERS)
    if part.kind == CHAMBERS:
        yield from ('cylinder.cap_dead_volume', 'cylinder.rod_dead_volume')


def _range(part: Part, name: str) -> tuple[float, float]:
    value, unit = _value(part, name), _quantity(name).unit
    if unit == 'V':
        return value - VOLTAGE_RANGE, value + VOLTAGE_RANGE
    return value / FACTOR, value * FACTOR


def _value(part: Part, full: str) -> float:
    section, name = full.split('.')
    value = getattr(getattr(part.hypothesis.model, section), name)
    return float(sum(value)) if isinstance(value, tuple) else float(value)


def _quantity(full: str) -> Quantity:
    section, name = full.split('.')
    specification = specifications(SECTIONS[section])[name]
    return cast(Quantity, getattr(specification, 'item', specification))


def _parameter(part: Part, full: str, low: float, high: float) -> Candidate:
    was, quantity = _value(part, full), _quantity(full)
    logarithmic = low > 0.0 and quantity.unit != 'V'
    scale = 1.0 if logarithmic else 0.2 * (high - low)
    name = full.split('.')[1]
    coordinate = Coordinate(name, quantity, low, high, scale, logarithmic, was)
    return Candidate(full, part.kind, (), (coordinate,), ((was,),), was)


def effects(
    part: Part, without: Sequence[str] = (), chambers: Sequence[int] = (1, 2)
) -> list[Candidate]:
    """
    Return the effects that the part lacks and can show.

    :param without: names of effects that are left out
    :param chambers: those that are measured; nothing is said of the other
    """
    law = FRICTION_MODELS[part.hypothesis.model.friction.model]
    there, chosen = _there(part, chambers), []
    for name in library.names():
        effect = library.load(name)
        fits = effect.balance in BALANCES[part.kind] and not effect.describes
        fits &= not effect.laws or (part.kind == FRICTION and law in effect.laws)
        fits &= set(effect.needs) <= there
        if fits and name not in part.hypothesis.effects and name not in without:
            chosen.append(_laddered(_measured_only(effect_candidate(name), chambers)))
    return chosen


def _there(part: Part, chambers: Sequence[int]) -> set[Need]:
    """Return what of a rig the part has."""
    valves = set() if part.shut else {Need.VALVES}
    return valves | ({Need.BOTH_CHAMBERS} if len(chambers) == 2 else set())


def _measured_only(candidate: Candidate, chambers: Sequence[int]) -> Candidate:
    """Return a candidate without what acts on a chamber that is not measured."""
    unseen = tuple(f'_{chamber}' for chamber in (1, 2) if chamber not in chambers)
    keep = [i for i, one in enumerate(candidate.coordinates) if not one.name.endswith(unseen)]
    starts = {tuple(start[i] for i in keep) for start in candidate.starts}
    coordinates = tuple(candidate.coordinates[i] for i in keep)
    shown = tuple(sorted(start for start in starts if any(start)))
    return replace(candidate, coordinates=coordinates, starts=shown)


def _laddered(candidate: Candidate) -> Candidate:
    """Return a candidate that starts from multiples of its probes, within the bounds."""
    starts = []
    for probe in candidate.starts:
        for factor in LADDER:
            pairs = zip(candidate.coordinates, probe, strict=True)
            starts.append(tuple(_scaled(one, value, factor) for one, value in pairs))
    return replace(candidate, starts=tuple(dict.fromkeys(starts)))


def _scaled(one: Coordinate, value: float, factor: float) -> float:
    """Return a strength times a factor; what is no strength stays."""
    times = factor if one.null == 0.0 else 1.0
    return float(np.clip(times * value, one.quantity.low, one.quantity.high))


def from_start(candidate: Candidate, start: Sequence[float]) -> Candidate:
    """Return an effect as a fit from one start sees it: strengths in shares of the start."""
    largest = max(abs(value) for value in start) or 1.0
    coordinates = []
    for one, value in zip(candidate.coordinates, start, strict=True):
        q = one.quantity
        if q.low >= 0.0 and value > 0.0:
            low = max(q.low, SMALLEST * value)
            coordinates.append(replace(one, low=low, high=q.high, scale=1.0, logarithmic=True))
        else:
            scale = abs(value) or 0.1 * min(largest, q.high)
            coordinates.append(
                replace(one, low=q.low, high=q.high, scale=scale, logarithmic=False)
            )
    return replace(candidate, coordinates=tuple(coordinates))
