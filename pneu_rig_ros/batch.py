"""Many plants at once, on all processors, with results bit-identical to single runs."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.model.plant import Plant, Trajectory

BLOCK = 5.0
"""Simulated between two checks for strokes that have ended [s]."""
END_SHARE = 0.98
"""A stroke counts as done at this share of the way to the end stop [-]."""


def run_parallel(
    plants: Sequence[Plant], voltages: Floats, interval: float, threads: int | None = None
) -> list[Trajectory]:
    """
    Continue the run of each plant, in threads: the compiled run releases the GIL.

    :param plants: n plants, all different
    :param voltages: u1, u2 [V] for all, shape (m, 2), or of each, shape (n, m, 2)
    :param interval: [s]
    :param threads: at most; None for Numba's own number
    :raises RigError: if a simulation fails
    """
    each = voltages if voltages.ndim > 2 else [voltages] * len(plants)
    with ThreadPoolExecutor(threads or numba.get_num_threads()) as pool:
        return list(pool.map(lambda plant, held: plant.run(held, interval), plants, each))


def strokes(
    plants: Sequence[Plant],
    voltages: Floats,
    interval: float,
    longest: float,
    threads: int | None = None,
) -> list[Trajectory]:
    """
    Run each plant until its piston is at the end that it moves to.

    :param plants: at rest
    :param voltages: u1, u2 [V] of each, shape (n, 2); the piston extends where u1 is above u2
    :param interval: [s]
    :param longest: given up after this time [s]
    :param threads: at most; None for Numba's own number
    :returns: up to the first sample at the end, or to the longest time
    """
    runs: list[list[Trajectory]] = [[] for _ in plants]
    left, count = list(range(len(plants))), round(longest / interval)
    block = round(BLOCK / interval)
    for begin in range(0, count, block):
        samples = min(block, count - begin)
        held = np.repeat(voltages[left, None], samples, axis=1)
        done = run_parallel([plants[i] for i in left], held, interval, threads)
        for number, run in zip(left, done, strict=True):
            runs[number].append(run)
        left = [i for i in left if not at_end(plants[i], voltages[i], runs[i][-1]).any()]
    return [_to_end(*each) for each in zip(plants, voltages, runs, strict=True)]


def at_end(plant: Plant, voltages: Floats, run: Trajectory) -> Flags:
    """Return at which samples the piston is at the end that it moves to, shape (m,)."""
    share = run.position / plant.model.cylinder.stroke
    return np.asarray((share if voltages[0] >= voltages[1] else 1.0 - share) >= END_SHARE)


def _to_end(plant: Plant, voltages: Floats, parts: list[Trajectory]) -> Trajectory:
    """Return the parts of a run put together, up to the end."""
    run = Trajectory(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    done = at_end(plant, voltages, run)
    last = int(np.argmax(done)) + 1 if done.any() else len(done)
    return Trajectory(*(column[:last] for column in run))  # type: ignore[arg-type]
