"""
Fits of explanations by robust least squares on the whitened residuals.

Losses are pseudo-Huber, as a few windows are farther off than the noise model accounts for. Slips
make hills in the loss of simulated cycles, phases ridges in that of a load that swings: there a
fit starts from several places.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats.qmc import Sobol

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import OUTLIER, Dataset, loss
from pneu_rig_ros.executor import Executor, map_tasks

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
FAR_STARTS = 2
"""Starts of the last cause that are tried besides the values of an earlier fit."""
LONG_STEPS = (-0.4, -0.2, -0.1, 0.1, 0.2, 0.4)
"""
Such steps from a fit to simulations, internal units [-]: a local minimum that one slip makes is
steep, and its standard deviations do not measure the length of the valley.
"""
SCATTERED = 64
"""Points around a fit to simulations from which it is started again."""
SCATTER = 40.0, 1.5
"""Their distance from the fit at most [standard deviations, internal units]."""
RESTARTS = 3
"""Best of them, and of those along the valley, that are fitted."""
REFITTED = 2
"""Best of these fits that go on."""
ALONG, ACROSS = 0.25 * np.arange(-12, 13), 2.0 * np.arange(-8, 9)
"""
Grid on which a cause with a memory is sought again: steps in the direction that the data determine
least, internal units, and in the one that they determine most [standard deviations]. A load that
swings has a minimum for each of its phases, the narrower the less it is damped: one standard
deviation on either side where it swings ten times.
"""
SIMPLEX_SIZE = 0.2
"""Of the search across local minima, internal units [-]."""
SIMPLEX_STEPS = 100
"""Its steps at most, for each coordinate."""

UNIFORM = 12.0
"""Square of a range by the variance of a number that is anywhere in it [-]."""


@dataclass(frozen=True)
class Fit:
    """
    An explanation with its best values.

    :param loss: that remains [-]
    :param covariance: of theta, shape (coordinates, coordinates), empty if nothing was fitted
    """

    explanation: Explanation
    loss: float = 0.0
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def hypothesis(self) -> Hypothesis:
        """The hypothesis with the best values."""
        return self.explanation.hypothesis

    @property
    def widest(self) -> tuple[float, Floats]:
        """The least determined direction of theta, and its standard deviation [-]."""
        variances, directions = np.linalg.eigh(self.covariance)
        return float(np.sqrt(max(variances[-1], 0.0))), directions[:, -1]


def fit_from_valley(start: Explanation, dataset: Dataset, rounds: int) -> Fit:
    """
    Return the explanation fitted to a dataset from the best of a start and of a valley.

    The valley is what the residuals of the weak form alone leave open. Simulations have local
    minima between a start and the best values, which these have not; free runs, which are the data
    only of what is weak, have none.
    """
    if dataset.cycles is None or dataset.runs_freely:
        return fit(start, dataset, rounds)
    weak = fit(start, dataset.without_cycles, rounds)
    deviation, direction = weak.widest
    step, theta = deviation * direction, weak.explanation.theta
    points = [weak.explanation.with_theta(theta + t * step) for t in VALLEY]
    best = min((start, *points), key=lambda point: loss_of(point, dataset))
    return fit(best, dataset, rounds)


def fit(start: Explanation, dataset: Dataset, rounds: int) -> Fit:
    """Return the explanation fitted to a dataset from a start."""
    low, high = start.bounds
    delta, converged = STEP, CONVERGED
    if dataset.cycles is not None:
        delta, converged = SIMULATED_STEP, SIMULATED_CONVERGED

    @lru_cache(maxsize=1)  # the solver asks for the Jacobian where it was last
    def residual_at(theta: bytes) -> Floats:
        return _residual(start.with_theta(np.frombuffer(theta)), dataset)

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
            changed = _residual(start.with_theta(shifted), dataset)
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


def _residual(explanation: Explanation, dataset: Dataset) -> Floats:
    """Return the residuals of the data, and values as errors where these have a prior."""
    return np.concatenate([dataset.residual(explanation.hypothesis), explanation.errors])


def loss_of(explanation: Explanation, dataset: Dataset) -> float:
    """Return the loss that an explanation leaves [-]."""
    return loss(dataset.residual(explanation.hypothesis))


def multi_start(explanation: Explanation, dataset: Dataset, executor: Executor) -> Fit:
    """
    Return the best fit from its values and, simulated, the last cause's unfitted ones.

    Free runs are the data only of what is so weak that it makes no hills.
    """
    if dataset.cycles is None or dataset.runs_freely:
        return fit(explanation, dataset, FINAL_ROUNDS)
    kept = explanation.values[:-1]
    starts = [replace(explanation, values=(*kept, s)) for s in explanation.parts[-1].starts]
    far = best_starts(starts, dataset, executor)[:FAR_STARTS]
    fits: Sequence[Fit] = map_tasks(executor, fit, far, dataset, ROUNDS)
    near = fit_from_valley(explanation, dataset, FINAL_ROUNDS)
    return min((near, *fits), key=lambda result: result.loss)


def over_hills(best: Fit, dataset: Dataset, executor: Executor) -> Fit:
    """
    Return the best of a fit to simulations and of others that hills of the loss separate from it.

    They start along its valley and around it. A simplex search, which steps across the minimum of
    a single slip, finishes the best.
    """
    steps = np.outer(LONG_STEPS, best.widest[1])
    along = [best.explanation.with_theta(best.explanation.theta + step) for step in steps]
    starts = [
        start
        for points in (along, scattered(best))
        for start in best_starts(points, dataset, executor)[:RESTARTS]
    ]
    first = map_tasks(executor, fit, starts, dataset, FIRST_ROUNDS)
    first.sort(key=lambda result: result.loss)
    finalists = [each.explanation for each in first[:REFITTED]]
    fits = map_tasks(executor, fit, finalists, dataset, ROUNDS)
    return simplex_search(min((best, *fits), key=lambda result: result.loss), dataset)


def over_ridges(best: Fit, dataset: Dataset, executor: Executor) -> Fit:
    """
    Return the best of a fit and of others that ridges of the loss separate from it.

    Along the valley of its last cause, with the best of the steps across at each place, every
    local minimum is a start, see ``ALONG``.
    """
    theta, own = best.explanation.theta, len(best.explanation.parts[-1].coordinates)
    variances, directions = np.linalg.eigh(best.covariance[-own:, -own:])
    narrow = np.sqrt(max(variances[0], 0.0)) * directions[:, 0]
    steps = [far * directions[:, -1] + near * narrow for far in ALONG for near in ACROSS]
    others = np.zeros(theta.size - own)  # of the other causes
    points = [best.explanation.with_theta(theta + np.append(others, step)) for step in steps]
    losses = np.reshape(map_tasks(executor, loss_of, points, dataset), (ALONG.size, -1))
    profile = np.pad(losses.min(axis=1), 1, constant_values=np.inf)
    rows = np.flatnonzero((profile[1:-1] < profile[:-2]) & (profile[1:-1] < profile[2:]))
    starts = [points[row * ACROSS.size + int(losses[row].argmin())] for row in rows]
    fits = map_tasks(executor, fit, starts, dataset, ROUNDS)
    return min((best, *fits), key=lambda result: result.loss)


def best_starts(
    starts: Sequence[Explanation], dataset: Dataset, executor: Executor
) -> list[Explanation]:
    """Return starts in the order of their losses."""
    losses = map_tasks(executor, loss_of, starts, dataset)
    return [starts[index] for index in np.argsort(losses, kind='stable')]


def scattered(best: Fit) -> list[Explanation]:
    """Return points around a fit, in a box of the shape of its uncertainty (Sobol's sequence)."""
    theta, (deviations, most) = best.explanation.theta, SCATTER
    size = np.minimum(deviations * np.sqrt(np.diag(best.covariance)), most)
    points = 2.0 * Sobol(theta.size, seed=0).random(SCATTERED) - 1.0
    return [best.explanation.with_theta(theta + size * point) for point in points]


def simplex_search(best: Fit, dataset: Dataset, size: float = SIMPLEX_SIZE) -> Fit:
    """
    Return a fit whose causes are improved by a simplex search across local minima.

    :param size: of the first simplex, internal units [-]; of either sign
    """
    start = best.explanation
    searched = ~np.array(start.calibrates)
    if not searched.any():
        return best
    low, high = (bounds[searched] for bounds in start.bounds)
    first = start.theta[searched]

    def moved(values: Floats) -> Explanation:
        theta = start.theta
        theta[searched] = values
        return start.with_theta(theta)

    simplex = np.vstack([first, first + size * np.eye(first.size)])
    solution = minimize(
        lambda values: loss_of(moved(values), dataset),
        first,
        method='Nelder-Mead',
        bounds=list(zip(low, high, strict=True)),
        options={
            'initial_simplex': np.clip(simplex, low, high),
            'xatol': 1e-3,
            'fatol': 0.1,
            'maxfev': SIMPLEX_STEPS * first.size,
        },
    )
    if solution.fun >= best.loss:
        return best
    return replace(best, explanation=moved(solution.x), loss=float(solution.fun))
