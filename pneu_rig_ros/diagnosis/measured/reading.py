"""Readings of sensors: their noise, smoothed, and the ends of their spans, where it is cut off."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.signal import savgol_filter
from scipy.special import ndtr

from pneu_rig_ros.arrays import Flags, Floats

CLIPPED = 4.0
"""Standard deviations from the end of a span within which noise is cut off on one side [-]."""
CLIPPED_NEARBY = 51
"""Readings around one at the end of a span of which noise may be cut off."""
MOST_CLIPPED = 0.9
"""Share of such readings up to which the noise is that of the others [-]."""

OUTLIER_NOISE, OUTLIER_STEP = 6.0, 0.5
"""A reading is wrong that is farther off: so many standard deviations, and steps around it [-]."""
AROUND = 6
"""Readings before and after one, by which it is judged: up to three in succession may be wrong."""
MOST_WRONG = 0.2
"""Share of the readings around that may be wrong; where a motion turns every few, more seem so."""

SMOOTHING = 0.07
"""
Window of the quartics that smooth position and pressures [s]: they follow a filling. Noise that is
left bends the seal of a piston at rest to and fro; with that of parabolas of 25 ms what its film
feels of it made 0.2 N in the slip that follows.
"""
QUARTIC, FEWEST_SMOOTHED = 4, 11
"""Degree, and samples in such a window at least: a fit to fewer would hardly smooth."""
BEGINNING = 0.025
"""Length of the readings of where the piston began [s]."""


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


def smoothed(columns: Floats, interval: float) -> Floats:
    """Return readings at equal intervals [s] without most of their noise, shape (n, k)."""
    size = 2 * round(0.5 * SMOOTHING / interval) + 1
    return savgol_filter(columns, size, QUARTIC, axis=0) if size >= FEWEST_SMOOTHED else columns


def first_of(readings: Floats, interval: float) -> float:
    """Return what readings at equal intervals [s] begin with: the mean of the first few."""
    return float(readings[: max(round(BEGINNING / interval), 1)].mean())


def positive_mean(ratio: Floats) -> Floats:
    """Return E max(y + n, 0) for values y and normal noise n of standard deviation 1."""
    mean: Floats = np.maximum(ratio, 0.0)
    near = np.abs(ratio) < 9.0  # beyond it nothing is cut off, to 1e-20
    y = ratio[near]
    mean[near] = y * ndtr(y) + np.exp(-0.5 * y**2) / np.sqrt(2.0 * np.pi)
    return mean


def unclipped(means: Floats, low: float, noise: float) -> Floats:
    """Return the true values behind means of readings that are cut off below ``low``."""
    if low <= 0.0 or noise <= 0.0:
        return means
    true = np.linspace(0.0, CLIPPED, 200)
    ratio = (means - low) / noise
    inverse: Floats = low + noise * np.interp(ratio, positive_mean(true), true)
    return np.where(ratio < CLIPPED, inverse, means)


def without_clipped(signal: Floats, low: float) -> Floats:
    """
    Return readings with those near any at the low end of their span as NaN, shape (n,).

    What is cut off there would show too little noise. All are kept where hardly any other is left.
    """
    near = maximum_filter1d(signal <= low, CLIPPED_NEARBY)
    return signal if near.mean() > MOST_CLIPPED else np.where(near, np.nan, signal)


def from_when(begins: Flags, goes_on: Flags) -> Flags:
    """Return where something goes on that has begun since it last did not, shape (n,) each."""
    count = np.cumsum(begins & goes_on)
    before = np.maximum.accumulate(np.where(goes_on, 0, count))
    return goes_on & (count > before)


def missed_turns(position: Floats, noise: float) -> Floats:
    """
    Return how far an imposed motion that turned near a sample went on unseen [m], shape (n,).

    At constant speeds that is half the smaller of the second differences of the samples before and
    after the turn. 0 where it is noise.

    :param position: equally spaced [m], shape (n,)
    :param noise: standard deviation [m]
    """
    bend = np.pad(np.abs(np.diff(position, 2)), 1)
    missed = 0.5 * np.minimum(bend[1:], bend[:-1])
    missed[missed < CLIPPED * noise] = 0.0
    largest: Floats = np.maximum(np.append(missed, 0.0), np.append(0.0, missed))
    return largest


def without_outliers(position: Floats, noise: float) -> Floats:
    """
    Return readings of an imposed motion with the wrong ones replaced by linear interpolation.

    A dazzled laser jumps by some tenths of a millimetre, and back after a sample or a few. That
    would be a velocity of centimetres a second, and two turns, at which the bristles bend over.
    A wrong reading is off, in one direction, from where the motion before it leads, from where
    that after it comes from, and from the middle of both. At a turn the first two are beyond a
    right one, and the middle is on this side of it.

    :param position: equally spaced [m], shape (n,), n >= 3
    :param noise: standard deviation [m]
    """
    padded = np.pad(position, AROUND + 1, mode='reflect', reflect_type='odd')
    places = np.arange(position.size)[:, np.newaxis] + AROUND + 1
    away = np.arange(1, AROUND + 1)
    steps = np.diff(padded)
    before, after = padded[places - away], padded[places + away]
    slope_before = np.median(steps[places - 1 - away], axis=1, keepdims=True)
    slope_after = np.median(steps[places + away], axis=1, keepdims=True)
    expected = before + away * slope_before, after - away * slope_after, 0.5 * (before + after)
    off = position - np.array([np.median(each, axis=1) for each in expected])
    usual = np.maximum(np.abs(slope_before), np.abs(slope_after))[:, 0]
    least = OUTLIER_STEP * usual + OUTLIER_NOISE * noise
    wrong = (off > least).all(axis=0) | (off < -least).all(axis=0)
    right = ~wrong | (uniform_filter1d(wrong.astype(float), 4 * AROUND + 1) > MOST_WRONG)
    place = np.arange(position.size)
    cleaned: Floats = np.interp(place, place[right], position[right])
    return cleaned
