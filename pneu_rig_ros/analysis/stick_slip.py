"""
Stick-slip cycles, from the measured position alone.

Between two rests, see ``motion``, the piston slips if it outruns the feed, the mean speed at which
the air moves it; otherwise it creeps, and both rests belong to the same sticking phase. Steady
sliding, however slow, has no rest and so no cycle but that of its breakaway.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import Floats
from pneu_rig_ros.analysis.motion import REST_SPEED, Rest, rests_of
from pneu_rig_ros.analysis.velocity import NOISE, WINDOW, adaptive_velocity, feed, running_mean
from pneu_rig_ros.records import Recording

PEAK_WINDOW = 0.012
"""Length of the mean that a friction peak is taken of [s], against the noise."""


class Cycle(NamedTuple):
    """
    One sticking phase and the slip after it.

    :param breakaway_time: end of its last rest since the start of the recording [s]
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


def cycles_of(recording: Recording, friction: Floats | None = None) -> list[Cycle]:
    """Return the stick-slip cycles of a recording, found as its noise allows."""
    position = recording.position
    return find_cycles(position, recording.interval, friction, recording.noise['position'])


def find_cycles(
    position: Floats, interval: float, friction: Floats | None = None, noise: float = NOISE
) -> list[Cycle]:
    """
    Return the stick-slip cycles in the order of time.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param friction: friction force F_r [N], shape (n,), for the peaks
    :param noise: standard deviation of a measured position [m]
    """
    speed = np.abs(adaptive_velocity(position, interval, None, noise))
    mean = feed(position, interval, noise)
    if mean == 0.0:
        return []
    force: Floats = np.full(position.size, np.nan)
    if friction is not None:
        force = np.abs(running_mean(friction, interval, PEAK_WINDOW))
    cycles = []
    phase: list[Rest] = []
    rests = rests_of(speed, interval, noise)
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
