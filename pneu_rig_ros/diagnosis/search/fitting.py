"""
Fits of explanations by robust least squares on the whitened residuals.

Losses are pseudo-Huber, as a few windows are farther off than the noise model accounts for.
"""

from __future__ import annotations

from dataclasses import dataclass

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
ROUNDS, FINAL_ROUNDS = 15, 40
"""Evaluations of the least-squares solver, in the comparison and of the accepted fit."""
VALLEY = (-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0)
"""Steps along the direction that the residuals determine least [standard deviations]."""


@dataclass(frozen=True)
class Fit:
    """
    A fitted explanation.

    :param explanation: with the best values
    :param loss: that remains [-]
    :param covariance: of theta, shape (coordinates, coordinates)
    """

    explanation: Explanation
    loss: float
    covariance: Floats

    @property
    def widest(self) -> tuple[float, Floats]:
        """The least determined direction of theta, and its standard deviation [-]."""
        variances, directions = np.linalg.eigh(self.covariance)
        return float(np.sqrt(max(variances[-1], 0.0))), directions[:, -1]


def fit(start: Explanation, given: Hypothesis, dataset: Dataset, rounds: int) -> Fit:
    """
    Return the explanation fitted to a dataset from a start.

    Simulations have local minima between a start and the best values, which the residuals of the
    weak form have not. These are therefore fitted first, and the simulations from the best point
    along the valley in which they leave the values open.

    :param rounds: of the least-squares solver at most
    """
    if dataset.cycles is not None:
        weak = fit(start, given, dataset.without_cycles, rounds)
        deviation, direction = weak.widest
        step = deviation * direction
        theta = weak.explanation.theta
        points = [weak.explanation.with_theta(theta + t * step) for t in VALLEY]
        start = min((start, *points), key=lambda point: loss(dataset.residual(point.apply(given))))
    low, high = np.array([c.bounds for c in start.coordinates]).T
    delta = STEP if dataset.cycles is None else SIMULATED_STEP

    latest: list[tuple[bytes, Floats]] = [(b'', np.zeros(0))]

    def residual(theta: Floats) -> Floats:
        key = theta.tobytes()
        if latest[0][0] != key:  # the solver asks for the Jacobian where it was last
            latest[0] = key, _residual(start.with_theta(theta), given, dataset)
        return latest[0][1].copy()  # the solver scales it in place

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
        xtol=1e-5,
        ftol=1e-5,
    )
    # before the data, a value is anywhere in its range; those of the calibration are residuals
    known = np.array([c.deviation for c in start.coordinates]) ** -2.0
    known[np.array(start.calibrates, dtype=np.bool_)] = 0.0
    curvature = solution.jac.T @ solution.jac + np.diag(known)
    covariance: Floats = np.linalg.inv(curvature)
    return Fit(start.with_theta(solution.x), float(solution.cost), covariance)


def _residual(explanation: Explanation, given: Hypothesis, dataset: Dataset) -> Floats:
    """Return the residuals with the errors of calibration, as far as these are unlikely."""
    return np.concatenate([dataset.residual(explanation.apply(given)), explanation.errors])
