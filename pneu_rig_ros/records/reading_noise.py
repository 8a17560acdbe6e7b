"""The noise of a sensor, estimated from its readings and the steps of its converter."""

import numpy as np

from pneu_rig_ros.arrays import Floats

KEPT = 0.9
"""Share of the smallest second differences that count: the others may be motion [-]."""
TRIMMED = 0.79
"""Standard deviation of a normal variable without its largest tenth [-]."""
ROUND_OFF = 1e-9
"""Steps below this share of a signal's largest value are round-off [-]."""


def noise_of(signal: Floats) -> float:
    """Return the standard deviation of a reading [unit], estimated without a data sheet."""
    return reading_noise(signal, smallest_step(signal) / np.sqrt(12.0))


def reading_noise(signal: Floats, configured: float) -> float:
    """
    Return the standard deviation of a reading [unit of the signal].

    Second differences of white noise have six times its variance, while those of a smooth signal
    nearly vanish. A resting signal that stays within one step of its converter shows no noise, so
    the configured noise is the lower limit.

    :param signal: equally spaced readings, shape (n,); NaN for missing ones
    :param configured: standard deviation by the data sheet [unit]
    """
    bends = np.abs(np.diff(signal, 2))
    bends = np.sort(bends[np.isfinite(bends)])
    bends = bends[: max(1, int(KEPT * bends.size))]
    seen = float(np.sqrt(np.mean(bends**2))) / (TRIMMED * np.sqrt(6.0)) if bends.size else 0.0
    return max(seen, float(configured))


def smallest_step(signal: Floats) -> float:
    """Return the smallest step between two readings [unit], 0 where all are equal."""
    known = np.unique(signal[np.isfinite(signal)])
    steps = np.diff(known)
    steps = steps[steps > ROUND_OFF * np.abs(known).max(initial=0.0)]
    return float(steps.min()) if steps.size else 0.0
