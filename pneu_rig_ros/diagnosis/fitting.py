"""
Screening and fitting of explanations by robust least squares on the whitened residuals.

A candidate changes the residuals by what it adds to the modelled rates along the measured run: no
simulation, no local minima by slips. Losses are pseudo-Huber, as a few windows are farther off
than the noise model accounts for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats.qmc import Sobol

from pneu_rig_ros.diagnosis.candidates import Candidate, Explanation
from pneu_rig_ros.diagnosis.dataset import OUTLIER, Dataset, loss
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.weak_form import Floats
from pneu_rig_ros.executor import Executor, map_tasks

SHARES = np.concatenate([np.linspace(0.1, 1.6, 16), [2.0, 3.0, 5.0, 8.0]])
"""Multiples of a candidate's change of the residuals that are screened [-]."""
STEP = 1e-3
"""Of the finite differences, internal units [-]: rates have no noise of their own."""
SIMULATED_STEP = 1e-2
"""The same with simulated cycles, which have noise of integration."""
ROUNDS, FINAL_ROUNDS = 15, 40
"""Evaluations of the least-squares solver, in the comparison and of the accepted fit."""
FAR_STARTS = 2
"""Starts of the last cause that are tried besides the values of an earlier fit."""
VALLEY = (-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0)
"""Steps along the direction that the residuals determine least [standard deviations]."""
LONG_STEPS = (-0.4, -0.2, -0.1, 0.1, 0.2, 0.4)
"""
Such steps from a fit to simulations, internal units [-]: a local minimum that one slip makes is
steep, and its standard deviations do not measure the length of the valley.
"""
UNIFORM = 12.0
"""Square of a range by the variance of a number that is anywhere in it [-]."""
SCATTERED = 64
"""Points around a fit to simulations from which it is started again."""
SCATTER = 40.0, 1.5
"""Their distance from the fit at most [standard deviations, internal units]."""
RESTARTS = 3
"""Best of them, and of those along the valley, that are fitted."""
ALONG, ACROSS = 0.25 * np.arange(-12, 13), 3.0 * np.arange(-5, 6)
"""
Grid on which a cause with a memory is sought again: steps in the direction that the data determine
least, internal units, and in the one that they determine most [standard deviations]. A load that
swings has a minimum for each of its phases, the narrower the less it is damped.
"""
SIMPLEX_SIZE = 0.2
"""Of the search across local minima, internal units [-]."""
SIMPLEX_STEPS = 100
"""Its steps at most, for each coordinate."""


@dataclass(frozen=True)
class Screened:
    """
    A candidate with an estimate of the loss that it leaves.

    :param values: of its best start
    :param loss: expected from there [-]
    :param shift: by which the other causes are expected to change, as theta, shape (k,)
    :param alternatives: values of further starts, where local minima may separate them
    """

    candidate: Candidate
    values: tuple[float, ...]
    loss: float
    shift: tuple[float, ...] = ()
    alternatives: tuple[tuple[float, ...], ...] = ()


def screen(
    candidate: Candidate, given: Hypothesis, dataset: Dataset, residual: Floats, free: Floats
) -> Screened:
    """
    Return the loss that a candidate leaves at the best multiple of the change from each start.

    Simulated cycles do not change in proportion to a cause: there only the starts are compared.

    :param residual: without the candidate, shape (n,)
    :param free: change of the residual by each value of the other causes, which are fitted again
        with it, see :func:`changes`, shape (n, k)
    """
    simulated = dataset.cycles is not None
    shares = np.ones(1) if simulated else SHARES
    unit = candidate.coordinates[0].quantity.unit  # that of its strength
    results, inverse = [], np.linalg.pinv(free, rcond=STEP)
    for start in candidate.starts:
        change = dataset.residual(candidate.apply(given, start)) - residual
        left = [residual + share * change for share in shares]
        shifts = [-inverse @ each for each in left]
        losses = [loss(each + free @ shift) for each, shift in zip(left, shifts, strict=True)]
        best = int(np.argmin(losses))
        values = tuple(
            c.amplified(value, float(shares[best])) if c.quantity.unit == unit else value
            for c, value in zip(candidate.coordinates, start, strict=True)
        )
        results.append(Screened(candidate, values, losses[best], tuple(shifts[best].tolist())))
    first, *rest = sorted(results, key=lambda result: result.loss)
    if not simulated or len(first.values) == 1:
        return first
    return replace(first, alternatives=tuple(result.values for result in rest[:1]))


def changes(explanation: Explanation, given: Hypothesis, dataset: Dataset) -> Floats:
    """Return the derivative of the residual by each value of an explanation, shape (n, k)."""
    base, theta = dataset.residual(explanation.apply(given)), explanation.theta
    columns = np.zeros((base.size, theta.size))
    for index, step in enumerate(STEP * np.eye(theta.size)):
        moved = explanation.with_theta(theta + step)
        columns[:, index] = (dataset.residual(moved.apply(given)) - base) / STEP
    return columns


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
            latest[0] = key, dataset.residual(start.with_theta(theta).apply(given))
        return latest[0][1].copy()  # the solver scales it in place

    columns: dict[int, Floats] = {}

    def jacobian(theta: Floats) -> Floats:
        base = residual(theta)
        for index in range(theta.size):
            if index in columns and start.calibrates[index]:
                continue  # errors of a percent act in proportion: one column serves all steps
            shifted = theta.copy()
            shifted[index] += delta if theta[index] + delta < high[index] else -delta
            changed = dataset.residual(start.with_theta(shifted).apply(given))
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
    # before the data, a value is anywhere in its range
    curvature = solution.jac.T @ solution.jac + np.diag(UNIFORM / (high - low) ** 2)
    covariance: Floats = np.linalg.inv(curvature)
    return Fit(start.with_theta(solution.x), float(solution.cost), covariance)


def multi_start(
    explanation: Explanation, given: Hypothesis, dataset: Dataset, executor: Executor
) -> Fit:
    """
    Return the best fit of several starts where simulations have local minima, else of one.

    Started also from the unfitted values of the last cause, then along the valley of the best fit
    and around it, and finished by a simplex search, which steps across the minimum of a single
    slip.
    """
    if dataset.cycles is None:
        return fit(explanation, given, dataset, FINAL_ROUNDS)
    kept = explanation.values[:-1]
    starts = [replace(explanation, values=(*kept, s)) for s in explanation.parts[-1].starts]
    starts = [explanation, *best_starts(starts, given, dataset, executor)[:FAR_STARTS]]
    fits: Sequence[Fit] = map_tasks(executor, fit, starts, given, dataset, FINAL_ROUNDS)
    best = min(fits, key=lambda result: result.loss)
    groups = along_valley(best), scattered(best)
    starts = [
        start
        for group in groups
        for start in best_starts(group, given, dataset, executor)[:RESTARTS]
    ]
    fits = map_tasks(executor, fit, starts, given, dataset, ROUNDS)
    best = min((best, *fits), key=lambda result: result.loss)
    return simplex_search(best, given, dataset)


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
    losses = np.reshape(map_tasks(executor, _loss, points, given, dataset), (ALONG.size, -1))
    profile = np.pad(losses.min(axis=1), 1, constant_values=np.inf)
    rows = np.flatnonzero((profile[1:-1] < profile[:-2]) & (profile[1:-1] < profile[2:]))
    starts = [points[row * ACROSS.size + int(losses[row].argmin())] for row in rows]
    fits = map_tasks(executor, fit, starts, given, dataset, ROUNDS)
    return min((best, *fits), key=lambda result: result.loss)


def best_starts(
    starts: Sequence[Explanation], given: Hypothesis, dataset: Dataset, executor: Executor
) -> list[Explanation]:
    """Return starts in the order of their losses."""
    losses = map_tasks(executor, _loss, starts, given, dataset)
    order = np.argsort(losses, kind='stable')
    return [starts[index] for index in order]


def _loss(start: Explanation, given: Hypothesis, dataset: Dataset) -> float:
    return loss(dataset.residual(start.apply(given)))


def along_valley(best: Fit) -> list[Explanation]:
    """Return long steps from a fit in the direction that the data determine least."""
    theta, (_, direction) = best.explanation.theta, best.widest
    return [best.explanation.with_theta(theta + step * direction) for step in LONG_STEPS]


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
        lambda values: loss(dataset.residual(moved(values).apply(given))),
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
