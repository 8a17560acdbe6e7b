"""
Confidence intervals of fitted values, and intervals of time in which an explanation contributes.

The curvature of a fit to whitened residuals is a covariance; it grows with the mean square of the
residuals that remain, as for any fit by least squares. What the method itself is off by - smoothed
signals, local minima of simulations - is found by fits to replicates, whose values are known: a
parametric bootstrap (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, Chapman & Hall
(1993), ch. 6).
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.random import Generator
from scipy.ndimage import uniform_filter1d
from scipy.stats import norm

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.residuals.noise import white_variances
from pneu_rig_ros.diagnosis.residuals.replicates import replicate
from pneu_rig_ros.diagnosis.residuals.windows import NEAR_BREAKAWAY, Windows
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, Fit, fit_from_valley
from pneu_rig_ros.executor import Executor, map_tasks

Spans = list[tuple[str, str, float, float]]
"""Balance, recording, from, to [s]."""

CONFIDENCE = 0.95
HALF_WIDTH = float(norm.ppf(0.5 + 0.5 * CONFIDENCE))
"""Half an interval [standard deviations]."""
REPLICATES = 4
"""Fits to replicates: as many as two processors do in about two seconds."""
AVERAGED_WINDOWS = 5
"""Windows whose mean is compared with the noise, without a cause."""
BRIDGED_PAUSE = 0.15
"""Intervals less far apart are joined [s]."""


def replicate_errors(
    explanation: Explanation, dataset: Dataset, rng: Generator, executor: Executor
) -> Floats:
    """Return errors of fits to replicates of an explanation, as theta, (REPLICATES, k)."""
    seeds = rng.spawn(REPLICATES)
    return np.array(map_tasks(executor, _replicate_error, seeds, explanation, dataset))


def _replicate_error(rng: Generator, explanation: Explanation, dataset: Dataset) -> Floats:
    hypothesis = explanation.hypothesis
    runs = [replicate(hypothesis, comparison, rng) for comparison in dataset.comparisons]
    data = Dataset.of(hypothesis, runs, rng, dataset.inflation)
    if dataset.cycles is not None:
        data = data.with_cycles(hypothesis, rng, dataset.cycles.free)
    found = fit_from_valley(explanation, data, ROUNDS).explanation
    error: Floats = found.theta - explanation.theta
    return error


def value_intervals(best: Fit, dataset: Dataset, errors: Floats) -> list[tuple[float, float]]:
    """Return the 95 % confidence interval of each coordinate of a fit [SI]."""
    residual = dataset.residual(best.hypothesis)
    excess = max(2.0 * loss(residual) / max(residual.size, 1), 1.0)
    variances = np.maximum(np.diag(best.covariance) * excess, np.mean(errors**2, axis=0))
    half = HALF_WIDTH * np.sqrt(variances)
    triples = zip(best.explanation.coordinates, best.explanation.theta, half, strict=True)
    return [(c.from_internal(float(t - d)), c.from_internal(float(t + d))) for c, t, d in triples]


def contribution_intervals(given: Hypothesis, improved: Hypothesis, dataset: Dataset) -> Spans:
    """
    Return the intervals in which an explanation contributes more than the noise of the sensors.

    Its contribution, the difference of the residuals without and with it, is known also in windows
    that are no evidence, as close to a breakaway.
    """
    spans: Spans = []
    for data in dataset.runs:
        comparison, noise, run = data.comparison, data.noise, data.comparison.run
        after, inertia = comparison.evaluate(improved)
        pair = comparison.residuals(given), after
        *changes, at_breakaway, at_stop = (np.abs(b - a) for a, b in zip(*pair, strict=True))
        functions = comparison.gas, comparison.gas, comparison.motion
        variances = white_variances(improved, comparison, inertia)
        for balance, each, change, variance in zip(
            BALANCES, functions, changes, variances, strict=True
        ):
            if balance in run.balances:
                start = run.begin + each.starts.astype(np.float64) * run.interval
                end = start + each.size * run.interval
                spans += _spans(balance, run.name, start, end, change > np.sqrt(variance))
        kept, deviation = noise.breakaway.kept, noise.breakaway.deviation
        time = run.begin + comparison.breakaways[kept].astype(np.float64) * run.interval
        near = time - NEAR_BREAKAWAY, time + NEAR_BREAKAWAY
        spans += _spans('force', run.name, *near, at_breakaway[kept] > deviation)
        kept, deviation = noise.stop.kept, noise.stop.deviation
        start = run.begin + comparison.stops.starts[kept].astype(np.float64) * run.interval
        end = start + comparison.stops.size * run.interval
        spans += _spans('force', run.name, start, end, at_stop[kept] > deviation)
    return spans


def residual_intervals(groups: Sequence[Windows], deviations: float) -> Spans:
    """Return the intervals in which local means exceed so many standard deviations."""
    spans: Spans = []
    for windows in groups:
        width = min(AVERAGED_WINDOWS, windows.residual.size)
        mean = uniform_filter1d(windows.residual / windows.deviation, width)
        place = windows.balance, windows.recording, windows.start, windows.end
        spans += _spans(*place, np.abs(mean) * np.sqrt(width) > deviations)
    return spans


def _spans(
    balance: str, recording: str, start: Floats, end: Floats, flags: Flags
) -> Iterator[tuple[str, str, float, float]]:
    """Yield the stretches of the flagged windows; each stands for the middle of its time."""
    marks = np.flatnonzero(flags)
    if not marks.size:
        return
    quarter = 0.25 * (end - start)
    starts, ends = start + quarter, end - quarter
    pauses = np.flatnonzero(starts[marks[1:]] - ends[marks[:-1]] > BRIDGED_PAUSE) + 1
    for group in np.split(marks, pauses):
        yield balance, recording, float(starts[group[0]]), float(ends[group[-1]])
