"""
Rests, breakaways, stick-slip cycles and end stops, from measured positions.

The piston rests where a line through 46 ms of its positions has a slope below 1 mm/s: 46 um, less
than one step of the rig's 12-bit position sensor. A rest lasts at least 60 ms, and ends with a
breakaway. Data of a sensor with more noise than the rig's, or of slower sampling, take longer
lines and longer rests, see ``velocity.window_for``.

This is the only offline detector of all of these; ``control.observer`` has the only causal one.
Where the pressures are known, the driving force distinguishes a piston that an end stop holds from
one that its seal holds there.

Between two rests the piston slips if it outruns the feed, the mean speed at which the air moves
it; otherwise it creeps, and both rests belong to the same sticking phase. Steady sliding, however
slow, has no rest and so no cycle but that of its breakaway.
"""

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.velocity import (
    NOISE,
    RESOLUTION,
    WINDOW,
    adaptive_velocity,
    feed,
    least_travel,
    running_mean,
    window_for,
)
from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.records import Recording

Sides = NDArray[np.int8]
"""-1 at the inner end stop, x = 0, +1 at the outer one, x = L, 0 at none."""

REST_SPEED = 1e-3
"""A piston slower than this is at rest [m/s]."""

LEAST_REST = 0.06
"""
A rest lasts at least so long [s].

50 ms would do, but the sensor does not resolve that: its noise makes 30 such rests a minute out of
steady motion at 2 mm/s, and none of 60 ms in five minutes.
"""

MEAN_WINDOW = 0.046
"""Length of the mean of friction force and position, in which a peak stands out [s]."""

PUSH_WINDOW = 0.012
"""Length of the mean of the driving force at an end stop [s]."""

GAIN_ERROR = 0.01
"""Gain error of the position sensor, as a share of the stroke; it has no zero error [-]."""

AT_STOP, AT_STOP_NOISE = 1.5, 3.5
"""
Readings of a piston at rest are this close to their mean, in steps of the converter or in standard
deviations of a reading [-].
"""

LEAST_PUSH = 1.0
"""A smaller driving force is within the noise of the pressure sensors [N]."""


class Rest(NamedTuple):
    """A stretch at rest: its first sample, and one after its last."""

    first: int
    end: int


def find_rests(position: Floats, interval: float, noise: float = NOISE) -> list[Rest]:
    """
    Return the rests in the order of time.

    :param position: measured position [m], shape (n,), equally spaced
    :param interval: sampling interval [s]
    :param noise: standard deviation of a measured position [m]
    """
    return rests_of(np.abs(adaptive_velocity(position, interval, None, noise)), interval, noise)


def rests_of(speed: Floats, interval: float, noise: float) -> list[Rest]:
    """Return the rests of a piston with the speed [m/s], shape (n,), by ``adaptive_velocity``."""
    # Each slope describes its whole window. So an interruption shorter than a window is noise, and
    # a rest extends half a window beyond the slow slopes on either side: there the piston comes to
    # rest or sets off, mostly faster than 1 mm/s.
    longer = window_for(interval, noise) / WINDOW
    window = round(longer * WINDOW / interval)
    return [
        Rest(first, end)
        for first, end in stretches(speed < REST_SPEED, window)
        if end - first + window >= longer * LEAST_REST / interval
    ]


def rest_flags(rests: Sequence[Rest], size: int) -> Flags:
    """Return which of a number of samples are in one of the rests, shape (size,)."""
    flags = np.zeros(size, dtype=np.bool_)
    for rest in rests:
        flags[rest.first : rest.end] = True
    return flags


def breakaways(rests: Sequence[Rest], sides: Sides, interval: float) -> list[Rest]:
    """
    Return the rests that end with a breakaway: the seal held the piston until it moved.

    Not the one with which the recording ends, nor one that an end stop holds so long that the mean
    of the driving force does not show when it let go.

    :param rests: in the order of time
    :param sides: what holds the piston, by ``end_stops``, shape (n,)
    :param interval: sampling interval [s]
    """
    mean = max(1, round(PUSH_WINDOW / interval))
    ended = [rest for rest in rests if rest.end < sides.size]
    return [rest for rest in ended if not sides[max(rest.first, rest.end - mean) : rest.end].any()]


def end_stops(
    position: Floats,
    stroke: float,
    interval: float,
    push: Floats | None = None,
    noise: float = NOISE,
    resolution: float = RESOLUTION,
) -> Sides:
    """
    Return which end stop holds the piston, shape (n,).

    The reading at the end L is only known to the gain error of the sensor, so the stop is where
    the piston got farthest. A final dwell within the gain error of L cannot be distinguished from
    it. Without the driving force, a piston that is at an end from the first sample on does not
    count as held, as it may not be pushed. With it, a piston that is no longer pushed there does
    not either: the seal holds it until it breaks away.

    :param position: measured position [m], shape (n,), equally spaced
    :param stroke: L [m]
    :param interval: sampling interval [s]
    :param push: driving force [N], shape (n,), where it is known
    :param noise: standard deviation of a measured position [m]
    :param resolution: step of the position sensor [m]
    """
    margin = max(AT_STOP * max(resolution, RESOLUTION), AT_STOP_NOISE * noise)
    mean = running_mean(position, interval, MEAN_WINDOW)
    rests = find_rests(position, interval, noise)
    place, sides = position.copy(), np.zeros(position.size, dtype=np.int8)
    for first, last in rests:
        place[first:last] = position[first:last].mean()
    for side, end in ((-1, 2 * margin), (1, (1.0 - GAIN_ERROR) * stroke)):
        near = side * place >= side * end
        if push is not None:
            pushed = near & (side * running_mean(push, interval, PUSH_WINDOW) > LEAST_PUSH)
        else:
            came = np.logical_or.accumulate(side * mean < side * end)
            pushed = near & came & rest_flags(rests, position.size)
        if pushed.any():
            farthest = (side * mean[pushed]).max()
            sides[pushed & (side * place >= farthest - margin)] = side
    return sides


def strokes(position: Floats, interval: float, noise: float = NOISE) -> list[tuple[int, int]]:
    """
    Return first sample and one after the last of each stroke: between two changes of direction.

    A reversal shorter than ``velocity.least_travel`` is not counted as a change of direction.
    """
    step = max(1, round(MEAN_WINDOW / interval))
    places = running_mean(position, interval, MEAN_WINDOW)[::step]
    least, turns, far, side = least_travel(noise), [0], 0, 0
    for k, place in enumerate(places.tolist()):
        ahead = place - places[far]
        if side == 0 and abs(ahead) > least:
            side, far = (1 if ahead > 0.0 else -1), k
        elif side * ahead > 0.0:
            far = k
        elif -side * ahead > least:
            turns.append(far * step)
            side, far = -side, k
    return list(itertools.pairwise([*turns, position.size]))


def stretches(flags: Flags, gap: float) -> list[tuple[int, int]]:
    """Return first and last + 1 sample of the stretches of true flags, across shorter gaps."""
    edges = np.diff(np.concatenate([[0], flags, [0]]).astype(np.int8))
    firsts, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
    parts = np.concatenate([[True], firsts[1:] - ends[:-1] >= gap])[: firsts.size]
    lasts = np.roll(parts, -1)
    return list(zip(firsts[parts].tolist(), ends[lasts].tolist(), strict=True))


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

    def to_dict(self) -> dict[str, float | None]:
        """Return plain data for JSON; what is not known is None."""
        return {name: None if np.isnan(value) else value for name, value in self._asdict().items()}


def sticking_phases(
    rests: Sequence[Rest], speed: Floats, mean: float
) -> Iterator[tuple[list[Rest], int]]:
    """
    Yield the rests of each sticking phase, and the sample at which the slip after it ends.

    The phase ends with the first of the ``breakaways`` after which the piston outruns the feed.

    :param speed: of the piston [m/s], shape (n,)
    :param mean: feed V [m/s], see ``velocity.feed``
    """
    phase: list[Rest] = []
    nothing = Rest(speed.size, speed.size)
    for rest, following in itertools.zip_longest(rests, rests[1:], fillvalue=nothing):
        phase.append(rest)
        moving = speed[rest.end : following.first]
        if moving.size and moving.max() > max(mean, REST_SPEED):
            yield phase, following.first
            phase = []


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
    mean_position = running_mean(position, interval, WINDOW)
    for phase, target in sticking_phases(rests_of(speed, interval, noise), speed, mean):
        begin, onset = mean_position[phase[0].first], mean_position[phase[-1].end - 1]
        cycles.append(
            Cycle(
                breakaway_time=phase[-1].end * interval,
                dwell=sum(each.end - each.first for each in phase) * interval,
                slip=abs(float(mean_position[min(target, position.size - 1)] - onset)),
                peak_friction=float(force[phase[0].first : target].max()),
                creep=abs(float(onset - begin)),
            )
        )
    return cycles
