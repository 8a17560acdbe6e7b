"""Fit of one or more explanations by simulation: multiple shooting, restarted at every rest."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from pneu_rig_ros.gap.candidates import CALIBRATION, Candidate, Coordinate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode

Floats = NDArray[np.float64]
_T = TypeVar('_T')

STEP, FINE_STEP = 1e-2, 1e-3
"""
Steps of the finite differences, in units of a coordinate [-]: far above the integrator's noise; so
fine that a fit does not stop in a valley that two coordinates make.
"""
STRENGTHS = (0.3, 0.6, 1.0, 1.7, 3.0)
"""Multiples of a start's strength from which the best is fitted [-]."""
SCANS = 2
"""The best is looked for again from there as often at most, if it is the first or the last."""
NORMAL = 1.96
"""Half-width of an interval of 95 % in standard deviations [-]."""


@dataclass(frozen=True)
class Explanation:
    """
    Candidates with values.

    :param parts: the candidates
    :param values: of each one's coordinates [SI]
    """

    parts: tuple[Candidate, ...] = ()
    values: tuple[tuple[float, ...], ...] = ()

    @property
    def name(self) -> str:
        """The names of all parts."""
        return ' + '.join(part.name for part in self.parts)

    @property
    def causes(self) -> list[str]:
        """The names of all parts but the gains of the sensors, which are fitted along."""
        return [part.name for part in self.parts if part.name != CALIBRATION]

    def apply(self, given: Hypothesis) -> Hypothesis:
        """Return the given hypothesis with all explanations."""
        for part, values in zip(self.parts, self.values, strict=True):
            given = part.apply(given, values)
        return given

    def plus(self, part: Candidate, values: Sequence[float]) -> Explanation:
        """Return the explanation with one more part."""
        return Explanation((*self.parts, part), (*self.values, tuple(values)))

    def without(self, index: int) -> Explanation:
        """Return the explanation without one of its parts."""
        keep = [i for i in range(len(self.parts)) if i != index]
        return Explanation(tuple(self.parts[i] for i in keep), tuple(self.values[i] for i in keep))

    def joined(self, other: Explanation) -> Explanation:
        """Return the explanation with all parts of another one."""
        return Explanation(self.parts + other.parts, self.values + other.values)

    @property
    def coordinates(self) -> list[Coordinate]:
        """All coordinates in a row."""
        return [coordinate for part in self.parts for coordinate in part.coordinates]

    @property
    def modes(self) -> tuple[Mode, ...]:
        """The predictions that show it."""
        return tuple(mode for mode in Mode if any(mode in part.modes for part in self.parts))

    @property
    def seen(self) -> Floats:
        """What the fit sees of all values in a row."""
        flat = [value for values in self.values for value in values]
        pairs = zip(self.coordinates, flat, strict=True)
        return np.array([coordinate.inward(value) for coordinate, value in pairs])

    def moved(self, seen: Floats) -> Explanation:
        """Return the explanation with other values, as the fit sees them."""
        pairs = zip(self.coordinates, seen, strict=True)
        flat = iter([coordinate.outward(float(value)) for coordinate, value in pairs])
        values = tuple(tuple(next(flat) for _ in part.coordinates) for part in self.parts)
        return Explanation(self.parts, values)


def first_of_each(items: Iterable[_T], explanation: Callable[[_T], Explanation]) -> list[_T]:
    """Return the items without those whose explanation has the parts of an earlier one's."""
    first: dict[frozenset[Candidate], _T] = {}
    for one in items:
        first.setdefault(frozenset(explanation(one).parts), one)
    return list(first.values())


@dataclass(frozen=True)
class Fit:
    """
    A fitted explanation.

    :param explanation: with the best values
    :param cost: at them, on the experiments of the fit [-]
    :param deviations: standard deviation of what the fit sees, shape (coordinates,)
    :param quantile: half-width of an interval of 95 % in these [-]
    """

    explanation: Explanation
    cost: float
    deviations: Floats
    quantile: float = NORMAL

    def intervals(self) -> list[tuple[float, float]]:
        """Return an interval of 95 % for each coordinate [SI]."""
        triples = zip(
            self.explanation.coordinates, self.explanation.seen, self.deviations, strict=True
        )
        return [
            (c.outward(value - self.quantile * d), c.outward(value + self.quantile * d))
            for c, value, d in triples
        ]


def fit(
    given: Hypothesis, start: Explanation, evidence: Evidence, modes: Sequence[Mode], rounds: int,
    step: float = STEP,
) -> Fit:  # fmt: skip
    """
    Return the explanation fitted to the evidence from a start.

    :param rounds: of the least-squares solver at most
    :param step: of the finite differences [-]
    """
    low, high = np.array([c.bounds for c in start.coordinates]).T

    @lru_cache(maxsize=1)
    def kept(seen: tuple[float, ...]) -> Floats:
        return evidence.residual(start.moved(np.array(seen)).apply(given), modes)

    def residual(seen: Floats) -> Floats:
        return kept(tuple(seen.tolist()))

    def slopes(seen: Floats) -> Floats:
        here, columns = residual(seen), []
        for index in range(seen.size):
            there = seen.copy()
            there[index] += step if seen[index] + step < high[index] else -step
            columns.append((residual(there) - here) / (there[index] - seen[index]))
        return np.column_stack(columns)

    first = np.clip(start.seen, low + 1e-6, high - 1e-6)
    solution = least_squares(
        residual, first, jac=slopes, bounds=(low, high), max_nfev=rounds, xtol=1e-4, ftol=1e-4,
        gtol=1e-8,
    )  # fmt: skip
    return Fit(start.moved(solution.x), 2.0 * float(solution.cost), _deviations(solution))


def without_weakest(result: Fit, own: int, count: int) -> Explanation:
    """
    Return an explanation without the parameters whose change is the least significant (Wald).

    :param own: parts at the front that stay; the others have one coordinate each
    :param count: of the parts to be taken out
    """
    explanation = result.explanation
    front = sum(len(part.coordinates) for part in explanation.parts[:own])
    null = [coordinate.inward(coordinate.null) for coordinate in explanation.coordinates]
    changes = np.abs(explanation.seen - null) / np.maximum(result.deviations, 1e-12)
    for index in sorted(np.argsort(changes[front:])[:count].tolist(), reverse=True):
        explanation = explanation.without(own + index)
    return explanation


def scanned(
    starts: Sequence[Explanation], given: Hypothesis, evidence: Evidence, modes: Sequence[Mode]
) -> tuple[float, Explanation]:
    """Return the least cost over the strengths of some starts, and the explanation there."""

    def cost(one: Explanation) -> float:
        return evidence.cost(one.apply(given), modes)

    return min((scan(start, cost) for start in starts), key=lambda one: one[0])


def scan(start: Explanation, cost: Callable[[Explanation], float]) -> tuple[float, Explanation]:
    """
    Return the least cost over some strengths of the last part, and the explanation there.

    A least-squares solver goes downhill only, and slips that come at the wrong time make hills.
    """
    for _ in range(SCANS):
        tried = [strengthened(start, factor) for factor in STRENGTHS]
        costs = [cost(one) for one in tried]
        index = int(np.argmin(costs))
        start = tried[index]
        if 0 < index < len(STRENGTHS) - 1:
            break
    return costs[index], start


def strengthened(explanation: Explanation, factor: float) -> Explanation:
    """
    Return an explanation whose last part is so many times as strong.

    The first coordinate of a part is its strength, and so are those in the same unit: a leak has
    two areas. A description has all of its terms scaled.
    """
    seen, last = explanation.seen, explanation.parts[-1]
    first, unit = seen.size - len(last.coordinates), last.coordinates[0].quantity.unit
    for index, coordinate in enumerate(last.coordinates, start=first):
        if last.describes or coordinate.quantity.unit == unit:
            seen[index] = coordinate.scaled(float(seen[index]), factor)
    return explanation.moved(seen)


def _deviations(solution: object) -> Floats:
    """Return standard deviations from the curvature, with the residual as its own measure."""
    jacobian, residual = solution.jac, solution.fun  # type: ignore[attr-defined]
    spare = max(residual.size - jacobian.shape[1], 1)
    variance = float(residual @ residual) / spare
    curvature = jacobian.T @ jacobian
    covariance = variance * np.linalg.pinv(curvature, hermitian=True)
    deviations: Floats = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return deviations
