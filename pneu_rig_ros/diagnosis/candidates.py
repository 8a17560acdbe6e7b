"""What may explain a gap: a parameter of the model with another value, or an effect it lacks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES, Balance
from pneu_rig_ros.model.parameters import (
    FRICTION_MODELS,
    LUGRE,
    REVISED_LUGRE,
    REVISED_LUGRE_DWELL,
    SECTIONS,
)
from pneu_rig_ros.model.quantity import Quantity, specifications
from pneu_rig_ros.rig.sensors import Sensors

Floats = NDArray[np.float64]

GAS_PARAMETERS = (
    'valve.intake_coefficient', 'valve.exhaust_coefficient', 'valve.intake_voltage',
    'valve.exhaust_voltage', 'cylinder.cap_dead_volume', 'cylinder.rod_dead_volume',
)  # fmt: skip
"""Parameters that are identified from the pressures under the measured motion."""

FORCE_PARAMETERS: dict[str, int] = {
    'friction.breakaway_force': LUGRE, 'friction.coulomb_force': 0,
    'friction.stribeck_velocity': LUGRE, 'friction.viscous_coefficient': 0,
    'friction.element_stiffness': 0, 'friction.film_velocity': REVISED_LUGRE,
    'friction.film_time_acceleration': REVISED_LUGRE,
    'friction.film_time_deceleration': REVISED_LUGRE,
    'friction.film_time_dwell': REVISED_LUGRE,
    'friction.dwell_coefficient': REVISED_LUGRE_DWELL,
    'friction.dwell_exponent': REVISED_LUGRE_DWELL, 'cylinder.moving_mass': 0,
}  # fmt: skip
"""Parameters that are identified from the motion -> the first friction law that has it."""

GAS, FORCE, SENSOR = 'gas', 'force', 'sensor'
"""What a candidate shows in."""
GAIN_SCALE = 0.05
"""What 1 is to the fit of a gain [-]."""
LARGEST = 100.0
"""Of a logarithm, beyond all ranges [-]."""
CALIBRATION = 'sensors.gains'
"""Errors of gain within the class of the sensors: neither a wrong model nor an effect."""
VOLTAGE_RANGE = 0.15
"""How far a valve's opening voltage may be off [V]."""
FACTOR = 2.0
"""How far any other parameter may be off: by this factor, either way [-]."""
TRIED = (0.85, 1.18)
"""Factors at which a parameter is screened [-]."""
TRIED_VOLTAGES = (-0.02, 0.02)
"""Shifts at which an opening voltage is screened [V]."""


@dataclass(frozen=True)
class Coordinate:
    """
    A number to be fitted, and how the fit sees it.

    :param name: of the parameter
    :param quantity: unit and meaning
    :param low, high: range [unit]
    :param scale: what 1 is to the fit: a factor of e for a logarithmic one [-], else [unit]
    :param logarithmic: whether the fit varies the logarithm
    :param null: value without the explanation [unit]
    """

    name: str
    quantity: Quantity
    low: float
    high: float
    scale: float
    logarithmic: bool
    null: float = 0.0

    def to_internal(self, value: float) -> float:
        """Return what the fit sees of a value."""
        inside = min(max(value, self.low), self.high)
        return float(np.log(inside)) if self.logarithmic else inside / self.scale

    def from_internal(self, seen: float) -> float:
        """Return the value that the fit sees so, within the range."""
        value = float(np.exp(min(seen, LARGEST))) if self.logarithmic else seen * self.scale
        return min(max(value, self.low), self.high)

    def scaled(self, seen: float, factor: float) -> float:
        """Return what the fit sees of a value that is so many times as far from the null."""
        return self.to_internal(self.null + factor * (self.from_internal(seen) - self.null))

    @property
    def bounds(self) -> tuple[float, float]:
        """The range as the fit sees it."""
        return self.to_internal(self.low), self.to_internal(self.high)


@dataclass(frozen=True)
class Candidate:
    """
    A possible explanation.

    :param name: of the effect, or section.name of the parameter
    :param balance: what it acts on
    :param coordinates: what is to be fitted
    :param starts: values to start from, each of shape (len(coordinates),)
    :param was: value of a parameter in the given model [SI], NaN for an effect
    """

    name: str
    balance: str
    coordinates: tuple[Coordinate, ...]
    starts: tuple[tuple[float, ...], ...]
    # NaN is not even itself once a worker has sent it back
    was: float = field(default=math.nan, compare=False)

    @property
    def is_effect(self) -> bool:
        """Whether it is an effect."""
        return '.' not in self.name

    @property
    def is_parameter(self) -> bool:
        """Whether it is a parameter of the model."""
        return not self.is_effect and self.name != CALIBRATION

    @property
    def group(self) -> str:
        """What it shows in: gas, force or sensor."""
        if not self.is_effect:
            return self.balance
        balance = library.load(self.name).balance
        if balance in READING_BALANCES:
            return SENSOR
        return GAS if balance in GAS_BALANCES else FORCE

    @property
    def describes(self) -> bool:
        """Whether it only describes."""
        return self.is_effect and library.load(self.name).describes

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis with this explanation [SI]."""
        if self.is_effect:
            changed = {c.name: v for c, v in zip(self.coordinates, values, strict=True)}
            return hypothesis.with_effect(
                self.name, library.load(self.name).null._replace(**changed)
            )
        if self.name == CALIBRATION:
            x, p1, p2 = values
            return replace(hypothesis, gains=(float(x), float(p1), float(p2)))
        section, name = self.name.split('.')
        old = getattr(getattr(hypothesis.model, section), name)
        if isinstance(old, tuple):  # all elements of F(z) alike
            new: Any = tuple(values[0] / sum(old) * item for item in old)
        else:
            new = float(values[0])
        return hypothesis.with_parameter(section, name, new)


@dataclass(frozen=True)
class Condition(Candidate):
    """A condition that is not as the recordings state it."""

    @property
    def is_parameter(self) -> bool:
        """No: the model is not wrong."""
        return False

    @property
    def condition(self) -> str:
        """Its name."""
        return self.name.removeprefix(CONDITIONS)

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis that the condition is so many times what was stated."""
        return hypothesis.with_condition(self.condition, float(values[0]))


CONDITIONS = 'conditions.'
"""Before the name of a condition in that of a candidate."""


def condition(name: str, group: str, most: float) -> Condition:
    """
    Return a condition as a candidate.

    :param most: by which factor it may be off, either way [-]
    """
    quantity = Quantity('-', 1.0 / most, most, 'times what was stated')
    starts = tuple((most**share,) for share in (-0.3, 0.3))
    factor = Coordinate('times', quantity, 1.0 / most, most, 1.0, True, 1.0)
    return Condition(CONDITIONS + name, group, (factor,), starts)


def calibration(sensors: Sensors) -> Candidate | None:
    """Return the gains of the sensors as something to be fitted, None for calibrated ones."""
    classes = {
        'position': sensors.position_class,
        'pressure_1': sensors.pressure_class,
        'pressure_2': sensors.pressure_class,
    }
    if not any(classes.values()):
        return None
    coordinates = tuple(
        Coordinate(name, Quantity('-', 0.0, 2.0, 'gain of the sensor'), 1.0 - most - 1e-6,
                   1.0 + most + 1e-6, GAIN_SCALE, False, 1.0)
        for name, most in classes.items()
    )  # fmt: skip
    return Candidate(CALIBRATION, SENSOR, coordinates, ((1.0, 1.0, 1.0),))


def parameters(given: Hypothesis) -> Iterator[Candidate]:
    """Yield the parameters of the given model that may be wrong."""
    law = given.model.friction.model
    every = [parameter(given, name, GAS) for name in GAS_PARAMETERS]
    every += [
        parameter(given, name, FORCE)
        for name, first_law in FORCE_PARAMETERS.items()
        if law >= first_law
    ]
    # what is zero is switched off: no factor makes it another value
    yield from (one for one in every if one.coordinates[0].low < one.coordinates[0].high)


def parameter(given: Hypothesis, full_name: str, balance: str) -> Candidate:
    """Return a parameter of the given model as a candidate."""
    section, name = full_name.split('.')
    value = getattr(getattr(given.model, section), name)
    specification = specifications(SECTIONS[section])[name]
    quantity = cast(Quantity, getattr(specification, 'item', specification))
    was = float(sum(value)) if isinstance(value, tuple) else float(value)
    if quantity.unit == 'V':
        low, high = quantity.within(was - VOLTAGE_RANGE), quantity.within(was + VOLTAGE_RANGE)
        starts = tuple((was + shift,) for shift in TRIED_VOLTAGES)
        coordinate = Coordinate(name, quantity, low, high, 0.1, False, was)
    else:
        starts = tuple((was * factor,) for factor in TRIED)
        low, high = quantity.within(was / FACTOR), quantity.within(was * FACTOR)
        friction = given.model.friction
        if name == 'breakaway_force':
            low = max(low, friction.coulomb_force)
        if name == 'coulomb_force':
            high = min(high, max(friction.breakaway_force, was))
        coordinate = Coordinate(name, quantity, low, high, 1.0, True, was)
    return Candidate(full_name, balance, (coordinate,), starts, was)


def effects(given: Hypothesis, without: Sequence[str]) -> Iterator[Candidate]:
    """Yield the effects that the given model lacks and its friction law has room for."""
    law = FRICTION_MODELS[given.model.friction.model]
    for name in library.names():
        effect = library.load(name)
        fits = not effect.laws or law in effect.laws
        if name in given.effects or name in without or effect.describes or not fits:
            continue
        yield effect_candidate(name)


def effect_candidate(name: str) -> Candidate:
    """Return an effect of the library as a candidate."""
    effect = library.load(name)
    specs = specifications(effect.parameters)
    columns = list(zip(*effect.probes, strict=True))
    coordinates = tuple(
        effect_coordinate(key, cast(Quantity, specs[key]), column, null)
        for key, column, null in zip(specs, columns, effect.null, strict=True)
    )
    starts = tuple(tuple(float(v) for v in probe) for probe in effect.probes)
    return Candidate(name, balance_name(effect.balance), coordinates, starts)


def effect_coordinate(
    name: str, quantity: Quantity, probes: Sequence[float], null: float
) -> Coordinate:
    """Return how the fit sees a parameter of an effect."""
    logarithmic = quantity.low >= 0.0 and min(probes) > 0.0
    largest = max(abs(value) for value in probes) or 1.0
    low = max(quantity.low, 1e-3 * min(probes)) if logarithmic else quantity.low
    return Coordinate(name, quantity, low, quantity.high, largest, logarithmic, null)


def balance_name(balance: Balance) -> str:
    """Return the name of a balance for a reader."""
    return balance.name.lower().replace('_', ' ')
