"""
The speed of the piston, from the measured position alone.

No single window suits both creep at 1 mm/s and slips of 50 ms. The speed is therefore the slope
of a straight line through as many positions as are consistent with one (Lepski's method). The
shortest line, ``WINDOW``, leaves 0.4 mm/s of the noise and the 73 um steps of the rig's position
sensor. A sensor with more noise or fewer samples gets longer windows that leave the same noise.

Reference: A. Goldenshluger, A. Nemirovski, On spatially adaptive estimation of nonparametric
regression, Math. Methods Statist. 6 (1997).
"""

from collections.abc import Sequence

import numpy as np

from pneu_rig_ros.arrays import Floats

WINDOW = 0.046
"""Length of the shortest line fits that give the speed [s]."""

WIDENING = (1.0, 2.0**0.5, 2.0, 2.0**1.5)
"""Lengths of the line fits that are tried in this order, in shortest ones [-]."""

IMPOSED_FITS = (2, 4, 6, 8, 12)
"""Samples of the line fits to an imposed motion, that are tried in this order."""

FEED_WINDOW = 0.3
"""Length of the line fits that give the mean speed [s], whose noise must not add up."""

RESOLUTION = 0.3 / 4096
"""Smallest step of the rig's position sensor, 300 mm in 12 bits [m]."""

NOISE = 29e-6
"""Standard deviation of a position read by the rig [m]: quantisation, and noise of 20 um."""

SPEED_NOISE = 4e-4
"""Largest noise of the speed that the shortest line fit may leave [m/s]."""

CONSISTENT = 2.4
"""Fits of the speed agree within this many standard deviations [-]."""

LEAST_TRAVEL = 1e-3
"""Smallest travel that counts as motion [m]."""

LEAST_TRAVEL_TO_NOISE = 12.0
"""The same in standard deviations of a reading [-]; the larger of both counts."""

CUBIC = 3
"""
Degree of fits that keep the peak of a slip: what a line misses of it grows with the square of the
window, what a cubic misses with the fourth power.
"""

CUBIC_NOISE = 2.5
"""Noise of the slope of a cubic relative to that of a line through as many samples [-]."""


def velocity_of(
    position: Floats, interval: float, window: float = WINDOW, degree: int = 1
) -> Floats:
    """
    Return the velocity [m/s] of equally spaced positions [m] by fits of polynomials, shape (n,).

    Within half a window of an end it is the slope in the middle of the last fit.

    :param degree: 1 or ``CUBIC``
    """
    size = min(_odd(window / interval), position.size - 1 + position.size % 2)
    if size < degree + 2:
        return np.zeros_like(position)
    slopes = np.convolve(position, _slope_weights(size, interval, degree)[::-1], 'valid')
    return np.pad(slopes, size // 2, mode='edge')


def window_for(interval: float, noise: float = NOISE) -> float:
    """
    Return the length of the shortest line fits that give the speed [s].

    :param interval: sampling interval [s]
    :param noise: standard deviation of a measured position [m]; one smaller than the rig's counts
        as that
    """
    # The noise of a slope falls with the power 3/2 of its window, see ``speed_noise``.
    left = speed_noise(WINDOW, interval, noise)
    return WINDOW * float(max(1.0, (left / SPEED_NOISE) ** (2 / 3)))


def adaptive_velocity(
    position: Floats, interval: float, shortest: float | None, noise: float, degree: int = 1
) -> Floats:
    """
    Return the velocity [m/s] by the longest fits that all shorter ones agree with.

    Lepski's method: each fit has an interval of confidence, and a longer fit is taken as long as
    it lies within those of all the shorter ones.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param shortest: length of the shortest fit [s], None for ``window_for``
    :param noise: standard deviation of a measured position [m]
    :param degree: of the fits, 1 or ``CUBIC``
    """
    shortest = shortest or window_for(interval, noise)
    windows = [factor * shortest for factor in WIDENING]
    return _longest_consistent(
        [velocity_of(position, interval, window, degree) for window in windows],
        [speed_noise(window, interval, noise, degree) for window in windows],
    )


def imposed_velocity(position: Floats, interval: float, noise: float) -> Floats:
    """
    Return the velocity [m/s] between samples of an imposed motion, shape (n - 1,).

    By line fits like ``adaptive_velocity``, but of two samples at first, so that a turn is kept.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param noise: standard deviation of a measured position [m]
    """
    fits, deviations = [], []
    for samples in IMPOSED_FITS:
        weights = _slope_weights(samples, interval)
        padded = np.pad(position, samples // 2 - 1, mode='reflect', reflect_type='odd')
        fits.append(np.convolve(padded, weights[::-1], 'valid'))
        deviations.append(noise * float(np.sqrt(weights @ weights)))
    return _longest_consistent(fits, deviations)


def _longest_consistent(fits: Sequence[Floats], deviations: Sequence[float]) -> Floats:
    """Return at each place the longest fit that agrees with all shorter ones; shortest first."""
    velocity = fits[0]
    low, high = np.full_like(velocity, -np.inf), np.full_like(velocity, np.inf)
    agrees = np.ones(velocity.size, dtype=np.bool_)
    for slope, deviation in zip(fits, deviations, strict=True):
        # Once a fit leaves the intersection of the shorter ones' intervals, the signal bends
        # within its window: its bias exceeds the noise, and longer windows would be worse.
        margin = CONSISTENT * deviation
        agrees &= (slope >= low) & (slope <= high)
        velocity = np.where(agrees, slope, velocity)
        low, high = np.maximum(low, slope - margin), np.minimum(high, slope + margin)
    return velocity


def feed(position: Floats, interval: float, noise: float = NOISE) -> float:
    """Return the feed V: mean speed between the ends of the travel [m/s], 0 at rest."""
    least = least_travel(noise)
    margin = least / 2
    under_way = (position > position.min() + margin) & (position < position.max() - margin)
    if np.ptp(position) < least or not under_way.any():
        return 0.0
    window = FEED_WINDOW * window_for(interval, noise) / WINDOW
    return float(np.abs(velocity_of(position, interval, window))[under_way].mean())


def least_travel(noise: float) -> float:
    """Return the smallest travel that counts as motion [m]."""
    return max(LEAST_TRAVEL, LEAST_TRAVEL_TO_NOISE * noise)


def speed_noise(window: float, interval: float, noise: float, degree: int = 1) -> float:
    """Return the standard deviation [m/s] of the slope of a fit to a window [s]."""
    samples = _odd(window / interval)
    # Least squares: var(slope) = var / sum of squared distances from the middle, ~ n^3 dt^2 / 12.
    of_line = max(noise, NOISE) / interval * float(np.sqrt(12.0 / samples**3))
    return of_line * (CUBIC_NOISE if degree == CUBIC else 1.0)


def running_mean(signal: Floats, interval: float, window: float) -> Floats:
    """Return the mean of a signal over a window [s] around each sample, shape (n,)."""
    size = max(1, round(window / interval))
    padded = np.pad(signal, (size // 2, (size - 1) // 2), mode='symmetric')
    return np.convolve(padded, np.full(size, 1.0 / size), 'valid')


def _slope_weights(size: int, interval: float, degree: int = 1) -> Floats:
    """Return the weights of samples [m] for the slope in the middle of their fit [1/s]."""
    place = (np.arange(size) - 0.5 * (size - 1)) * interval
    weights: Floats = np.linalg.pinv(np.vander(place, degree + 1, increasing=True))[1]
    return weights


def _odd(samples: float) -> int:
    return 2 * round(samples / 2) + 1
