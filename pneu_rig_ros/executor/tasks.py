"""
Independent tasks on one processor, on many, or on many machines: one interface, on Dask.

A task is a function that can be imported and one argument; it has to depend on nothing else. Its
result is then the same wherever it is run, whatever the number of workers, and when it has to be
run once more because its worker was killed.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol, TypeVar

from pneu_rig_ros.errors import RigError

Task = TypeVar('Task')
Result = TypeVar('Result')
Progress = Callable[[int], None]
"""Told the number of tasks done."""


class Executor(Protocol):
    """Where tasks are run."""

    @property
    def workers(self) -> int:
        """How many tasks are run at a time."""

    def completed(
        self, function: Callable[..., Result], tasks: Iterable[Task], *shared: Any
    ) -> Iterator[tuple[int, Result]]:
        """
        Yield the number of each task and its result, in the order in which they are done.

        What is not yet begun is given up when the iterator is closed.

        :param function: of a task and of what they share; has to be found by its name
        :param shared: sent to each worker once
        :raises RigError: when the workers are lost
        """


def map_tasks(
    executor: Executor, function: Callable[..., Result], tasks: Iterable[Task], *shared: Any,
    progress: Progress = lambda _: None,
) -> list[Result]:  # fmt: skip
    """Return the results in the order of the tasks; see :class:`Executor`."""
    results: dict[int, Result] = {}
    for number, result in executor.completed(function, tasks, *shared):
        results[number] = result
        progress(len(results))
    return [results[number] for number in range(len(results))]


@contextlib.contextmanager
def executor(workers: int | None = 1, scheduler: str | None = None) -> Iterator[Executor]:
    """
    Have somewhere to run tasks; leaving it gives up what is not done and ends the processes.

    :param workers: processes on this machine; one is this process itself. None for one a
        processor, or for this process where Dask is not installed
    :param scheduler: address of a Dask scheduler, tcp://HOST:PORT, whose workers do it instead
    :raises RigError: when Dask is needed and not installed, there is no scheduler at the address,
        or it has no worker of the same version
    """
    with_dask = importlib.util.find_spec('distributed') is not None
    workers = workers or (with_dask and os.cpu_count()) or 1
    if not with_dask and (scheduler or workers > 1):
        raise RigError("more than one process needs Dask: pip install 'pneu_rig_ros[scale]'")
    if workers == 1 and scheduler is None:
        yield Here()
        return
    from pneu_rig_ros.executor.clusters import joined, local_processes
    from pneu_rig_ros.executor.distributed import Distributed

    with joined(scheduler) if scheduler else local_processes(workers) as client:
        yield Distributed(client)


class Here:
    """Runs tasks one after the other in this process."""

    workers = 1

    def completed(
        self, function: Callable[..., Result], tasks: Iterable[Task], *shared: Any
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number and the result of each task."""
        for number, task in enumerate(tasks):
            yield number, function(task, *shared)
