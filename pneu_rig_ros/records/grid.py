"""
Fits a uniform sampling grid to the stamps of other recorders.

A recording's samples lie at ``start + k * interval`` exactly. Stamps that do so but for their own
rounding, or with samples missing, are put on that grid as they are. Stamps that jitter by more are
taken as the times of the samples, and the signals are interpolated onto the grid; where two stamps
are farther apart than an interval and a half, samples are missing.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Flags, Floats, Integers
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.recording import Stamps

HELD = ('u', 'voltage_1', 'voltage_2')
"""Signals that keep their value until the next one; the others are interpolated linearly."""

JITTER = 0.02
"""Stamps within this share of the interval of the grid lie on it [-]."""

LONGEST = 4e9
"""Most seconds from the epoch to a sample: in nanoseconds it must be a 64-bit number."""

MOST_MISSING = 1_000_000
"""Samples that may be missing in addition to ten for each recorded one."""


class Columns(NamedTuple):
    """
    Signals at the instants at which they were recorded.

    :param time: [s], shape (n,), increasing
    :param signals: name -> values, SI units, absolute pressures, shape (n,) each
    :param epoch_ns: zero of the time [ns since 1970], 0 if unknown
    :param gauge: whether some were gauge pressures
    :param notes: remarks for the user
    :param metadata: custom data of a bag
    :param protected: whether no message of a bag lacks a checksum
    """

    time: Floats
    signals: Mapping[str, Floats]
    epoch_ns: int
    gauge: bool = False
    notes: tuple[str, ...] = ()
    metadata: Mapping[str, str] = {}
    protected: bool = True


def check_gaps(wanted: int, recorded: int) -> None:
    """Raise RigError when far more samples are wanted than recorded: some stamp must be wrong."""
    if wanted > 10 * recorded + MOST_MISSING:
        raise RigError(
            f'{recorded} samples are stamped as if they were {wanted}: is a stamp wrong, '
            'or were two recordings put together?'
        )


def to_grid(columns: Columns) -> tuple[Stamps, Flags, Mapping[str, Floats], list[str]]:
    """
    Put signals on the uniform grid of their own sampling interval.

    :return: stamps of its n >= 2 samples [ns], shape (n,); which of them were recorded, the others
        are interpolated, shape (n,); the signals, shape (n,) each; what was changed
    :raises RigError: when the stamps are too uneven for such a grid, or too few
    """
    time = columns.time
    if time.size < 2:
        raise RigError(f'{time.size} samples, at least 2 are needed')
    if np.abs(time).max() > LONGEST:
        raise RigError(
            f'times from {time[0]:g} to {time[-1]:g} s: allowed are up to {LONGEST:g} s'
        )
    index, interval, off = fit_grid(time)
    rounding = _resolution(time)
    if off <= max(rounding, JITTER * interval):
        interval_ns = round(shortest_decimal(interval, int(index[-1]), rounding) * 1e9)
        recorded, signals = _filled(index, columns.signals)
        note = ''
    else:
        interval_ns = round(float(np.median(np.diff(time))) * 1e9)
        recorded, signals, note = _interpolated(time, interval_ns, columns.signals)
    start_ns = columns.epoch_ns + round(float(time[0]) * 1e9)
    absent = recorded.size - np.count_nonzero(recorded)
    notes = (
        note,
        f'{absent} of {recorded.size} samples are missing' if absent else '',
        f'time starts at {time[0]:g} s; moved to 0 s' if start_ns < 0 else '',
    )
    stamps = max(start_ns, 0) + interval_ns * np.arange(recorded.size, dtype=np.int64)
    return stamps, recorded, signals, [text for text in notes if text]


def _filled(index: Stamps, signals: Mapping[str, Floats]) -> tuple[Flags, Mapping[str, Floats]]:
    """Return which samples of the grid have these numbers, and signals without gaps."""
    size = int(index[-1]) + 1
    check_gaps(size, index.size)
    recorded = np.zeros(size, dtype=np.bool_)
    recorded[index] = True
    if size == index.size:
        return recorded, signals
    wanted, known = np.arange(size, dtype=np.float64), index.astype(np.float64)
    filled = {name: resample(wanted, known, v, name) for name, v in signals.items()}
    return recorded, filled


def _interpolated(
    time: Floats, interval_ns: int, signals: Mapping[str, Floats]
) -> tuple[Flags, Mapping[str, Floats], str]:
    """Return the same for stamps that are not on the grid, and how that was done."""
    interval, steps = interval_ns * 1e-9, np.diff(time)
    last = (time[-1] - time[0]) / interval
    check_gaps(int(last) + 1, time.size)
    wanted = time[0] + interval * np.arange(int(last + 1e-6) + 1)
    kept = {name: resample(wanted, time, v, name) for name, v in signals.items()}
    note = (
        f'time steps of {1e3 * steps.min():.4g} to {1e3 * steps.max():.4g} ms: interpolated onto '
        f'steps of {1e3 * interval:.4g} ms'
    )
    return _near(wanted, time, interval), kept, note


def _near(wanted: Floats, time: Floats, interval: float) -> Flags:
    """Return which times lie between near samples, or within half an interval of one."""
    after = np.clip(np.searchsorted(time, wanted), 1, time.size - 1)
    before, ahead = time[after - 1], time[after]
    usual = ahead - before < 1.5 * interval
    near: Flags = usual | (np.minimum(wanted - before, ahead - wanted) <= 0.5 * interval)
    return near


def resample(wanted: Floats, known: Floats, values: Floats, name: str) -> Floats:
    """Return a signal at other times, within those that are known; voltages are held."""
    if name in HELD:
        at = np.searchsorted(known, wanted + 1e-9, side='right') - 1
        return np.asarray(values[np.clip(at, 0, None)])
    return np.asarray(np.interp(wanted, known, values))


def fit_grid(time: Floats) -> tuple[Integers, float, float]:
    """
    Return sample numbers, interval and largest distance of stamps from the grid nearest to them.

    Where the stamps are too uneven for a grid there are no numbers, and the distance is infinite.

    :param time: increasing, shape (n,)
    :raises RigError: where no interval fits the steps
    """
    steps = np.diff(time)
    typical = float(np.median(steps))
    if typical < 1e-9 or steps.max() / typical > LONGEST:
        raise RigError(f'time steps of {typical:g} to {steps.max():g} s: no interval fits them')
    counts = np.round(steps / typical).astype(np.int64)
    if (counts < 1).any():
        return np.empty(0, dtype=np.int64), typical, np.inf
    index = np.concatenate([[0], np.cumsum(counts)])
    # By the centred sums: np.polyfit takes ten arrays of this size.
    numbers, since = index - index.mean(), time - time.mean()
    slope = float(numbers @ since / (numbers @ numbers))
    since -= slope * numbers
    return index, slope, float(np.abs(since).max())


def _resolution(time: Floats) -> float:
    """Return the last decimal place [s] that the stamps make use of, 1e-9 at the finest."""
    parts = np.array_split(time, time.size // 10_000 + 1)  # the first one rules most out
    for digits in range(9):
        scaled = (part * 10.0**digits for part in parts)
        if all(np.allclose(part, np.round(part), rtol=0.0, atol=1e-6) for part in scaled):
            return float(10.0**-digits)
    return 1e-9


def shortest_decimal(interval: float, last: int, rounding: float) -> float:
    """
    Return an interval with as few digits as the stamps allow, 1.16 ms and not 1.160003.

    :param last: number of the last sample
    :param rounding: of the stamps, or by how much they jitter
    """
    for digits in range(1, 10):
        shorter = float(f'{interval:.{digits}g}')
        if abs(shorter - interval) * last <= 0.5 * rounding:
            return shorter
    return interval
