"""
Which causes the dataset asks for: regression on the residuals, robust and without restarts.

A candidate changes the residuals by what it adds to the modelled rates along the measured run. How
much of it is needed is found by least squares on the whitened residuals, robustly, as a few
windows are off by more than any noise says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from pneu_rig_ros.diagnosis.candidates import Candidate
from pneu_rig_ros.diagnosis.dataset import OUTLIER, Dataset, loss
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis

Floats = NDArray[np.float64]

SHARES = np.concatenate([np.linspace(0.1, 1.6, 16), [2.0, 3.0, 5.0, 8.0]])
"""Shares of a candidate's change of the residuals that are tried [-]."""
STEP = 1e-3
"""Of the finite differences, in units of a coordinate [-]: rates have no noise of their own."""
SIMULATED_STEP = 1e-2
"""The same where the dataset holds simulations, which have noise of integration."""


@dataclass(frozen=True)
class Screened:
    """
    A candidate and what it may leave.

    :param values: of its best start
    :param loss: expected from there [-]
    :param others: values of further starts worth a fit, where there are hills between them
    """

    candidate: Candidate
    values: tuple[float, ...]
    loss: float
    others: tuple[tuple[float, ...], ...] = ()


def screen(candidate: Candidate, given: Hypothesis, dataset: Dataset, here: Floats) -> Screened:
    """
    Return what a candidate leaves at the best share of the change from its best start.

    Where slip follows slip no change is in proportion to its cause: a start counts as it is.

    :param here: residual without it, shape (n,)
    """
    tried, shares = [], SHARES if dataset.cycles is None else np.ones(1)
    for start in candidate.starts:
        change = dataset.residual(candidate.apply(given, start)) - here
        losses = [loss(here + share * change) for share in shares]
        best = int(np.argmin(losses))
        values = scaled(candidate, start, float(shares[best]))
        tried.append(Screened(candidate, values, losses[best]))
    first, *rest = sorted(tried, key=lambda one: one.loss)
    hills = dataset.cycles is not None and len(first.values) > 1
    return replace(first, others=tuple(one.values for one in rest[:1] if hills))


def scaled(candidate: Candidate, start: Sequence[float], share: float) -> tuple[float, ...]:
    """Return a start so many times as strong, within its range: its first unit is its strength."""
    unit = candidate.coordinates[0].quantity.unit
    return tuple(
        c.from_internal(c.scaled(c.to_internal(value), share))
        if c.quantity.unit == unit
        else value
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


def fit(start: Explanation, given: Hypothesis, dataset: Dataset, rounds: int) -> Fit:
    """
    Return the explanation fitted to the dataset from a start.

    Simulations make hills between a start and the best values; the residuals of the weak form do
    not, so that these are fitted first.

    :param rounds: of the least-squares solver at most
    """
    if dataset.cycles is not None:
        alone = fit(start, given, replace(dataset, cycles=None), rounds)
        start = min((start, *along_valley(alone)),
                    key=lambda one: loss(dataset.residual(one.apply(given))))  # fmt: skip
    low, high = np.array([c.bounds for c in start.coordinates]).T
    step = STEP if dataset.cycles is None else SIMULATED_STEP

    def residual(seen: Floats) -> Floats:
        return dataset.residual(start.with_theta(seen).apply(given))

    def slopes(seen: Floats) -> Floats:
        here, columns = residual(seen), []
        for index in range(seen.size):
            there = seen.copy()
            there[index] += step if seen[index] + step < high[index] else -step
            columns.append((residual(there) - here) / (there[index] - seen[index]))
        return np.column_stack(columns)

    first = np.clip(start.theta, low + 1e-6, high - 1e-6)
    solution = least_squares(
        residual, first, jac=slopes, bounds=(low, high), loss='soft_l1', f_scale=OUTLIER,
        max_nfev=rounds, xtol=1e-5, ftol=1e-5,
    )  # fmt: skip
    curvature = solution.jac.T @ solution.jac
    covariance: Floats = np.linalg.pinv(curvature, hermitian=True)
    return Fit(start.with_theta(solution.x), float(solution.cost), covariance)


FAR_STARTS = 2
"""Of the starts of the last cause, so many are tried besides."""


def far_starts(explanation: Explanation, given: Hypothesis, dataset: Dataset) -> list[Explanation]:
    """Return an explanation with its last cause as it was before any fit, the best first."""
    last = explanation.parts[-1]
    starts = [replace(explanation, values=(*explanation.values[:-1], one)) for one in last.starts]
    ordered = sorted(starts, key=lambda one: loss(dataset.residual(one.apply(given))))
    return ordered[:FAR_STARTS]


ACROSS = 0.2
"""Size of the simplex that looks for a lower place across hills, as the fit sees it [-]."""
STEPS = 100
"""Its steps at most, for each coordinate."""


def polished(found: Fit, given: Hypothesis, dataset: Dataset) -> Fit:
    """Return a fit to simulations, moved across the hills that a slip more or less makes."""
    start = found.explanation
    low, high = np.array([c.bounds for c in start.coordinates]).T
    simplex = np.vstack([start.theta, start.theta + ACROSS * np.eye(start.theta.size)])
    solution = minimize(
        lambda seen: loss(dataset.residual(start.with_theta(seen).apply(given))), start.theta,
        method='Nelder-Mead', bounds=list(zip(low, high, strict=True)),
        options={'initial_simplex': np.clip(simplex, low, high), 'xatol': 1e-3, 'fatol': 0.1,
                 'maxfev': STEPS * start.theta.size},
    )  # fmt: skip
    if solution.fun >= found.loss:
        return found
    return replace(found, explanation=start.with_theta(solution.x), loss=float(solution.fun))


VALLEY = (-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0)
"""Steps along the valley in which the residuals leave the values open [standard deviations]."""
FARTHER = (-0.4, -0.2, -0.1, 0.1, 0.2, 0.4)
"""
Steps along the valley of a fit to simulations, as the fit sees it [-]: within a hill that one slip
makes it is steep, and its standard deviations say nothing of the valley's length.
"""


def along_valley(found: Fit) -> list[Explanation]:
    """Return a fit, and what the residuals cannot tell from it: along the widest direction."""
    deviation, direction = _widest(found)
    seen, step = found.explanation.theta, deviation * direction
    return [found.explanation.with_theta(seen + times * step) for times in VALLEY]


def farther_along(found: Fit) -> list[Explanation]:
    """Return what is farther along the valley of a fit to simulations, beyond hills."""
    seen, (_, direction) = found.explanation.theta, _widest(found)
    return [found.explanation.with_theta(seen + step * direction) for step in FARTHER]


def _widest(found: Fit) -> tuple[float, Floats]:
    """Return the widest direction of a fit, and its standard deviation there [-]."""
    variances, directions = np.linalg.eigh(found.covariance)
    return float(np.sqrt(max(variances[-1], 0.0))), directions[:, -1]
