"""
Fits from several starts, where simulations or swinging loads have local minima.

Slips make hills in the loss of simulated cycles, phases ridges in that of a load that swings.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize
from scipy.stats.qmc import Sobol

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.search.fitting import (
    FINAL_ROUNDS,
    FIRST_ROUNDS,
    ROUNDS,
    Fit,
    fit,
    fit_from_valley,
    loss_of,
)
from pneu_rig_ros.executor import Executor, map_tasks

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


def multi_start(
    explanation: Explanation, given: Hypothesis, dataset: Dataset, executor: Executor
) -> Fit:
    """
    Return the best fit from its values and, simulated, the last cause's unfitted ones.

    Free runs are the data only of what is so weak that it makes no hills.
    """
    if dataset.cycles is None or dataset.runs_freely:
        return fit(explanation, given, dataset, FINAL_ROUNDS)
    kept = explanation.values[:-1]
    starts = [replace(explanation, values=(*kept, s)) for s in explanation.parts[-1].starts]
    far = best_starts(starts, given, dataset, executor)[:FAR_STARTS]
    fits: Sequence[Fit] = map_tasks(executor, fit, far, given, dataset, ROUNDS)
    near = fit_from_valley(explanation, given, dataset, FINAL_ROUNDS)
    return min((near, *fits), key=lambda result: result.loss)


def over_hills(best: Fit, given: Hypothesis, dataset: Dataset, executor: Executor) -> Fit:
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
        for start in best_starts(points, given, dataset, executor)[:RESTARTS]
    ]
    first = map_tasks(executor, fit, starts, given, dataset, FIRST_ROUNDS)
    first.sort(key=lambda result: result.loss)
    finalists = [each.explanation for each in first[:REFITTED]]
    fits = map_tasks(executor, fit, finalists, given, dataset, ROUNDS)
    return simplex_search(min((best, *fits), key=lambda result: result.loss), given, dataset)


def over_ridges(best: Fit, given: Hypothesis, dataset: Dataset, executor: Executor) -> Fit:
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
    losses = np.reshape(map_tasks(executor, loss_of, points, given, dataset), (ALONG.size, -1))
    profile = np.pad(losses.min(axis=1), 1, constant_values=np.inf)
    rows = np.flatnonzero((profile[1:-1] < profile[:-2]) & (profile[1:-1] < profile[2:]))
    starts = [points[row * ACROSS.size + int(losses[row].argmin())] for row in rows]
    fits = map_tasks(executor, fit, starts, given, dataset, ROUNDS)
    return min((best, *fits), key=lambda result: result.loss)


def best_starts(
    starts: Sequence[Explanation], given: Hypothesis, dataset: Dataset, executor: Executor
) -> list[Explanation]:
    """Return starts in the order of their losses."""
    losses = map_tasks(executor, loss_of, starts, given, dataset)
    return [starts[index] for index in np.argsort(losses, kind='stable')]


def scattered(best: Fit) -> list[Explanation]:
    """Return points around a fit, in a box of the shape of its uncertainty (Sobol's sequence)."""
    theta, (deviations, most) = best.explanation.theta, SCATTER
    size = np.minimum(deviations * np.sqrt(np.diag(best.covariance)), most)
    points = 2.0 * Sobol(theta.size, seed=0).random(SCATTERED) - 1.0
    return [best.explanation.with_theta(theta + size * point) for point in points]


def simplex_search(best: Fit, given: Hypothesis, dataset: Dataset) -> Fit:
    """Return a fit whose causes are improved by a simplex search across local minima."""
    start = best.explanation
    searched = ~np.array(start.calibrates)
    if not searched.any():
        return best
    low, high = np.array([c.bounds for c in start.coordinates]).T[:, searched]
    first = start.theta[searched]

    def moved(values: Floats) -> Explanation:
        theta = start.theta
        theta[searched] = values
        return start.with_theta(theta)

    simplex = np.vstack([first, first + SIMPLEX_SIZE * np.eye(first.size)])
    solution = minimize(
        lambda values: loss_of(moved(values), given, dataset),
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
