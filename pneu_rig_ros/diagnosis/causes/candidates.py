"""Candidate causes of a gap - parameters, conditions, effects - and explanations made of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES
from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.quantity import Quantity, specifications

GAS, FORCE, SENSOR = 'gas', 'force', 'sensor'
"""Groups of candidates, by where they show."""
CALIBRATION = 'sensors.gains'
"""Errors within the class of sensors and gauges: neither a wrong model nor an effect."""
CONDITIONS = 'conditions.'
"""Prefix of a condition in the name of a candidate."""
PARAMETER_RATIO = 2.0
"""Largest ratio of a parameter to its value in the model, or its inverse [-]."""
LARGEST_LOGARITHM = 100.0
"""Beyond all ranges; keeps the exponential finite [-]."""


@dataclass(frozen=True)
class Coordinate:
    """
    A number to be fitted, with its internal representation in the solver.

    :param name: of the parameter
    :param low, high: range [unit]
    :param scale: unit of the internal value: a factor of e for a logarithm [-], else [unit]
    :param logarithmic: whether the internal value is the logarithm
    :param null: value without the explanation [unit]
    :param deviation: standard deviation of the internal value before the data, 0 where all values
        of the range are alike
    """

    name: str
    quantity: Quantity
    low: float
    high: float
    scale: float
    logarithmic: bool
    null: float = 0.0
    deviation: float = 0.0

    def to_internal(self, value: float) -> float:
        """Return the internal representation of a value."""
        inside = min(max(value, self.low), self.high)
        return float(np.log(inside)) if self.logarithmic else inside / self.scale

    def from_internal(self, theta: float) -> float:
        """Return the value of an internal representation, within the range."""
        if self.logarithmic:
            value = float(np.exp(min(theta, LARGEST_LOGARITHM)))
        else:
            value = theta * self.scale
        return min(max(value, self.low), self.high)

    def amplified(self, value: float, factor: float) -> float:
        """Return a value whose distance from the null is multiplied, within the range."""
        inside = self.from_internal(self.to_internal(value))
        amplified = self.to_internal(self.null + factor * (inside - self.null))
        return self.from_internal(amplified)

    def error(self, value: float) -> float:
        """Return the distance of a value from the null [standard deviations before the data]."""
        return (self.to_internal(value) - self.to_internal(self.null)) / self.deviation

    def negative_log_prior(self, value: float) -> float:
        """
        Return the negative log density before the data, relative to that of a parameter [-].

        It decides between a gauge that is a little off and a parameter that acts alike: the supply
        and the intake coefficient while the intake is choked. Where the data do not determine an
        error of calibration, it is none.
        """
        if self.deviation <= 0.0:
            return 0.0
        width = 2.0 * math.log(PARAMETER_RATIO)
        density = self.deviation * math.sqrt(2.0 * math.pi)
        return 0.5 * self.error(value) ** 2 - math.log(width / density)

    @property
    def bounds(self) -> tuple[float, float]:
        """The range in internal representation."""
        return self.to_internal(self.low), self.to_internal(self.high)


@dataclass(frozen=True)
class Candidate:
    """
    A possible explanation: an effect, a parameter of the model, or a condition.

    :param name: of the effect, section.name of the parameter, conditions.name of the condition
    :param balance: on which it acts
    :param starts: values from which a fit starts, each of shape (len(coordinates),)
    :param model_value: of a parameter in the given model [SI], NaN for an effect
    :param readings: name of a choice of the friction law, and its value with which an effect acts
    """

    name: str
    balance: str
    coordinates: tuple[Coordinate, ...]
    starts: tuple[tuple[float, ...], ...]
    # a NaN that a worker has sent back does not equal itself
    model_value: float = field(default=math.nan, compare=False)
    readings: tuple[tuple[str, int], ...] = ()

    @property
    def is_effect(self) -> bool:
        """Whether it is an effect of the library."""
        return self.name in library.names()

    @property
    def is_parameter(self) -> bool:
        """Whether it is a parameter of the model."""
        return self.name.split('.')[0] in SECTIONS

    @property
    def is_condition(self) -> bool:
        """Whether it is a condition that is not as stated, by a ratio or by a difference."""
        return self.name.startswith(CONDITIONS)

    def keeping(self, keep: Sequence[int]) -> Candidate:
        """Return the candidate with the coordinates of some indices, the others as without it."""

        def kept(row: Sequence[Any]) -> tuple[Any, ...]:
            return tuple(row[i] for i in keep)

        starts = tuple(dict.fromkeys(map(kept, self.starts)))
        return replace(self, coordinates=kept(self.coordinates), starts=starts)

    @property
    def effect(self) -> str:
        """Its name, or that of the effect of which it is another form."""
        return self.name

    @property
    def group(self) -> str:
        """Where it shows: gas, force or sensor."""
        if not self.is_effect:
            return self.balance
        balance = library.load(self.name).balance
        if balance in READING_BALANCES:
            return SENSOR
        return GAS if balance in GAS_BALANCES else FORCE

    @property
    def strengths(self) -> list[Coordinate]:
        """Coordinates to which what it changes is proportional, near enough to screen it."""
        if self.is_effect:
            names = library.load(self.name).proportional
            return [coordinate for coordinate in self.coordinates if coordinate.name in names]
        return list(self.coordinates)

    def amplified(self, values: Sequence[float], factor: float) -> tuple[float, ...]:
        """Return values with which it changes a multiple, within their ranges [SI]."""
        strengths, pairs = self.strengths, zip(self.coordinates, values, strict=True)
        return tuple(c.amplified(v, factor) if c in strengths else v for c, v in pairs)

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis with this explanation [SI]."""
        if self.is_effect:
            changed = {c.name: v for c, v in zip(self.coordinates, values, strict=True)}
            parameters = library.load(self.name).null._replace(**changed)
            for name, reading in self.readings:
                hypothesis = hypothesis.with_parameter('friction', name, reading)
            return hypothesis.with_effect(self.name, parameters)
        if self.name == CALIBRATION:
            names = [coordinate.name for coordinate in self.coordinates]
            return _calibrated(hypothesis, dict(zip(names, map(float, values), strict=True)))
        if self.is_condition:
            return hypothesis.with_condition(self.name.removeprefix(CONDITIONS), float(values[0]))
        section, name = self.name.split('.')
        old = getattr(getattr(hypothesis.model, section), name)
        new: Any = float(values[0])
        if isinstance(old, tuple):  # all elements of F(z) by the same factor
            new = tuple(values[0] / sum(old) * item for item in old)
        return hypothesis.with_parameter(section, name, new)


def of_one(
    name: str, group: str, coordinate: Coordinate, starts: Iterable[float], value: float = math.nan
) -> Candidate:
    """Return a candidate of one coordinate; ``value`` is that of a parameter in the model [SI]."""
    return Candidate(name, group, (coordinate,), tuple((start,) for start in starts), value)


def effect_candidate(name: str) -> Candidate:
    """Return an effect of the library as a candidate."""
    effect = library.load(name)
    coordinates = []
    columns = zip(*effect.probes, strict=True)
    specs = specifications(effect.parameters).items()
    for (key, spec), probes, null in zip(specs, columns, effect.null, strict=True):
        quantity = cast(Quantity, spec)
        logarithmic = quantity.low >= 0.0 and min(probes) > 0.0
        low = max(quantity.low, 1e-3 * min(probes)) if logarithmic else quantity.low
        scale = max(abs(value) for value in probes) or 1.0
        coordinates.append(Coordinate(key, quantity, low, quantity.high, scale, logarithmic, null))
    starts = tuple(tuple(float(value) for value in probe) for probe in effect.probes)
    balance = effect.balance.name.lower().replace('_', ' ')
    return Candidate(name, balance, tuple(coordinates), starts)


def _calibrated(hypothesis: Hypothesis, values: Mapping[str, float]) -> Hypothesis:
    """Return a hypothesis with sensors and supply as calibrated, see ``candidate_pool``."""
    gains = values['position'], values['pressure_1'], values['pressure_2']
    offsets = values['offset_1'], values['offset_2']
    hypothesis = replace(hypothesis, gains=gains, pressure_offsets=offsets)
    if 'supply_pressure' in values:
        warmer = values['supply_temperature'] * hypothesis.model.gas.supply_temperature
        hypothesis = hypothesis.with_condition('supply_pressure', values['supply_pressure'])
        hypothesis = hypothesis.with_parameter('gas', 'supply_temperature', warmer)
    return hypothesis


@dataclass(frozen=True)
class Explanation:
    """
    What a given hypothesis lacks: candidates with the fitted values of their coordinates [SI].

    :param given: hypothesis to which the parts are applied one by one
    """

    given: Hypothesis
    parts: tuple[Candidate, ...] = ()
    values: tuple[tuple[float, ...], ...] = ()

    @property
    def by_part(self) -> list[tuple[Candidate, tuple[float, ...]]]:
        """The parts with their values."""
        return list(zip(self.parts, self.values, strict=True))

    @property
    def hypothesis(self) -> Hypothesis:
        """The given hypothesis with all parts."""
        explained = self.given
        for part, values in self.by_part:
            explained = part.apply(explained, values)
        return explained

    @property
    def name(self) -> str:
        """The names of all parts."""
        return ' + '.join(part.name for part in self.parts)

    @property
    def forms(self) -> tuple[tuple[str, object, int], ...]:
        """The names of all parts, with the readings of their laws, and how general these are."""
        return tuple((part.name, part.readings, len(part.coordinates)) for part in self.parts)

    @property
    def causes(self) -> list[str]:
        """The names of all parts but the calibration, which is fitted with any cause."""
        return [part.name for part in self.parts if part.name != CALIBRATION]

    @property
    def coordinates(self) -> list[Coordinate]:
        """The coordinates of all parts."""
        return [coordinate for part in self.parts for coordinate in part.coordinates]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Least and largest theta, shape (len(coordinates),) each."""
        low, high = np.array([c.bounds for c in self.coordinates]).reshape(-1, 2).T
        return low, high

    @property
    def calibrates(self) -> list[bool]:
        """Whether each coordinate is one of the calibration."""
        return [part.name == CALIBRATION for part in self.parts for _ in part.coordinates]

    @property
    def errors(self) -> Floats:
        """Values as errors [standard deviations before the data], of those that have these."""
        return np.array([c.error(value) for c, value in self._pairs if c.deviation > 0.0])

    @property
    def theta(self) -> Floats:
        """Internal representation of all values, shape (len(coordinates),)."""
        return np.array([coordinate.to_internal(value) for coordinate, value in self._pairs])

    @property
    def negative_log_prior(self) -> float:
        """Negative log density of all values before the data [-]."""
        return sum(coordinate.negative_log_prior(value) for coordinate, value in self._pairs)

    @property
    def _pairs(self) -> Iterator[tuple[Coordinate, float]]:
        values = (value for part in self.values for value in part)
        return zip(self.coordinates, values, strict=True)

    def with_theta(self, theta: Floats) -> Explanation:
        """Return the explanation with other values, in internal representation."""
        pairs = zip(self.coordinates, theta, strict=True)
        values = iter([coordinate.from_internal(float(value)) for coordinate, value in pairs])
        parts = tuple(tuple(next(values) for _ in part.coordinates) for part in self.parts)
        return replace(self, values=parts)

    def with_part(self, part: Candidate, values: Sequence[float]) -> Explanation:
        """Return the explanation with one more part."""
        parts, fitted = (*self.parts, part), (*self.values, tuple(values))
        return Explanation(self.given, parts, fitted)

    def without(self, part: Candidate) -> Explanation:
        """Return the explanation without a part and other forms of it, with its other values."""
        kept = Explanation(self.given)
        for each, values in self.by_part:
            if part.name not in (each.name, each.effect):
                kept = kept.with_part(each, values)
        return kept
