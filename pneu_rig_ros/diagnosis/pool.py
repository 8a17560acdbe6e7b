"""What may be the cause in a system: its own parameters, and the effects that can show in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pneu_rig_ros.diagnosis.candidates import (
    FORCE,
    GAS,
    Candidate,
    Condition,
    Coordinate,
    condition,
    effect_candidate,
    effects,
    parameters,
)
from pneu_rig_ros.diagnosis.run import Run
from pneu_rig_ros.diagnosis.system import System, quantity_of, value_of
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES, Balance, Need

FASTEST = 5e-3
"""Interval of samples up to which lags of milliseconds show [s]."""
LADDER = (0.01, 0.1, 1.0, 10.0, 100.0)
"""Multiples of an effect's probes that are tried where a system may be of any size [-]."""
NEEDS_CHAMBER = {
    'cylinder.cap_dead_volume': 'gas_1', 'cylinder.rod_dead_volume': 'gas_2',
}  # fmt: skip
"""Parameter -> the only balance that shows it."""
SUPPLY_OFF, LOAD_OFF = 1.1, 1.5
"""Factors by which supply pressure and load may differ from what is stated: a gauge, a guess."""
VALVE_PARAMETERS = ('valve.intake_coefficient', 'valve.exhaust_coefficient',
                    'valve.intake_voltage', 'valve.exhaust_voltage')  # fmt: skip


def pool(system: System, runs: Sequence[Run], without: Sequence[str]) -> list[Candidate]:
    """
    Return everything that may explain a gap of a system in some runs.

    :param without: effects that are left out
    """
    balances = frozenset().union(*(run.balances for run in runs))
    return [*_parameters(system, balances), *_conditions(system, runs, balances),
            *_effects(system, runs, balances, without)]  # fmt: skip


def _conditions(
    system: System, runs: Sequence[Run], balances: frozenset[str]
) -> Iterator[Condition]:
    """Yield the conditions that may be other than stated, and show."""
    if not system.shut and balances & {'gas_1', 'gas_2'}:
        yield condition('supply_pressure', GAS, SUPPLY_OFF)
    if 'force' in balances and any(run.operation.load_mass > 0.0 for run in runs):
        yield condition('load_mass', FORCE, LOAD_OFF)


def _parameters(system: System, balances: frozenset[str]) -> Iterator[Candidate]:
    """Yield the parameters that may be wrong: those that the file names, else the usual ones."""
    if system.refit:
        yield from (_in_range(system, name, *limits) for name, limits in system.refit.items())
        return
    groups = {FORCE if one == 'force' else GAS for one in balances}
    for one in parameters(system.hypothesis):
        section, key = one.name.split('.')
        said = key in system.said.get(section, ())
        valve = one.name in VALVE_PARAMETERS and system.shut
        shown = one.group in groups and NEEDS_CHAMBER.get(one.name, '') in {'', *balances}
        if said and shown and not valve:
            yield one


def _in_range(system: System, name: str, low: float, high: float) -> Candidate:
    """Return a parameter that may be wrong within a range [SI]."""
    was, quantity = value_of(system.hypothesis.model, name), quantity_of(name)
    logarithmic = low > 0.0 and quantity.unit != 'V'
    scale = 1.0 if logarithmic else 0.2 * (high - low)
    coordinate = Coordinate(name.split('.')[1], quantity, low, high, scale, logarithmic, was)
    group = FORCE if name.startswith('friction') else GAS
    starts = tuple((was + share * (end - was),) for end in (low, high) for share in (0.2,))
    return Candidate(name, group, (coordinate,), starts, was)


def _effects(
    system: System, runs: Sequence[Run], balances: frozenset[str], without: Sequence[str]
) -> Iterator[Candidate]:
    """Yield the effects that the system lacks and can show."""
    there = _there(system, runs, balances)
    allowed = {one.name for one in effects(system.hypothesis, without)}
    for name in library.names():
        effect = library.load(name)
        shown = name in allowed and _shows(effect.balance, system, balances)
        if not shown or not set(effect.needs) <= there:
            continue
        candidate = _of_open_chambers(effect_candidate(name), balances)
        if candidate.coordinates and candidate.starts:
            yield candidate if system.rig is not None else _laddered(candidate)


def _there(system: System, runs: Sequence[Run], balances: frozenset[str]) -> set[Need]:
    """Return what of a rig the system has."""
    there = set() if system.shut else {Need.VALVES}
    there |= {Need.BOTH_CHAMBERS} if {'gas_1', 'gas_2'} <= balances else set()
    free = 'force' in balances and all(run.force is None for run in runs)
    there |= {Need.FREE_MOTION} if free else set()
    quick = all(run.interval <= FASTEST for run in runs)
    return there | ({Need.MILLISECONDS} if quick else set())


def _shows(balance: Balance, system: System, balances: frozenset[str]) -> bool:
    if balance in (Balance.SPOOL, Balance.SUPPLY):
        return not system.shut and balances != {'force'}
    if balance in GAS_BALANCES:
        return balances != {'force'}
    if balance is Balance.MOTION_READING:
        return 'position' not in system.fixed
    if balance in READING_BALANCES:
        return balances != {'force'}
    return 'force' in balances


def _of_open_chambers(candidate: Candidate, balances: frozenset[str]) -> Candidate:
    """Return a candidate without what acts on a chamber whose balance is closed."""
    if 'force' in balances and len(balances) > 1:
        return candidate
    closed = tuple(f'_{i}' for i in (1, 2) if f'gas_{i}' not in balances)
    if len(closed) == 2:  # pressures are drivers of the force only
        return candidate
    keep = [i for i, one in enumerate(candidate.coordinates) if not one.name.endswith(closed)]
    if len(keep) == len(candidate.coordinates):
        return candidate
    starts = {tuple(start[i] for i in keep) for start in candidate.starts}
    coordinates = tuple(candidate.coordinates[i] for i in keep)
    return replace(candidate, coordinates=coordinates,
                   starts=tuple(sorted(start for start in starts if any(start))))  # fmt: skip


def _laddered(candidate: Candidate) -> Candidate:
    """Return a candidate that starts from multiples of its probes, within the bounds."""
    unit = candidate.coordinates[0].quantity.unit
    starts = [
        tuple(strength(one, value, factor if one.quantity.unit == unit else 1.0)
              for one, value in zip(candidate.coordinates, probe, strict=True))
        for probe in candidate.starts
        for factor in LADDER
    ]  # fmt: skip
    coordinates = []
    for one in candidate.coordinates:
        q = one.quantity
        low = min(one.low, max(q.low, 1e-3 * one.low)) if one.logarithmic else q.low
        coordinates.append(replace(one, low=low, high=q.high))
    return replace(candidate, coordinates=tuple(coordinates), starts=tuple(dict.fromkeys(starts)))


def strength(coordinate: Coordinate, value: float, factor: float) -> float:
    """Return a value so many times as strong, within its range [SI]."""
    quantity = coordinate.quantity
    return float(np.clip(value * factor, quantity.low, quantity.high))
