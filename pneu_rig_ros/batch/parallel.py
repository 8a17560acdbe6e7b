"""Simulation of many plants in parallel, with the same numbers as one after the other."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.assembly import kept_module
from pneu_rig_ros.model.integrator import EXTRA_NAMES
from pneu_rig_ros.model.plant import FREE, Plant, Trajectory
from pneu_rig_ros.model.run import RunState
from pneu_rig_ros.model.valve import FULL_VOLTAGE


@dataclass
class PackedParameters:
    """
    Nested tuples packed into numbers and arrays.

    :param numbers: floats and integers in their order; integers are exact as floats
    :param arrays: arrays in their order
    :param classes: module and name of each named tuple
    :param code: expression for the tuples of plant i, from ``row`` and ``arrays[j][i]``
    """

    numbers: list[float] = field(default_factory=list)
    arrays: list[Floats] = field(default_factory=list)
    classes: set[tuple[str, str]] = field(default_factory=set)
    code: str = ''

    @property
    def kind(self) -> tuple[object, ...]:
        """Equal for parameters that one loop can unpack."""
        return self.code, tuple(array.shape for array in self.arrays)


def pack_parameters(value: Any) -> PackedParameters:
    """
    Pack nested tuples of floats, integers and arrays.

    :raises TypeError: for anything else
    """
    packed = PackedParameters()
    packed.code = _expression(value, packed)
    return packed


def _expression(value: Any, packed: PackedParameters) -> str:
    if isinstance(value, tuple):
        items = ''.join(f'{_expression(item, packed)}, ' for item in value)
        return f'{_name(value, packed)}({items})'
    if isinstance(value, np.ndarray):
        packed.arrays.append(value)
        return f'arrays[{len(packed.arrays) - 1}][i]'
    if not isinstance(value, float | int):
        raise TypeError(f'{value!r} is not a number')
    packed.numbers.append(float(value))
    place = f'row[{len(packed.numbers) - 1}]'
    return place if isinstance(value, float) else f'int({place})'


def _name(value: tuple[Any, ...], packed: PackedParameters) -> str:
    """Return the name of a tuple's class in the code; parameters of effects share their name."""
    if type(value) is tuple:
        return ''
    module, name = type(value).__module__, type(value).__name__
    packed.classes.add((module, name))
    return alias(module, name)


def alias(module: str, name: str) -> str:
    """Return the name under which the code imports a class."""
    return f'{module.rsplit(".", 1)[-1]}_{name}'


Loop = Callable[..., None]

_TEMPLATE = '''"""Loop over compiled plants; made by pneu_rig_ros, may be deleted."""

from numba import njit, prange

from pneu_rig_ros.model.integrator import IntegratorState
from {plant} import run
{imports}


@njit(cache=True, parallel=True, error_model='numpy', nogil=True)
def loop(
    rows, arrays, clock, counts, y0, f0, y1, f1, arrow, memory, held, scale, work, work_arrow,
    interval, first, voltages, actions, measured, rests, states, extras, tolerance, longest,
):
    for i in prange(len(rows)):
        row = rows[i]
        model, effects = {code}
        carry = IntegratorState(
            clock[i], counts[i], y0[i], f0[i], y1[i], f1[i], arrow[i], memory[i], held[i],
            scale[i], work[i], work_arrow[i],
        )
        run(
            carry, interval, first, voltages[i % len(voltages)], actions[i % len(actions)],
            measured[i % len(measured)], rests[i % len(rests)], states[i], extras[i], tolerance,
            longest, model, effects,
        )
'''


def loop_over(plant: str, packed: PackedParameters) -> Loop:
    """Return the compiled loop over plants of a module, whose parameters are packed alike."""
    imports = ''.join(
        f'from {module} import {name} as {alias(module, name)}\n'
        for module, name in sorted(packed.classes)
    )
    return _loop(plant, _TEMPLATE.format(plant=plant, imports=imports, code=packed.code))


@cache
def _loop(plant: str, text: str) -> Loop:
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    loop: Loop = kept_module(f'loop_{digest}', text).loop
    return loop


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
    plants: Sequence[Plant], voltages: Floats, interval: float, threads: int | None = None
) -> list[Trajectory]:
    """
    Continue the run of each plant as ``Plant.run`` does, bit for bit.

    Plants with the same effects run in one compiled parallel loop.

    :param plants: n plants, all different
    :param voltages: u1, u2 [V] for all, shape (m, 2), or of each, shape (n, m, 2)
    :param interval: [s]
    :param threads: at most; None for Numba's own number
    :raises RigError: if a simulation fails
    """
    groups: dict[tuple[object, ...], list[_Ready]] = {}
    for number, plant in enumerate(plants):
        one = plant.run_state
        ready = _Ready(number, plant, one, pack_parameters((one.model, one.effects)))
        groups.setdefault(ready.kind, []).append(ready)
    held = np.clip(voltages, 0.0, FULL_VOLTAGE)
    held = held if held.ndim > 2 else held[np.newaxis]
    done: dict[int, Trajectory] = {}
    for group in groups.values():
        numbers = [ready.number for ready in group]
        own = held[numbers] if len(held) > 1 else held
        done |= dict(zip(numbers, _run(group, own, interval, threads), strict=True))
    return [done[number] for number in range(len(plants))]


def _run(
    group: list[_Ready], voltages: Floats, interval: float, threads: int | None
) -> list[Trajectory]:
    """Run plants of one kind; the voltages are for all, or of each plant."""
    first, count = group[0].run_state, voltages.shape[1]
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
            voltages,
            *(nothing[np.newaxis] for nothing in FREE),
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
