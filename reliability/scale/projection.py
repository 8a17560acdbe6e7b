"""From what one trial costs on one machine to many trials on many cores."""

from __future__ import annotations

from typing import NamedTuple


class Cost(NamedTuple):
    """
    What trials cost, measured.

    :param task: time of a trial on a core, mean [s]
    :param longest: of all trials [s]
    :param latency: of a worker from the end of a task to the start of the next [s]
    :param overhead: processor time of the one scheduler and its client for each task [s]
    :param transfer: of a task and its result, at the same place [s]
    :param start: of a worker, to its first result [s]
    :param compilation: of the plants, once for each machine [s]
    """

    task: float
    longest: float
    latency: float
    overhead: float
    transfer: float
    start: float
    compilation: float


def wall_time(cost: Cost, trials: int, cores: int) -> float:
    """
    Return how long trials take on so many cores [s].

    Workers and scheduler work at the same time, and the slower of the two decides; before it
    workers start, and at the end all wait for the last trial::

        T = start + compilation + max(N (t + l) / P, N (o + d)) + (longest - t)
    """
    by_workers = trials * (cost.task + cost.latency) / cores
    by_scheduler = trials * (cost.overhead + cost.transfer)
    last = max(cost.longest - cost.task, 0.0)
    return cost.start + cost.compilation + max(by_workers, by_scheduler) + last


def efficiency(cost: Cost, trials: int, cores: int) -> float:
    """Return the share of the time of all cores that goes into trials [-]."""
    return trials * cost.task / (cores * wall_time(cost, trials, cores))


def most_cores(cost: Cost) -> float:
    """Return from how many cores on the scheduler decides."""
    return (cost.task + cost.latency) / (cost.overhead + cost.transfer)
