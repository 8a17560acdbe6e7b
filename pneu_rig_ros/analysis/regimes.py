"""
The regime of motion of every sample, from measured position and pressures.

Regimes divide each stroke by its feed V, the mean speed under way: the air raises the driving
force on a piston slower than V, and lowers it on a faster one. So ``DWELL`` is wider than a
rest of ``motion``: a piston that creeps at a third of the feed dwells, but does not rest. With
|v|, and the friction force F_r of Eq. 2, in the order in which a stick-slip cycle goes through
them:

- ``DWELL``: between slides, |v| <= V/2. The bristles carry the rising force. What they deflect,
  the presliding displacement proper of 0.1-0.4 mm, is a few steps of the position sensor, and the
  seal may creep; both are slower than the feed. So creep that comes to rest again without getting
  as fast as the feed is part of the dwell.
- ``PRESLIDING``: the run-up to a breakaway, |v| > V/2 and F_r not yet at its peak.
- ``BREAKAWAY``: from that peak to gross sliding at 1.4 V, while friction falls and the piston runs
  away: what a breakaway of ``motion`` begins. The peak itself is the first sample. A piston that
  glides off without outrunning the feed that far, as with Coulomb friction, has no such regime and
  slides at once.
- ``SLIDING``: gross sliding, from there until |v| <= V/2. Steady sliding is part of it.
- ``END_STOP``: at 0 or L, the driving force pushing outwards.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.friction import ForceBalance, friction_of, require_rig
from pneu_rig_ros.analysis.motion import MEAN_WINDOW, end_stops, stretches, strokes
from pneu_rig_ros.analysis.velocity import (
    NOISE,
    RESOLUTION,
    WINDOW,
    adaptive_velocity,
    feed,
    running_mean,
    speed_noise,
)
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.effect import Regime
from pneu_rig_ros.records import Recording

Regimes = NDArray[np.int8]

LEAST_SPEED_TO_NOISE = 6.6
"""Motion slower than this many standard deviations of the speed gets longer fits [-]."""

DIP = 0.004
"""A dip of the speed as short as this is noise [s]."""

STICK_SHARE = 0.5
"""A piston slower than this share of the feed dwells [-]."""

SLIP_SHARE = 1.4
"""A slide that gets faster than this multiple of the feed is a slip [-]."""


class Slide(NamedTuple):
    """
    A stretch of motion faster than V/2 that gets as fast as V: first sample, one after the last.

    :param onset: where gross sliding begins: first sample faster than 1.4 V; equal to ``start``
        when the piston glides off without overshoot, or glides further than it slips
    """

    start: int
    onset: int
    end: int


def regimes(
    position: Floats,
    interval: float,
    stroke: float,
    friction: Floats,
    push: Floats,
    noise: float = NOISE,
    resolution: float = RESOLUTION,
) -> Regimes:
    """
    Return the :class:`Regime` of every sample, shape (n,), as defined above.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param stroke: L [m]
    :param friction: F_r of Eq. 2 [N], shape (n,)
    :param push: driving force of the air [N], shape (n,)
    :param noise: standard deviation of a measured position [m]
    :param resolution: step of the position sensor [m]
    """
    found = np.full(position.size, Regime.DWELL, dtype=np.int8)
    load = np.abs(running_mean(friction, interval, MEAN_WINDOW))
    for first, end in strokes(position, interval, noise):
        part = position[first:end]
        mean = feed(part, interval, noise)
        for slide in find_slides(part, mean, interval, noise):
            # the largest friction force on the way to gross sliding
            rise = load[first + slide.start : first + slide.onset + 1]
            peak = slide.start + int(rise.argmax())
            found[first + slide.start : first + peak] = Regime.PRESLIDING
            found[first + peak : first + slide.onset] = Regime.BREAKAWAY
            found[first + slide.onset : first + slide.end] = Regime.SLIDING
    sides = end_stops(position, stroke, interval, push, noise, resolution)
    found[sides != 0] = Regime.END_STOP
    return found


def regimes_of(recording: Recording) -> Regimes:
    """
    Return the regime of every sample of a recording of a whole rig.

    :raises RigError: when it lacks the configuration of the rig, or has fewer than 4 samples
    """
    rig = require_rig(recording)
    push = ForceBalance.of(rig).pressure_force(recording.pressure_1, recording.pressure_2)
    return regimes(
        recording.position,
        recording.interval,
        rig.model.cylinder.stroke,
        friction_of(recording),
        push,
        recording.noise['position'],
        recording.resolution['position'],
    )


def find_slides(position: Floats, mean: float, interval: float, noise: float) -> list[Slide]:
    """
    Return the slides of a piston.

    A dip in the creep before a slide that is shorter than a line fit is noise, not a stick.

    :param position: measured position [m], shape (n,), equally spaced
    :param mean: feed V [m/s], see ``velocity.feed``
    :param interval: sampling interval [s]
    :param noise: standard deviation of a measured position [m]
    """
    if mean == 0.0:
        return []
    longer = (LEAST_SPEED_TO_NOISE * speed_noise(WINDOW, interval, noise) / mean) ** (2 / 3)
    window = WINDOW * max(1.0, longer)
    speed = np.abs(adaptive_velocity(position, interval, window, noise))
    slides: list[Slide] = []
    creep_start, creep_end = 0, -speed.size
    for first, end in stretches(speed > STICK_SHARE * mean, DIP / interval):
        start = creep_start if first - creep_end < WINDOW / 2 / interval else first
        if speed[first:end].max() > mean:
            slides.append(_slide(speed, mean, start, end))
            creep_start, creep_end = 0, -speed.size
        else:
            creep_start, creep_end = start, end
    return slides


def _slide(speed: Floats, mean: float, start: int, end: int) -> Slide:
    fast = speed[start:end] > SLIP_SHARE * mean
    onset = start + int(fast.argmax())
    if speed[start:onset].sum() > speed[onset:end].sum():  # it glides farther than it slips
        onset = start
    return Slide(start, onset, end)
