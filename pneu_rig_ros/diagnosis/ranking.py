"""
Which causes the residuals of the weak form ask for: regression, without any simulation.

A candidate changes the residuals by what it adds to the modelled rates along the measured run. How
much of it is needed is found by least squares on the whitened residuals, robustly, as a few
windows are off by more than any noise says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from pneu_rig_ros.diagnosis.balances import Comparison, Residuals
from pneu_rig_ros.diagnosis.candidates import Candidate
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.noise import NoiseModel, noise_model
from pneu_rig_ros.diagnosis.twins import Spread, factors_of, spread, with_bias

Floats = NDArray[np.float64]

SHARES = np.concatenate([np.linspace(0.1, 1.6, 16), [2.0, 3.0, 5.0, 8.0]])
"""Shares of a candidate's change of the residuals that are tried [-]."""
OUTLIER = 3.0
"""Standard deviations beyond which a residual counts linearly [-]."""
STEP = 1e-3
"""Of the finite differences, in units of a coordinate [-]: the rates have no noise of their own."""


@dataclass(frozen=True)
class Residual:
    """
    Runs with the noise of their residuals: what a hypothesis is judged by.

    :param comparisons: the runs
    :param noises: of each, all under one hypothesis
    :param spread: of its twins
    """

    comparisons: tuple[Comparison, ...]
    noises: tuple[NoiseModel, ...]
    spread: Spread

    @classmethod
    def of(
        cls, given: Hypothesis, comparisons: Sequence[Comparison], rng: np.random.Generator
    ) -> Residual:
        """Return the runs with the noise that they have if the hypothesis is true."""
        twins = spread(given, tuple(comparisons), rng)
        noises = [with_bias(noise_model(given, one, rng), one, twins.bias) for one in comparisons]
        return cls(tuple(comparisons), tuple(noises), twins)

    def of_each(self, hypothesis: Hypothesis) -> list[Residuals]:
        """Return the whitened residuals of each run."""
        every = []
        for one, noise, factors in zip(self.comparisons, self.noises, self.factors, strict=True):
            whitened = noise.whiten(one.residuals(hypothesis))
            every.append(Residuals(*(z / f for z, f in zip(whitened, factors, strict=True))))
        return every

    @cached_property
    def factors(self) -> list[Residuals]:
        """By how much wider than the noise each window of each run spreads [-]."""
        pairs = zip(self.comparisons, self.noises, strict=True)
        return [factors_of(self.spread, one, noise) for one, noise in pairs]

    def whitened(self, hypothesis: Hypothesis) -> Floats:
        """Return all residuals, independent and of standard deviation 1, shape (n,)."""
        parts = [part for run in self.of_each(hypothesis) for part in run]
        return np.clip(np.concatenate(parts), -FAR, FAR)


FAR = 1e4
"""Residuals are not taken to be farther off [-]."""


def loss(whitened: Floats) -> float:
    """Return half the sum of squares, growing linearly beyond ``OUTLIER`` (pseudo-Huber) [-]."""
    scaled = (whitened / OUTLIER) ** 2
    return float(OUTLIER**2 * np.sum(np.sqrt(1.0 + scaled) - 1.0))


@dataclass(frozen=True)
class Screened:
    """A candidate with the values of its best start, and the loss expected from there."""

    candidate: Candidate
    values: tuple[float, ...]
    loss: float


def screen(candidate: Candidate, given: Hypothesis, residual: Residual, here: Floats) -> Screened:
    """Return what a candidate leaves at the best share of the change from its best start."""
    tried = []
    for start in candidate.starts:
        change = residual.whitened(candidate.apply(given, start)) - here
        losses = [loss(here + share * change) for share in SHARES]
        best = int(np.argmin(losses))
        tried.append(Screened(candidate, scaled(candidate, start, float(SHARES[best])),
                              losses[best]))  # fmt: skip
    return min(tried, key=lambda one: one.loss)


def scaled(candidate: Candidate, start: Sequence[float], share: float) -> tuple[float, ...]:
    """Return a start so many times as strong, within its range: its first unit is its strength."""
    unit = candidate.coordinates[0].quantity.unit
    return tuple(
        c.outward(c.scaled(c.inward(value), share)) if c.quantity.unit == unit else value
        for c, value in zip(candidate.coordinates, start, strict=True)
    )


@dataclass(frozen=True)
class Fit:
    """
    A fitted explanation.

    :param explanation: with the best values
    :param loss: that it leaves [-]
    :param deviations: standard deviation of what the fit sees, shape (coordinates,)
    """

    explanation: Explanation
    loss: float
    deviations: Floats


def fit(start: Explanation, given: Hypothesis, residual: Residual, rounds: int) -> Fit:
    """
    Return the explanation fitted to the residuals from a start.

    :param rounds: of the least-squares solver at most
    """
    low, high = np.array([c.bounds for c in start.coordinates]).T

    def whitened(seen: Floats) -> Floats:
        return residual.whitened(start.moved(seen).apply(given))

    def slopes(seen: Floats) -> Floats:
        here, columns = whitened(seen), []
        for index in range(seen.size):
            there = seen.copy()
            there[index] += STEP if seen[index] + STEP < high[index] else -STEP
            columns.append((whitened(there) - here) / (there[index] - seen[index]))
        return np.column_stack(columns)

    first = np.clip(start.seen, low + 1e-6, high - 1e-6)
    solution = least_squares(
        whitened, first, jac=slopes, bounds=(low, high), loss='soft_l1', f_scale=OUTLIER,
        max_nfev=rounds, xtol=1e-5, ftol=1e-5,
    )  # fmt: skip
    curvature = solution.jac.T @ solution.jac
    deviations = np.sqrt(np.maximum(np.diag(np.linalg.pinv(curvature, hermitian=True)), 0.0))
    return Fit(start.moved(solution.x), float(solution.cost), deviations)
