"""
Fits of explanations by robust least squares on the whitened residuals.

Losses are pseudo-Huber, as a few windows are farther off than the noise model accounts for.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.optimize import least_squares

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import OUTLIER, Dataset, loss

STEP = 1e-3
"""Of the finite differences, internal units [-]: rates have no noise of their own."""
SIMULATED_STEP = 1e-2
"""The same with simulated cycles, which have noise of integration."""
CONVERGED, SIMULATED_CONVERGED = 1e-5, 1e-4
"""Relative change of loss or values that ends a fit [-]; simulated, less is that noise."""
FIRST_ROUNDS, ROUNDS, FINAL_ROUNDS = 4, 15, 40
"""
Evaluations of the least-squares solver: in first fits, which choose those that are fitted further,
in the comparison of these, and of the accepted fit.
"""
VALLEY = (-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0)
"""Steps along the direction that the residuals determine least [standard deviations]."""

UNIFORM = 12.0
"""Square of a range by the variance of a number that is anywhere in it [-]."""


@dataclass(frozen=True)
class Fit:
    """
    A fitted explanation.

    :param explanation: with the best values
    :param loss: that remains [-]
    :param covariance: of theta, shape (coordinates, coordinates),
        empty of values that are not fitted
    """

    explanation: Explanation
    loss: float = 0.0
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def widest(self) -> tuple[float, Floats]:
        """The least determined direction of theta, and its standard deviation [-]."""
        variances, directions = np.linalg.eigh(self.covariance)
        return float(np.sqrt(max(variances[-1], 0.0))), directions[:, -1]


def fit_from_valley(start: Explanation, given: Hypothesis, dataset: Dataset, rounds: int) -> Fit:
    """
    Return the explanation fitted to a dataset from the best of a start and of a valley.

    The valley is what the residuals of the weak form alone leave open. Simulations have local
    minima between a start and the best values, which these have not; free runs, which are the data
    only of what is weak, have none.
    """
    if dataset.cycles is None or dataset.runs_freely:
        return fit(start, given, dataset, rounds)
    weak = fit(start, given, dataset.without_cycles, rounds)
    deviation, direction = weak.widest
    step, theta = deviation * direction, weak.explanation.theta
    points = [weak.explanation.with_theta(theta + t * step) for t in VALLEY]
    best = min((start, *points), key=lambda point: loss_of(point, given, dataset))
    return fit(best, given, dataset, rounds)


def fit(start: Explanation, given: Hypothesis, dataset: Dataset, rounds: int) -> Fit:
    """Return the explanation fitted to a dataset from a start."""
    low, high = np.array([c.bounds for c in start.coordinates]).T
    delta, converged = STEP, CONVERGED
    if dataset.cycles is not None:
        delta, converged = SIMULATED_STEP, SIMULATED_CONVERGED

    @lru_cache(maxsize=1)  # the solver asks for the Jacobian where it was last
    def residual_at(theta: bytes) -> Floats:
        return _residual(start.with_theta(np.frombuffer(theta)), given, dataset)

    def residual(theta: Floats) -> Floats:
        return residual_at(theta.tobytes()).copy()  # the solver scales it in place

    columns: dict[int, Floats] = {}

    def jacobian(theta: Floats) -> Floats:
        base = residual(theta)
        for index in range(theta.size):
            if index in columns and start.calibrates[index]:
                continue  # errors of a percent act in proportion: one column serves all steps
            shifted = theta.copy()
            shifted[index] += delta if theta[index] + delta < high[index] else -delta
            changed = _residual(start.with_theta(shifted), given, dataset)
            columns[index] = (changed - base) / (shifted[index] - theta[index])
        return np.column_stack([columns[index] for index in range(theta.size)])

    solution = least_squares(
        residual,
        np.clip(start.theta, low + 1e-6, high - 1e-6),
        jac=jacobian,
        bounds=(low, high),
        loss='soft_l1',
        f_scale=OUTLIER,
        max_nfev=rounds,
        xtol=converged,
        ftol=converged,
    )
    # before the data, a value is anywhere in its range; the prior of others is in the residuals
    anywhere = np.array([c.deviation <= 0.0 for c in start.coordinates])
    curvature = solution.jac.T @ solution.jac + np.diag(anywhere * UNIFORM / (high - low) ** 2)
    covariance: Floats = np.linalg.inv(curvature)
    return Fit(start.with_theta(solution.x), float(solution.cost), covariance)


def _residual(explanation: Explanation, given: Hypothesis, dataset: Dataset) -> Floats:
    """Return the residuals of the data, and values as errors where these have a prior."""
    return np.concatenate([dataset.residual(explanation.apply(given)), explanation.errors])


def loss_of(explanation: Explanation, given: Hypothesis, dataset: Dataset) -> float:
    """Return the loss that an explanation leaves [-]."""
    return loss(dataset.residual(explanation.apply(given)))
