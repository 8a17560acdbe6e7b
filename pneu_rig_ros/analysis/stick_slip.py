"""
Stick-slip cycles, from measured position and pressures alone.

The speed is the slope of a straight line through ``WINDOW`` of positions, which leaves 0.4 mm/s of
the noise and the 73 um steps of the rig's position sensor. The piston slips where it is faster
than twice its mean speed of the stroke, and sticks where it is slower than half of it. So a steady
motion, however slow, has one cycle, its breakaway from rest, and creep between slips is not
mistaken for one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from pneu_rig_ros.analysis.friction import Floats

WINDOW = 0.046
"""Length of the line fits that give the speed [s]."""

RESOLUTION = 0.3 / 4096
"""Smallest step of the rig's position sensor, 300 mm in 12 bits [m]."""

LEAST_TRAVEL = 1e-3
"""A piston that went less far has not moved [m]."""

PEAK_WINDOW = 0.012
"""Length of the mean that a friction peak is taken of [s], against the noise."""


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


def velocity_of(position: Floats, interval: float) -> Floats:
    """Return the smoothed velocity [m/s] of equally spaced positions [m], shape (n,)."""
    window = min(2 * round(WINDOW / interval / 2) + 1, position.size - 1 + position.size % 2)
    if window < 3:
        return np.zeros_like(position)
    slope: Floats = savgol_filter(position, window, 1, deriv=1, delta=interval)
    return slope


def find_cycles(position: Floats, interval: float, friction: Floats | None = None) -> list[Cycle]:
    """
    Return the stick-slip cycles of a record in the order of time.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param friction: friction force F_r [N], shape (n,), for the peaks
    """
    speed = np.abs(velocity_of(position, interval))
    mean = _mean_speed(position, speed)
    if mean == 0.0:
        return []
    slip_speed = mean + max(mean, 1.5 * RESOLUTION / WINDOW)
    force = _smooth_force(friction, interval, position.size)
    cycles = []
    rest = 0
    for start, end in _slips(speed, slip_speed, mean / 2):
        peak = float(force[rest:end].max())
        slip = abs(float(position[end - 1] - position[start]))
        cycles.append(Cycle(start * interval, (start - rest) * interval, slip, peak))
        rest = end
    return cycles


def _mean_speed(position: Floats, speed: Floats) -> float:
    """Return the mean speed between leaving the first and reaching the last position [m/s]."""
    moving = np.flatnonzero(
        (np.abs(position - position[0]) > LEAST_TRAVEL / 2)
        & (np.abs(position - position[-1]) > LEAST_TRAVEL / 2)
    )
    if moving.size == 0 or np.ptp(position) < LEAST_TRAVEL:
        return 0.0
    return float(speed[moving[0] : moving[-1] + 1].mean())


def _slips(speed: Floats, above: float, below: float) -> list[tuple[int, int]]:
    """Return first and last + 1 sample of each slip: it begins above and ends below."""
    level = np.where(speed > above, 1, np.where(speed < below, -1, 0))
    decided = np.flatnonzero(level)
    if decided.size == 0:
        return []
    # Between the two levels the piston goes on doing what it did.
    held = np.maximum.accumulate(np.where(level != 0, np.arange(level.size), decided[0]))
    slipping = np.concatenate([[0], level[held] > 0, [0]]).astype(np.int64)
    edges = np.diff(slipping)
    firsts, ends = np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist()
    return list(zip(firsts, ends, strict=True))


def _smooth_force(friction: Floats | None, interval: float, size: int) -> Floats:
    if friction is None:
        return np.full(size, np.nan)
    mean: Floats = uniform_filter1d(friction, max(1, round(PEAK_WINDOW / interval)))
    return np.abs(mean)
