"""
Confidence intervals of fitted values, and intervals of time in which an explanation contributes.

The curvature of a fit to whitened residuals is a covariance; it grows with the mean square of the
residuals that remain, as for any fit by least squares. What the method itself is off by - smoothed
signals, local minima of simulations - is found by fits to replicates, whose values are known: a
parametric bootstrap (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, Chapman & Hall
(1993), ch. 6).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.stats import norm

from pneu_rig_ros.diagnosis.candidates import Explanation
from pneu_rig_ros.diagnosis.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.fitting import ROUNDS, Fit, fit
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.replicates import replicate
from pneu_rig_ros.diagnosis.weak_form import Floats
from pneu_rig_ros.diagnosis.windows import Windows, windows_of
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
    explanation: Explanation,
    given: Hypothesis,
    dataset: Dataset,
    rng: Generator,
    executor: Executor,
) -> Floats:
    """
    Return the errors of fits to replicates of a fitted explanation.

    :returns: internal units, shape (REPLICATES, coordinates)
    """
    seeds = rng.spawn(REPLICATES)
    return np.array(map_tasks(executor, _replicate_error, seeds, explanation, given, dataset))


def _replicate_error(
    rng: Generator, explanation: Explanation, given: Hypothesis, dataset: Dataset
) -> Floats:
    hypothesis = explanation.apply(given)
    runs = [replicate(hypothesis, comparison, rng) for comparison in dataset.comparisons]
    data = Dataset.of(hypothesis, runs, rng, dataset.inflation)
    if dataset.cycles is not None:
        data = data.with_cycles(hypothesis, rng)
    error: Floats = fit(explanation, given, data, ROUNDS).explanation.theta - explanation.theta
    return error


def value_intervals(
    best: Fit, given: Hypothesis, dataset: Dataset, errors: Floats
) -> list[tuple[float, float]]:
    """
    Return the 95 % confidence interval of each coordinate of a fit [SI].

    :param errors: of fits to replicates, see :func:`replicate_errors`
    """
    residual = dataset.residual(best.explanation.apply(given))
    excess = max(2.0 * loss(residual) / max(residual.size, 1), 1.0)
    variances = np.maximum(np.diag(best.covariance) * excess, np.mean(errors**2, axis=0))
    half = HALF_WIDTH * np.sqrt(variances)
    triples = zip(best.explanation.coordinates, best.explanation.theta, half, strict=True)
    return [(c.from_internal(float(t - d)), c.from_internal(float(t + d))) for c, t, d in triples]


def contribution_intervals(given: Hypothesis, improved: Hypothesis, dataset: Dataset) -> Spans:
    """
    Return the intervals in which an explanation contributes more than the noise.

    Its contribution is the difference of the residuals without and with it.
    """
    spans: Spans = []
    pairs = zip(windows_of(dataset, given), windows_of(dataset, improved), strict=True)
    for before, after in pairs:
        spans += _spans(before, np.abs(before.residual - after.residual) > before.deviation)
    return spans


def residual_intervals(groups: Sequence[Windows], deviations: float) -> Spans:
    """Return the intervals in which local means exceed so many standard deviations."""
    spans: Spans = []
    for windows in groups:
        width = min(AVERAGED_WINDOWS, windows.residual.size)
        mean = uniform_filter1d(windows.residual / windows.deviation, width)
        spans += _spans(windows, np.abs(mean) * np.sqrt(width) > deviations)
    return spans


def _spans(windows: Windows, flags: NDArray[np.bool_]) -> Iterator[tuple[str, str, float, float]]:
    """Yield the stretches of the flagged windows; each stands for the middle of its time."""
    marks = np.flatnonzero(flags)
    if not marks.size:
        return
    quarter = 0.25 * (windows.end - windows.start)
    starts, ends = windows.start + quarter, windows.end - quarter
    pauses = np.flatnonzero(starts[marks[1:]] - ends[marks[:-1]] > BRIDGED_PAUSE) + 1
    for group in np.split(marks, pauses):
        first, last = float(starts[group[0]]), float(ends[group[-1]])
        yield windows.balance, windows.recording, first, last
