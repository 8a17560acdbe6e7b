"""
The mode of motion of every sample, from measured position and pressures alone.

V is the feed of a record, its mean speed under way, see ``stick_slip``: the air raises the driving
force on a piston slower than V, and lowers it on a faster one. With |v| and the friction force F_r
of Eq. 2, in the order in which a stick-slip cycle goes through them:

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
from pneu_rig_ros.analysis.stick_slip import (
    RESOLUTION,
    Cycle,
    Motion,
    Slide,
    analyse_motion,
    cycles_of,
    running_mean,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Record

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
    motion = analyse_motion(position, interval)
    mode = _modes(motion, np.abs(running_mean(friction, interval, MEAN_WINDOW)))
    mode[_held_by_stop(position, push, interval, stroke)] = Mode.END_STOP
    return Segmentation(mode, cycles_of(motion, position, interval, friction), motion.feed)


def segment_record(record: Record) -> Segmentation:
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


def _modes(motion: Motion, friction: Floats) -> Modes:
    mode = np.full(motion.speed.size, Mode.STICK, dtype=np.int8)
    for slide in motion.slides:
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
