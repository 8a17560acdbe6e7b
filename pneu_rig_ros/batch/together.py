"""Plants run together: the same numbers as one after the other, on all processors."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.batch.layout import Row, take_apart
from pneu_rig_ros.batch.loop import loop_over
from pneu_rig_ros.model.integrator import EXTRA_NAMES
from pneu_rig_ros.model.plant import Plant, Trajectory, UnderWay
from pneu_rig_ros.model.valve import FULL_VOLTAGE

Floats = NDArray[np.float64]

_ALONE = threading.Lock()
"""Not every one of Numba's ways to start threads may be used by two threads at a time."""


class _Ready(NamedTuple):
    """A plant, what it goes on from, and its parameters taken apart."""

    number: int
    plant: Plant
    under_way: UnderWay
    row: Row

    @property
    def kind(self) -> tuple[object, ...]:
        """What plants must have in common to go through one loop."""
        one = self.under_way
        return one.run, one.intervals, one.tolerance, one.longest_step, self.row.kind


def run_together(
    plants: Sequence[Plant], voltages: Floats, interval: float, threads: int | None = None
) -> list[Trajectory]:
    """
    Run each plant on as ``Plant.run`` does, to the last bit.

    Plants with the same effects share a compiled loop, which the processors share.

    :param plants: all different
    :param voltages: u1, u2 [V], shape (m, 2), or (n, m, 2) for each of the n plants
    :param interval: [s]
    :param threads: at most; None for as many as Numba is set to
    """
    groups: dict[tuple[object, ...], list[_Ready]] = {}
    for number, plant in enumerate(plants):
        one = plant.under_way
        ready = _Ready(number, plant, one, take_apart((one.model, one.effects)))
        groups.setdefault(ready.kind, []).append(ready)
    clipped = np.clip(voltages if voltages.ndim == 3 else voltages[None], 0.0, FULL_VOLTAGE)
    done: dict[int, Trajectory] = {}
    for group in groups.values():
        numbers = [ready.number for ready in group]
        own = clipped[numbers] if len(clipped) > 1 else clipped
        done |= dict(zip(numbers, _run(group, own, interval, threads), strict=True))
    return [done[number] for number in range(len(plants))]


def _run(
    group: list[_Ready], voltages: Floats, interval: float, threads: int | None
) -> list[Trajectory]:
    """Run plants of one kind; ``voltages`` has shape (1, m, 2) or (n, m, 2)."""
    first, count = group[0].under_way, voltages.shape[1]
    loop = loop_over(first.run.__module__, group[0].row)
    carries = [ready.under_way.carry for ready in group]
    stacked = [np.stack(parts) for parts in zip(*carries, strict=True)]
    rows = np.array([ready.row.numbers for ready in group])
    arrays = tuple(np.stack(each) for each in zip(*(r.row.arrays for r in group), strict=True))
    states = np.empty((len(group), count, group[0].plant.state_size))
    extras = np.empty((len(group), count, len(EXTRA_NAMES)))
    with _ALONE, _shared_by(threads):
        loop(
            rows, arrays, *stacked, interval, first.intervals, voltages, states, extras,
            first.tolerance, first.longest_step,
        )  # fmt: skip
    for number, carry in enumerate(carries):
        for part, whole in zip(carry, stacked, strict=True):
            part[...] = whole[number]
    return [
        ready.plant.advanced(states[number], extras[number], interval)
        for number, ready in enumerate(group)
    ]


@contextmanager
def _shared_by(threads: int | None) -> Iterator[None]:
    """Let so many threads at most share the loops meanwhile, each taking plant after plant."""
    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
    before, size = numba.get_num_threads(), numba.get_parallel_chunksize()
    numba.set_num_threads(min(threads or before, most))
    numba.set_parallel_chunksize(1)
    try:
        yield
    finally:
        numba.set_num_threads(before)
        numba.set_parallel_chunksize(size)
