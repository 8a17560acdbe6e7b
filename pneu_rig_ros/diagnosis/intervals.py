"""
How far fitted values may be off, and when an explanation contributes.

The curvature of the fit is that of whitened residuals, so that it is a covariance by itself; a
model that leaves more than the noise is off by more too, in proportion to the root of what it
leaves, as for any fit by least squares.
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
from pneu_rig_ros.diagnosis.localisation import Windows, windows_of

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
STRETCH = 5
"""Windows whose mean leaves the noise, where no cause is known."""
BRIDGE = 0.15
"""Intervals less far apart are one [s]."""


def value_intervals(fit: Fit, given: Hypothesis, dataset: Dataset) -> list[tuple[float, float]]:
    """Return an interval of 95 % for each coordinate of a fit [SI]."""
    residual = dataset.residual(fit.explanation.apply(given))
    excess = max(2.0 * loss(residual) / max(residual.size, 1), 1.0)
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0) * excess)
    half = float(norm.ppf(0.5 + 0.5 * CONFIDENCE)) * deviations
    triples = zip(fit.explanation.coordinates, fit.explanation.theta, half, strict=True)
    return [
        (c.from_internal(float(seen - d)), c.from_internal(float(seen + d)))
        for c, seen, d in triples
    ]


def contribution_intervals(
    given: Hypothesis, improved: Hypothesis, dataset: Dataset
) -> list[tuple[str, str, float, float]]:
    """
    Return balance, recording, from, to [s] where an explanation contributes more than the noise.

    A contribution is the difference of the residuals without and with it.
    """
    spans: list[tuple[str, str, float, float]] = []
    pairs = zip(windows_of(dataset, given), windows_of(dataset, improved), strict=True)
    for before, after in pairs:
        beyond = np.abs(before.residual - after.residual) > before.deviation
        spans += list(_spans(before, beyond))
    return spans


def residual_intervals(
    windows: Sequence[Windows], fraction: float
) -> list[tuple[str, str, float, float]]:
    """Return the same of windows whose mean over a stretch leaves the noise: no cause is known."""
    spans: list[tuple[str, str, float, float]] = []
    for one in windows:
        width = min(STRETCH, one.residual.size)
        mean = uniform_filter1d(one.residual / one.deviation, width)
        spans += list(_spans(one, np.abs(mean) * np.sqrt(width) > fraction))
    return spans


def _spans(windows: Windows, flags: NDArray[np.bool_]) -> Iterator[tuple[str, str, float, float]]:
    """Yield the stretches of the flagged windows; each stands for the middle of its time."""
    marks = np.flatnonzero(flags)
    if not marks.size:
        return
    quarter = 0.25 * (windows.end - windows.start)
    starts, ends = windows.start + quarter, windows.end - quarter
    gaps = np.flatnonzero(starts[marks[1:]] - ends[marks[:-1]] > BRIDGE) + 1
    for group in np.split(marks, gaps):
        yield (windows.balance, windows.recording, float(starts[group[0]]),
               float(ends[group[-1]]))  # fmt: skip
