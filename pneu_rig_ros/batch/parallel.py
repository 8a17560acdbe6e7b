"""Simulation of many plants in parallel, with the same numbers as one after the other."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.batch.layout import PackedParameters, pack_parameters
from pneu_rig_ros.batch.loop import loop_over
from pneu_rig_ros.model.imposed import Actions
from pneu_rig_ros.model.integrator import EXTRA_NAMES
from pneu_rig_ros.model.plant import FREE, Plant, RunState, Trajectory
from pneu_rig_ros.model.valve import FULL_VOLTAGE

Floats = NDArray[np.float64]

_LOCK = threading.Lock()
"""Some threading layers of Numba cannot be used by two threads at a time."""


class _Ready(NamedTuple):
    """A plant, the state of its run, and its packed parameters."""

    number: int
    plant: Plant
    run_state: RunState
    packed: PackedParameters

    @property
    def kind(self) -> tuple[object, ...]:
        """Equal for plants that one loop can run."""
        one = self.run_state
        return one.run, one.intervals, one.tolerance, one.longest_step, self.packed.kind


def run_parallel(
    plants: Sequence[Plant],
    voltages: Floats,
    interval: float,
    threads: int | None = None,
    imposed: tuple[Actions, Floats, Floats] = FREE,
) -> list[Trajectory]:
    """
    Continue the run of each plant as ``Plant.run`` or ``Plant.run_imposed`` does, bit for bit.

    Plants with the same effects run in one compiled parallel loop. Every array is for all plants,
    or has a further first axis, of length n, for each of them.

    :param plants: n plants, all different
    :param voltages: u1, u2 [V], shape (m, 2) or (n, m, 2)
    :param interval: [s]
    :param threads: at most; None for Numba's own number
    :param imposed: actions, measured states and rests of ``Plant.run_imposed``
    :raises RigError: if a simulation fails
    """
    groups: dict[tuple[object, ...], list[_Ready]] = {}
    for number, plant in enumerate(plants):
        one = plant.run_state
        ready = _Ready(number, plant, one, pack_parameters((one.model, one.effects)))
        groups.setdefault(ready.kind, []).append(ready)
    inputs = [
        array if array.ndim > dimensions else array[np.newaxis]
        for array, dimensions in zip(
            (np.clip(voltages, 0.0, FULL_VOLTAGE), *imposed), (2, 1, 2, 1), strict=True
        )
    ]
    done: dict[int, Trajectory] = {}
    for group in groups.values():
        numbers = [ready.number for ready in group]
        own = [array[numbers] if len(array) > 1 else array for array in inputs]
        done |= dict(zip(numbers, _run(group, own, interval, threads), strict=True))
    return [done[number] for number in range(len(plants))]


def _run(
    group: list[_Ready],
    inputs: list[NDArray[Any]],
    interval: float,
    threads: int | None,
) -> list[Trajectory]:
    """Run plants of one kind; each input is one for all, or one a plant."""
    first, count = group[0].run_state, inputs[0].shape[1]
    loop = loop_over(first.run.__module__, group[0].packed)
    carries = [ready.run_state.carry for ready in group]
    stacked = [np.stack(parts) for parts in zip(*carries, strict=True)]
    rows = np.array([ready.packed.numbers for ready in group])
    arrays = tuple(np.stack(each) for each in zip(*(r.packed.arrays for r in group), strict=True))
    states = np.empty((len(group), count, group[0].plant.state_size))
    extras = np.empty((len(group), count, len(EXTRA_NAMES)))
    with _LOCK, _numba_threads(threads):
        loop(
            rows,
            arrays,
            *stacked,
            interval,
            first.intervals,
            *inputs,
            states,
            extras,
            first.tolerance,
            first.longest_step,
        )
    for number, carry in enumerate(carries):
        for part, whole in zip(carry, stacked, strict=True):
            part[...] = whole[number]
    return [
        ready.plant.advanced(states[number], extras[number], interval)
        for number, ready in enumerate(group)
    ]


@contextmanager
def _numba_threads(threads: int | None) -> Iterator[None]:
    """Limit the threads of parallel loops; each takes one plant after the other."""
    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
    before, size = numba.get_num_threads(), numba.get_parallel_chunksize()
    numba.set_num_threads(min(threads or before, most))
    numba.set_parallel_chunksize(1)
    try:
        yield
    finally:
        numba.set_num_threads(before)
        numba.set_parallel_chunksize(size)
