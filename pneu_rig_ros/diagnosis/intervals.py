"""
Confidence intervals of fitted values, and intervals of time in which an explanation contributes.

The curvature of a fit to whitened residuals is a covariance; it grows with the mean square of the
residuals that remain, as for any fit by least squares.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.stats import norm

from pneu_rig_ros.diagnosis.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.fitting import Fit
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.windows import Windows, windows_of

Spans = list[tuple[str, str, float, float]]
"""Balance, recording, from, to [s]."""

CONFIDENCE = 0.95
HALF_WIDTH = float(norm.ppf(0.5 + 0.5 * CONFIDENCE))
"""Half an interval [standard deviations]."""
AVERAGED_WINDOWS = 5
"""Windows whose mean is compared with the noise, without a cause."""
BRIDGED_PAUSE = 0.15
"""Intervals less far apart are joined [s]."""


def value_intervals(fit: Fit, given: Hypothesis, dataset: Dataset) -> list[tuple[float, float]]:
    """Return the 95 % confidence interval of each coordinate of a fit [SI]."""
    residual = dataset.residual(fit.explanation.apply(given))
    excess = max(2.0 * loss(residual) / max(residual.size, 1), 1.0)
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0) * excess)
    half = HALF_WIDTH * deviations
    triples = zip(fit.explanation.coordinates, fit.explanation.theta, half, strict=True)
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
