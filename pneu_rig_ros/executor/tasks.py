"""
Independent tasks: the interface of executors, and the executor of this process.

A task is a function that can be imported and one argument, and depends on nothing else. Its result
is then the same wherever it runs, whatever the number of workers, and when it has to be repeated
because its worker died.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from typing import Any, Protocol, TypeVar

from pneu_rig_ros.errors import RigError

Task = TypeVar('Task')
Result = TypeVar('Result')
POLL_INTERVAL = 1.0
"""Of the number of workers, while no task completes [s]."""
MOST_ATTEMPTS = 4
"""A task whose worker has died so many times fails; as many as Dask allows."""


class Executor(Protocol):
    """Runs tasks."""

    @property
    def workers(self) -> int:
        """Number of tasks that run at a time; at least 1."""

    def share(self, arguments: tuple[Any, ...]) -> Any:
        """Return the arguments that tasks have in common as :meth:`submit` takes them."""

    def submit(self, function: Callable[..., Result], task: Any, shared: Any) -> Future[Result]:
        """
        Start a task; its future raises BrokenExecutor where its worker died.

        :param function: called with the task and the shared arguments; importable by name
        """


class SerialExecutor:
    """Runs tasks in this process."""

    workers = 1

    def share(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return the arguments."""
        return arguments

    def submit(
        self, function: Callable[..., Result], task: Any, shared: tuple[Any, ...]
    ) -> Future[Result]:
        """Run a task at once."""
        future: Future[Result] = Future()
        future.set_result(function(task, *shared))
        return future


def completed(
    executor: Executor, function: Callable[..., Result], tasks: Iterable[Task], *arguments: Any
) -> Iterator[tuple[int, Result]]:
    """
    Yield index and result of each task, as they complete.

    :param function: called with a task and the further arguments; importable by name
    :raises RigError: if workers die again and again
    """
    waiting: Iterator[tuple[int, Task]] = enumerate(tasks)
    running: dict[Future[Result], tuple[int, Task]] = {}
    attempts: Counter[int] = Counter()
    shared = executor.share(arguments)
    while True:
        # no more tasks than workers, as a worker that dies may cost all that are submitted
        for index, task in itertools.islice(waiting, max(executor.workers - len(running), 0)):
            attempts[index] += 1
            running[executor.submit(function, task, shared)] = index, task
        if not running:
            return
        for future in wait(running, POLL_INTERVAL, FIRST_COMPLETED).done:
            index, task = running.pop(future)
            try:
                result = future.result()
            except BrokenExecutor:
                if attempts[index] == MOST_ATTEMPTS:
                    raise RigError(
                        f'the worker of task {index} died {MOST_ATTEMPTS} times in succession; '
                        f'is there enough memory?'
                    ) from None
                waiting = itertools.chain([(index, task)], waiting)
            else:
                yield index, result


def map_tasks(
    executor: Executor,
    function: Callable[..., Result],
    tasks: Iterable[Task],
    *arguments: Any,
    progress: Callable[[int], None] = lambda _: None,
) -> list[Result]:
    """
    Return the results in the order of the tasks; see :func:`completed`.

    :param progress: called with the number of completed tasks
    """
    results: dict[int, Result] = {}
    for index, result in completed(executor, function, tasks, *arguments):
        results[index] = result
        progress(len(results))
    return [results[index] for index in range(len(results))]
