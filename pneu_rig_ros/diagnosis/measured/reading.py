"""Readings of sensors: their noise, and the ends of their spans, where it is cut off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import ndtr

from pneu_rig_ros.arrays import Floats

CLIPPED = 4.0
"""Standard deviations from the end of a span within which noise is cut off on one side [-]."""

OUTLIER_NOISE, OUTLIER_STEP = 6.0, 1.5
"""
A reading farther from the line between its neighbours is wrong: so many standard deviations, and
steps of the motion around it, of which a bench that turns makes one [-].
"""
STEPS = 11
"""
Steps of which the median is that of the motion before, or after, a reading. The larger counts: by
that of both a turn from a fast stroke to a slow one would be a wrong reading.
"""


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a reading of x [m], p1, p2 [Pa] and of the bench's force [N]."""

    position: float
    pressure_1: float
    pressure_2: float
    force: float = 0.0

    @property
    def pressures(self) -> tuple[float, float]:
        """That of p1, p2 [Pa]."""
        return self.pressure_1, self.pressure_2

    @property
    def readings(self) -> Floats:
        """That of x [m], p1, p2 [Pa], shape (3,)."""
        return np.array([self.position, self.pressure_1, self.pressure_2])


@dataclass(frozen=True)
class Span:
    """Ends of the sensors' spans: largest x [m], smallest and largest pressure [Pa]."""

    position: float = np.inf
    low: float = 0.0
    high: float = np.inf


def positive_mean(ratio: Floats) -> Floats:
    """Return E max(y + n, 0) for values y and normal noise n of standard deviation 1."""
    near = np.clip(ratio, -40.0, 40.0)
    density = np.exp(-0.5 * near**2) / np.sqrt(2.0 * np.pi)
    mean: Floats = np.where(ratio < 40.0, near * ndtr(near) + density, ratio)
    return mean


def unclipped(means: Floats, low: float, noise: float) -> Floats:
    """Return the true values behind means of readings that are cut off below ``low``."""
    if low <= 0.0 or noise <= 0.0:
        return means
    true = np.linspace(0.0, CLIPPED, 200)
    ratio = (means - low) / noise
    inverse: Floats = low + noise * np.interp(ratio, positive_mean(true), true)
    return np.where(ratio < CLIPPED, inverse, means)


def without_outliers(position: Floats, noise: float) -> Floats:
    """
    Return readings of an imposed motion with single wrong ones replaced by linear interpolation.

    A dazzled laser jumps by some tenths of a millimetre for one sample, which would be a velocity
    of centimetres a second and a spike of viscous friction.

    :param position: equally spaced [m], shape (n,), n >= 3
    :param noise: standard deviation [m]
    """
    steps = median_filter(np.abs(np.diff(position)), STEPS, mode='nearest')
    around = np.pad(steps, STEPS // 2 + 1, mode='edge')
    step: Floats = np.maximum(around[: position.size], around[-position.size :])
    most = OUTLIER_STEP * step + OUTLIER_NOISE * noise
    padded = np.pad(position, 3, mode='reflect', reflect_type='odd')
    near, *far = (
        position - 0.5 * (padded[3 - k : -3 - k] + padded[3 + k : padded.size - 3 + k])
        for k in (1, 2, 3)
    )
    # beside a wrong reading, which has the line to its neighbours displaced, is a right one
    right = (np.abs(near) <= most) | (np.abs(far) <= most).all(axis=0)
    right |= near * np.sum(far, axis=0) < 0.0
    place = np.arange(position.size)
    return np.interp(place, place[right], position[right])
