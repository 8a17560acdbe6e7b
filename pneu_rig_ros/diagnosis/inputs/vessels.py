"""Recordings of closed vessels: from when on they are shut, and until when they show a leak."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.records.recording import PRESSURES, Recording

BLOCKS = (300, 100, 30)
"""Into so many blocks a recording is divided, the finest first."""
SHORTEST_BLOCK = 3
"""Samples of a block at least: its mean is less noisy than they are."""
HELD = 0.1
"""Largest change in a block while a vessel is fed, of the fall when it is shut [-]."""
CLEAR = 10.0
"""Least fall in a block after that, in standard deviations: none of 300 has it by chance."""
LEAST_FALL = 0.02
"""Share of its pressure that a vessel loses at least: a drift of temperature may take less [-]."""
SHUTTING = 3
"""Blocks before the fastest fall in which a vessel is shut, one of which is of both states."""
NEARLY_ALL = 0.98
"""Share of its way after which a pressure is taken for constant [-]."""


def from_shutting(recording: Recording) -> Recording:
    """
    Return the part of a recording in which all vessels are shut, with a note on what is not used.

    A shut vessel empties fastest while it is fullest. If its pressure is constant at first and
    then falls at once, it was fed until then.
    """
    start = max(shut_at(p, noise) for p, noise in _pressures(recording))
    if start == 0:
        return recording
    before = f'the first {start * recording.interval:.1f} s, until it was shut, are not used'
    return with_note(recording.cut(start, recording.size), f'{before}; times count from there')


def shut_at(pressure: Floats, noise: float) -> int:
    """
    Return the sample from which on a vessel is shut, 0 if it is from the first.

    :param noise: standard deviation of the readings [Pa]
    """
    ends = _means(pressure, max(pressure.size // BLOCKS[-1], 1))
    if ends[-1] > (1.0 - LEAST_FALL) * ends[0]:
        return 0
    for count in BLOCKS:
        size = pressure.size // count
        if size < SHORTEST_BLOCK:
            continue
        fall = -np.diff(_means(pressure, size))
        fastest = int(np.argmax(fall))
        before = fall[: max(fastest - SHUTTING, 0)]
        clear = fall[fastest] > CLEAR * noise * np.sqrt(2.0 / size)
        if before.size and clear and np.abs(before).max() < HELD * fall[fastest]:
            return (fastest + 1) * size
    return 0


def changes_until(recording: Recording) -> int:
    """Return the sample until which a pressure changes: nearly all of the way that it goes."""
    size = max(recording.size // BLOCKS[-1], 1)
    ends = []
    for pressure, _ in _pressures(recording):
        way = np.cumsum(np.abs(np.diff(_means(pressure, size))))
        ends.append((int(np.searchsorted(way, NEARLY_ALL * way[-1])) + 2) * size)
    return min(max(ends), recording.size)


def is_empty(recording: Recording, others: Iterable[Recording], usual: float) -> bool:
    """
    Return whether vessels are at atmospheric pressure, or nearly so, of what others have at most.

    :param usual: pressure of the atmosphere where a recording states none [Pa]
    """
    most = max(_largest_gauge(other, usual) for other in others)
    return _largest_gauge(recording, usual) < (1.0 - NEARLY_ALL) * most


def with_note(recording: Recording, note: str) -> Recording:
    """Return a recording with one more note."""
    return replace(recording, notes=(*recording.notes, note))


def _largest_gauge(recording: Recording, usual: float) -> float:
    """Return by how much a pressure is off that of the atmosphere at most, above or below [Pa]."""
    atmosphere = recording.conditions.get('atmospheric_pressure', usual)
    return max(float(np.abs(p - atmosphere).max()) for p, _ in _pressures(recording))


def _pressures(recording: Recording) -> list[tuple[Floats, float]]:
    """Return the pressure of each vessel [Pa], shape (n,), with the noise of its readings [Pa]."""
    return [(recording[p], recording.noise[p]) for p in PRESSURES if p in recording]


def _means(values: Floats, size: int) -> Floats:
    """Return the means of blocks of a size, shape (n // size,)."""
    means: Floats = values[: values.size // size * size].reshape(-1, size).mean(axis=1)
    return means
