"""
Rests, slips and stick-slip cycles, from the measured position alone.

The piston rests where a line through 46 ms of its positions has a slope below 1 mm/s: 46 um,
less than one step of the rig's 12-bit position sensor. A rest lasts at least 60 ms. Between two
rests the piston slips if it outruns the feed, the mean speed at which the air moves it;
otherwise it creeps, and both rests belong to the same sticking phase. Steady sliding, however
slow, has no rest and so no cycle but that of its breakaway.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.friction import Floats
from pneu_rig_ros.analysis.velocity import WINDOW, adaptive_velocity, feed, running_mean

REST_SPEED = 1e-3
"""A piston slower than this is at rest [m/s]."""

LEAST_REST = 0.06
"""
A rest lasts at least so long [s].

50 ms would do, but the sensor does not resolve that: its noise makes 30 such rests a minute out of
steady motion at 2 mm/s, and none of 60 ms in five minutes.
"""

PEAK_WINDOW = 0.012
"""Length of the mean that a friction peak is taken of [s], against the noise."""


class Rest(NamedTuple):
    """
    A stretch at rest.

    :param first: its first sample
    :param end: one after its last sample
    """

    first: int
    end: int


class Cycle(NamedTuple):
    """
    One sticking phase and the slip after it.

    :param breakaway_time: end of its last rest since the start of the record [s]
    :param dwell: time at rest in the phase [s]
    :param slip: distance moved in the slip [m]
    :param peak_friction: largest friction force from stick to slip [N], NaN if not asked for
    :param creep: distance moved from the first rest of the phase to the breakaway [m]
    """

    breakaway_time: float
    dwell: float
    slip: float
    peak_friction: float
    creep: float


def find_rests(position: Floats, interval: float) -> list[Rest]:
    """
    Return the rests of a record in the order of time.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    """
    return rests_of(np.abs(adaptive_velocity(position, interval)), interval)


def rests_of(speed: Floats, interval: float) -> list[Rest]:
    """Return the rests of a piston with the speed [m/s], shape (n,), by ``adaptive_velocity``."""
    # a slope that is so small says so of its whole window: what keeps it from being so for less
    # than a window is noise, and the rest reaches half a window further than the slopes. There the
    # piston comes to rest and sets off, faster than 1 mm/s for the most part.
    window = round(WINDOW / interval)
    return [
        Rest(first, end)
        for first, end in stretches(speed < REST_SPEED, window)
        if end - first + window >= LEAST_REST / interval
    ]


def find_cycles(position: Floats, interval: float, friction: Floats | None = None) -> list[Cycle]:
    """
    Return the stick-slip cycles of a record in the order of time.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param friction: friction force F_r [N], shape (n,), for the peaks
    """
    speed, mean = np.abs(adaptive_velocity(position, interval)), feed(position, interval)
    if mean == 0.0:
        return []
    force: Floats = np.full(position.size, np.nan)
    if friction is not None:
        force = np.abs(running_mean(friction, interval, PEAK_WINDOW))
    cycles = []
    phase: list[Rest] = []
    rests = rests_of(speed, interval)
    mean_position = running_mean(position, interval, WINDOW)
    nothing = Rest(position.size, position.size)
    for rest, following in itertools.zip_longest(rests, rests[1:], fillvalue=nothing):
        phase.append(rest)
        moving = speed[rest.end : following.first]
        if not (moving.size and moving.max() > max(mean, REST_SPEED)):
            continue
        begin, onset = mean_position[phase[0].first], mean_position[rest.end - 1]
        target = mean_position[min(following.first, position.size - 1)]
        cycles.append(Cycle(
            breakaway_time=rest.end * interval,
            dwell=sum(each.end - each.first for each in phase) * interval,
            slip=abs(float(target - onset)),
            peak_friction=float(force[phase[0].first : following.first].max()),
            creep=abs(float(onset - begin)),
        ))  # fmt: skip
        phase = []
    return cycles


def stretches(flags: NDArray[np.bool_], gap: float) -> list[tuple[int, int]]:
    """Return first and last + 1 sample of the stretches of true flags, across shorter gaps."""
    edges = np.diff(np.concatenate([[0], flags, [0]]).astype(np.int8))
    firsts, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
    parts = np.concatenate([[True], firsts[1:] - ends[:-1] >= gap])[: firsts.size]
    lasts = np.roll(parts, -1)
    return list(zip(firsts[parts].tolist(), ends[lasts].tolist(), strict=True))
