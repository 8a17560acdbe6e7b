"""
Which causes the evidence asks for: regression on the residuals, robust and without restarts.

A candidate changes the residuals by what it adds to the modelled rates along the measured run. How
much of it is needed is found by least squares on the whitened residuals, robustly, as a few
windows are off by more than any noise says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from pneu_rig_ros.diagnosis.candidates import Candidate
from pneu_rig_ros.diagnosis.evidence import OUTLIER, Evidence, loss
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis

Floats = NDArray[np.float64]

SHARES = np.concatenate([np.linspace(0.1, 1.6, 16), [2.0, 3.0, 5.0, 8.0]])
"""Shares of a candidate's change of the residuals that are tried [-]."""
STEP = 1e-3
"""Of the finite differences, in units of a coordinate [-]: the rates have no noise of their own."""
SIMULATED_STEP = 1e-2
"""The same where the evidence holds simulations, which have noise of integration."""


@dataclass(frozen=True)
class Screened:
    """A candidate with the values of its best start, and the loss expected from there."""

    candidate: Candidate
    values: tuple[float, ...]
    loss: float


def screen(
    candidate: Candidate, given: Hypothesis, evidence: Evidence, here: Floats
) -> Screened:
    """
    Return what a candidate leaves at the best share of the change from its best start.

    Where slip follows slip no change is in proportion to its cause: a start counts as it is.

    :param here: residual without it, shape (n,)
    """
    tried, shares = [], SHARES if evidence.confirmation is None else np.ones(1)
    for start in candidate.starts:
        change = evidence.residual(candidate.apply(given, start)) - here
        losses = [loss(here + share * change) for share in shares]
        best = int(np.argmin(losses))
        values = scaled(candidate, start, float(shares[best]))
        tried.append(Screened(candidate, values, losses[best]))
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
    :param covariance: of what the fit sees, shape (coordinates, coordinates)
    """

    explanation: Explanation
    loss: float
    covariance: Floats


def fit(start: Explanation, given: Hypothesis, evidence: Evidence, rounds: int) -> Fit:
    """
    Return the explanation fitted to the evidence from a start.

    Simulations make hills between a start and the best values; the residuals of the weak form do
    not, so that these are fitted first.

    :param rounds: of the least-squares solver at most
    """
    if evidence.confirmation is not None:
        alone = replace(evidence, confirmation=None)
        smooth = fit(start, given, alone, rounds).explanation
        start = min((start, smooth),
                    key=lambda one: loss(evidence.residual(one.apply(given))))  # fmt: skip
    low, high = np.array([c.bounds for c in start.coordinates]).T
    step = STEP if evidence.confirmation is None else SIMULATED_STEP

    def residual(seen: Floats) -> Floats:
        return evidence.residual(start.moved(seen).apply(given))

    def slopes(seen: Floats) -> Floats:
        here, columns = residual(seen), []
        for index in range(seen.size):
            there = seen.copy()
            there[index] += step if seen[index] + step < high[index] else -step
            columns.append((residual(there) - here) / (there[index] - seen[index]))
        return np.column_stack(columns)

    first = np.clip(start.seen, low + 1e-6, high - 1e-6)
    solution = least_squares(
        residual, first, jac=slopes, bounds=(low, high), loss='soft_l1', f_scale=OUTLIER,
        max_nfev=rounds, xtol=1e-5, ftol=1e-5,
    )  # fmt: skip
    curvature = solution.jac.T @ solution.jac
    covariance: Floats = np.linalg.pinv(curvature, hermitian=True)
    return Fit(start.moved(solution.x), float(solution.cost), covariance)
