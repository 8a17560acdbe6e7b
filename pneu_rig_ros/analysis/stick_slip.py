"""
Slides and stick-slip cycles, from the measured position alone.

A stick-slip motion is judged against its mean speed V, the speed at which the air feeds the
piston: a piston that lags behind it compresses the driving force further, one that outruns it
relaxes the force. The piston slides where it is faster than V/2, and sticks where it is slower.
Where it outruns the feed by a factor of two, the slide is a slip and ends a cycle. So steady
motion, however slow, has no cycle but that of its breakaway, if it overshoots, and creep between
slips is not mistaken for one.

One window cannot serve creep of 1 mm/s and slips of 50 ms: the speed is the slope of a straight
line through as many positions as are consistent with one (Lepski's method), at first ``WINDOW``,
which leaves 0.4 mm/s of the noise and the 73 um steps of the rig's position sensor.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from pneu_rig_ros.analysis.friction import Floats

WINDOW = 0.046
"""Length of the shortest line fits that give the speed [s]."""

WIDENING = (1.0, 2.0**0.5, 2.0, 2.0**1.5)
"""Lengths of the line fits that are tried in this order, in shortest ones [-]."""

FEED_WINDOW = 0.3
"""Length of the line fits that give the mean speed [s], whose noise must not add up."""

RESOLUTION = 0.3 / 4096
"""Smallest step of the rig's position sensor, 300 mm in 12 bits [m]."""

NOISE = 29e-6
"""Standard deviation of a measured position [m]: quantisation, and noise of 20 um."""

CONSISTENT = 2.4
"""Two fits of the speed agree within so many standard deviations [-]."""

LEAST_SPEED_TO_NOISE = 6.6
"""Slower motion than so many standard deviations of the speed gets longer fits [-]."""

DIP = 0.004
"""A dip of the speed as short as this is noise [s]."""

LEAST_TRAVEL = 1e-3
"""A piston that went less far has not moved [m]."""

PEAK_WINDOW = 0.012
"""Length of the mean that a friction peak is taken of [s], against the noise."""

STICK_SHARE = 0.5
"""A piston slower than this share of the feed sticks [-]."""

SLIP_SHARE = 1.4
"""A slide that gets faster than this multiple of the feed is a slip [-]."""


class Cycle(NamedTuple):
    """
    One stick and the slip after it.

    :param breakaway_time: start of the slip since the start of the record [s]
    :param dwell: length of the stick before it [s]
    :param slip: distance moved in the slip [m]
    :param peak_friction: largest friction force from stick to slip [N], NaN if not asked for
    """

    breakaway_time: float
    dwell: float
    slip: float
    peak_friction: float


class Slide(NamedTuple):
    """
    A stretch of motion faster than V/2 that gets as fast as V, in samples.

    :param start: first sample faster than V/2, but for short dips
    :param onset: where gross sliding begins: first sample faster than 1.4 V; equal to ``start``
        when the piston glides off without overshoot, or glides further than it slips
    :param end: one after the last sample
    :param slips: whether it gets faster than 1.4 V
    """

    start: int
    onset: int
    end: int
    slips: bool


class Motion(NamedTuple):
    """
    What the positions say of the motion.

    :param speed: |v| [m/s], shape (n,)
    :param feed: mean speed V [m/s], 0 when the piston has not moved
    :param slides: in the order of time
    """

    speed: Floats
    feed: float
    slides: list[Slide]


def velocity_of(position: Floats, interval: float, window: float = WINDOW) -> Floats:
    """Return the velocity [m/s] of equally spaced positions [m] by line fits, shape (n,)."""
    size = min(_odd(window / interval), position.size - 1 + position.size % 2)
    if size < 3:
        return np.zeros_like(position)
    slope: Floats = savgol_filter(position, size, 1, deriv=1, delta=interval)
    return slope


def find_cycles(position: Floats, interval: float, friction: Floats | None = None) -> list[Cycle]:
    """
    Return the stick-slip cycles of a record in the order of time.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param friction: friction force F_r [N], shape (n,), for the peaks
    """
    return cycles_of(analyse_motion(position, interval), position, interval, friction)


def cycles_of(
    motion: Motion, position: Floats, interval: float, friction: Floats | None = None
) -> list[Cycle]:
    """Return the cycles of a motion; parameters as of :func:`find_cycles`."""
    force: Floats = np.full(position.size, np.nan)
    if friction is not None:
        force = np.abs(running_mean(friction, interval, PEAK_WINDOW))
    cycles = []
    rest = 0
    for _, onset, end, slips in motion.slides:
        if slips:
            peak = float(force[rest:end].max())
            slip = abs(float(position[end - 1] - position[onset]))
            cycles.append(Cycle(onset * interval, (onset - rest) * interval, slip, peak))
        rest = end
    return cycles


def analyse_motion(position: Floats, interval: float) -> Motion:
    """Return speed, feed and slides of a record; parameters as of :func:`find_cycles`."""
    feed = _feed(position, interval)
    if feed == 0.0:
        return Motion(np.abs(velocity_of(position, interval)), 0.0, [])
    longer = (LEAST_SPEED_TO_NOISE * _speed_noise(WINDOW, interval) / feed) ** (2 / 3)
    speed = np.abs(_adaptive_velocity(position, interval, WINDOW * max(1.0, longer)))
    return Motion(speed, feed, _slides(speed, feed, interval))


def running_mean(signal: Floats, interval: float, window: float) -> Floats:
    """Return the mean of a signal over a window [s] around each sample, shape (n,)."""
    mean: Floats = uniform_filter1d(signal, max(1, round(window / interval)))
    return mean


def _slides(speed: Floats, feed: float, interval: float) -> list[Slide]:
    """Return the slides; a dip in the creep before one that is shorter than a fit is no dwell."""
    slides: list[Slide] = []
    creep_start, creep_end = 0, -speed.size
    for first, end in _stretches(speed > STICK_SHARE * feed, DIP / interval):
        start = creep_start if first - creep_end < WINDOW / 2 / interval else first
        if speed[first:end].max() > feed:
            slides.append(_slide(speed, feed, start, end))
            creep_start, creep_end = 0, -speed.size
        else:
            creep_start, creep_end = start, end
    return slides


def _stretches(flags: NDArray[np.bool_], gap: float) -> list[tuple[int, int]]:
    """Return first and last + 1 sample of the stretches of true flags, across short gaps."""
    edges = np.diff(np.concatenate([[0], flags, [0]]).astype(np.int8))
    firsts, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
    parts = np.concatenate([[True], firsts[1:] - ends[:-1] >= gap])[: firsts.size]
    lasts = np.roll(parts, -1)
    return list(zip(firsts[parts].tolist(), ends[lasts].tolist(), strict=True))


def _slide(speed: Floats, feed: float, start: int, end: int) -> Slide:
    fast = speed[start:end] > SLIP_SHARE * feed
    onset = start + int(fast.argmax())
    glides = speed[start:onset].sum() > speed[onset:end].sum()
    return Slide(start, start if glides else onset, end, bool(fast.any()))


def _feed(position: Floats, interval: float) -> float:
    """Return the mean speed between the ends of the travel [m/s], 0 for a piston at rest."""
    margin = LEAST_TRAVEL / 2
    under_way = (position > position.min() + margin) & (position < position.max() - margin)
    if np.ptp(position) < LEAST_TRAVEL or not under_way.any():
        return 0.0
    return float(np.abs(velocity_of(position, interval, FEED_WINDOW))[under_way].mean())


def _adaptive_velocity(position: Floats, interval: float, shortest: float) -> Floats:
    """
    Return the velocity [m/s] by the longest line fits that all shorter ones agree with.

    Lepski's method: each fit has an interval of confidence, and a longer fit is taken as long as
    it lies within those of all the shorter ones.
    """
    velocity = velocity_of(position, interval, shortest)
    low, high = np.full_like(velocity, -np.inf), np.full_like(velocity, np.inf)
    agrees = np.ones(velocity.size, dtype=np.bool_)
    for factor in WIDENING:
        slope = velocity_of(position, interval, factor * shortest)
        margin = CONSISTENT * _speed_noise(factor * shortest, interval)
        agrees &= (slope >= low) & (slope <= high)
        velocity = np.where(agrees, slope, velocity)
        low, high = np.maximum(low, slope - margin), np.minimum(high, slope + margin)
    return velocity


def _speed_noise(window: float, interval: float) -> float:
    """Return the standard deviation [m/s] of the slope of a line through a window [s]."""
    samples = _odd(window / interval)
    return NOISE / interval * float(np.sqrt(12.0 / samples**3))


def _odd(samples: float) -> int:
    return 2 * round(samples / 2) + 1
