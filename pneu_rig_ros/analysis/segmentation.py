"""
The mode of motion of every sample, from measured position and pressures alone.

Modes divide the motion by its feed V, the mean speed under way: the air raises the driving force
on a piston slower than V, and lowers it on a faster one. So ``STICK`` here is wider than a rest of
``stick_slip``: a piston that creeps at a third of the feed sticks, but does not rest. With |v|
and the friction force F_r of Eq. 2, in the order in which a stick-slip cycle goes through them:

- ``STICK``: the dwell between slides, |v| <= V/2. The bristles carry the rising force. What they
  deflect, the presliding displacement proper of 0.1-0.4 mm, is a few steps of the position
  sensor, and the seal may creep; both are slower than the feed. So creep that comes to rest
  again without getting as fast as the feed is part of the dwell.
- ``PRESLIDING``: the run-up to a breakaway, |v| > V/2 and F_r not yet at its peak.
- ``BREAKAWAY``: from the peak of F_r to gross sliding at 1.4 V, while friction falls and the
  piston runs away. The peak itself is the first sample. A piston that glides off without
  outrunning the feed that far, as with Coulomb friction, has no breakaway and slides at once.
- ``SLIP``: gross sliding, from there until |v| <= V/2. Steady sliding is part of it.
- ``END_STOP``: at 0 or L, the driving force pushing outwards.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.friction import Floats, ForceBalance, friction_zero_phase
from pneu_rig_ros.analysis.stick_slip import Cycle, find_cycles, stretches
from pneu_rig_ros.analysis.velocity import (
    RESOLUTION,
    WINDOW,
    adaptive_velocity,
    feed,
    running_mean,
    speed_noise,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording

MEAN_WINDOW = 0.046
"""Length of the mean of friction force and position, in which a peak stands out [s]."""

PUSH_WINDOW = 0.012
"""Length of the mean of the driving force at an end stop [s]."""

GAIN_ERROR = 0.01
"""Share of the stroke by which the position sensor may be wrong at its end; 0 is 0 [-]."""

AT_STOP = 1.5 * RESOLUTION
"""Readings of a piston at rest are this close to their mean [m]."""

LEAST_PUSH = 1.0
"""A driving force below this is none, by the noise of the pressure sensors [N]."""


LEAST_SPEED_TO_NOISE = 6.6
"""Slower motion than so many standard deviations of the speed gets longer fits [-]."""

DIP = 0.004
"""A dip of the speed as short as this is noise [s]."""

STICK_SHARE = 0.5
"""A piston slower than this share of the feed sticks [-]."""

SLIP_SHARE = 1.4
"""A slide that gets faster than this multiple of the feed is a slip [-]."""


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


class Mode(IntEnum):
    """Mode of motion of a sample; the module says what each one is."""

    STICK = 0
    PRESLIDING = 1
    BREAKAWAY = 2
    SLIP = 3
    END_STOP = 4


Modes = NDArray[np.int8]


class Segmentation(NamedTuple):
    """
    A record cut into modes of motion.

    :param mode: a :class:`Mode` for every sample, shape (n,)
    :param cycles: the stick-slip cycles, as of :func:`stick_slip.find_cycles`
    :param feed: mean speed V of the piston under way [m/s], 0 if it has not moved
    """

    mode: Modes
    cycles: list[Cycle]
    feed: float


def segment(
    position: Floats, pressure_1: Floats, pressure_2: Floats, interval: float,
    balance: ForceBalance, stroke: float,
) -> Segmentation:  # fmt: skip
    """
    Return the mode of every sample, and the cycles.

    :param position: measured position [m], shape (n,), equally spaced
    :param pressure_1: measured absolute pressure of the cap end [Pa], shape (n,)
    :param pressure_2: measured absolute pressure of the rod end [Pa], shape (n,)
    :param interval: sampling interval [s]
    :param balance: the constants of Eq. 2
    :param stroke: L [m]
    :raises RigError: for fewer than 4 samples
    """
    friction = friction_zero_phase(position, pressure_1, pressure_2, interval, balance)
    push = balance.pressure_force(pressure_1, pressure_2)
    force = np.abs(running_mean(friction, interval, MEAN_WINDOW))
    mean = feed(position, interval)
    mode = _modes(find_slides(position, mean, interval), force)
    mode[_held_by_stop(position, push, interval, stroke)] = Mode.END_STOP
    return Segmentation(mode, find_cycles(position, interval, friction), mean)


def segment_record(record: Recording) -> Segmentation:
    """
    Return the modes and cycles of a record.

    :raises RigError: when the record does not say what rig it is of
    """
    if record.configuration is None:
        raise RigError(
            'the bag does not hold the configuration of the rig, so piston areas, mass and stroke '
            'are unknown; import it with --cylinder, or record rig_description too'
        )
    return segment(
        record.position, record.pressure_1, record.pressure_2, record.interval,
        ForceBalance.of(record.configuration), record.configuration.model.cylinder.stroke,
    )  # fmt: skip


def find_slides(position: Floats, mean: float, interval: float) -> list[Slide]:
    """
    Return the slides of a record.

    A dip in the creep before a slide that is shorter than a line fit is noise, not a stick.

    :param position: measured position [m], shape (n,), equally spaced
    :param mean: feed V [m/s], see ``velocity.feed``
    :param interval: sampling interval [s]
    """
    if mean == 0.0:
        return []
    longer = (LEAST_SPEED_TO_NOISE * speed_noise(WINDOW, interval) / mean) ** (2 / 3)
    speed = np.abs(adaptive_velocity(position, interval, WINDOW * max(1.0, longer)))
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
    glides = speed[start:onset].sum() > speed[onset:end].sum()
    return Slide(start, start if glides else onset, end, bool(fast.any()))


def _modes(slides: list[Slide], friction: Floats) -> Modes:
    mode = np.full(friction.size, Mode.STICK, dtype=np.int8)
    for slide in slides:
        peak = _peak(slide, friction)
        mode[slide.start : peak] = Mode.PRESLIDING
        mode[peak : slide.onset] = Mode.BREAKAWAY
        mode[slide.onset : slide.end] = Mode.SLIP
    return mode


def _peak(slide: Slide, friction: Floats) -> int:
    """Return the sample of the largest friction force on the way to gross sliding."""
    return slide.start + int(friction[slide.start : slide.onset + 1].argmax())


def _held_by_stop(
    position: Floats, push: Floats, interval: float, stroke: float
) -> NDArray[np.bool_]:
    """
    Return where an end stop holds the piston, shape (n,).

    The reading at the end L is only known to the gain error of the sensor, so the stop is where
    the piston got farthest. A dwell within the gain error of L that a record ends with cannot be
    told from it.
    """
    held = np.zeros(position.size, dtype=np.bool_)
    force = running_mean(push, interval, PUSH_WINDOW)
    mean = running_mean(position, interval, MEAN_WINDOW)
    for side, end in ((-1, 2 * AT_STOP), (1, (1.0 - GAIN_ERROR) * stroke)):
        pushed = (side * position >= side * end) & (side * force > LEAST_PUSH)
        if pushed.any():
            held |= pushed & (side * position >= (side * mean[pushed]).max() - AT_STOP)
    return held
