"""
Independent tasks in this process, in local processes or on a Dask cluster.

A task is a function that can be imported and one argument, and depends on nothing else. Its result
is then the same wherever it runs, whatever the number of workers, and when it has to be repeated
because its worker died.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import itertools
import multiprocessing
import os
import pickle
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import resource_tracker
from typing import Any, Protocol, TypeVar

from pneu_rig_ros.errors import RigError

Task = TypeVar('Task')
Result = TypeVar('Result')
POLL_INTERVAL = 1.0
"""Of the number of workers, while no task completes [s]."""
MOST_ATTEMPTS = 4
"""A task whose worker has died so many times fails; as many as Dask allows."""


@functools.cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1, 'run')


def map_threads(function: Callable[..., Result], *arguments: Iterable[Any]) -> list[Result]:
    """
    Return the results of a function, in order, whatever the number of threads.

    Compiled code releases the interpreter lock. The function may not call this one: all threads
    could wait for each other.

    :param arguments: of each call, one iterable a parameter
    """
    return list(_threads().map(function, *(list(values) for values in arguments)))


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


class ProcessExecutor:
    """Runs tasks in processes of this machine, which end with the ``with`` block."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._other_children = set(multiprocessing.active_children())
        self._pool = self._new_pool()

    def __enter__(self) -> ProcessExecutor:
        return self

    def __exit__(self, *_: object) -> None:
        for process in set(multiprocessing.active_children()) - self._other_children:
            process.kill()  # shutdown() would wait for the tasks that are running
        self._pool.shutdown()

    def share(self, arguments: tuple[Any, ...]) -> bytes:
        """Pickle arguments, once for all tasks."""
        return pickle.dumps(arguments)

    def submit(self, function: Callable[..., Result], task: Any, shared: bytes) -> Future[Result]:
        """Start a task; after the death of a worker in new processes."""
        # Ctrl-C in a terminal reaches workers too, but only this process is to react, and end
        # them. They inherit the blocked signal, which the resource tracker unblocks if started.
        resource_tracker.ensure_running()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return self._pool.submit(_run, function, task, shared)
        except BrokenProcessPool:
            self._pool.shutdown()
            self._pool = self._new_pool()
            return self._pool.submit(_run, function, task, shared)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)

    def _new_pool(self) -> ProcessPoolExecutor:
        threads = max(1, (os.cpu_count() or 1) // self.workers)
        # spawned, as forked processes inherit locks that threads of this process hold
        context = multiprocessing.get_context('spawn')
        return ProcessPoolExecutor(self.workers, context, _start_worker, (threads,))


def _start_worker(threads: int) -> None:
    """Give a worker its share of the processors, and let it end when its parent dies."""
    os.environ['NUMBA_NUM_THREADS'] = str(threads)  # read when a task imports Numba
    threading.Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _run(function: Callable[..., Result], task: Any, shared: bytes) -> Result:
    return function(task, *_unpickle(shared))


@functools.lru_cache(maxsize=1)
def _unpickle(shared: bytes) -> tuple[Any, ...]:
    """Return what tasks share, unpickled once per worker rather than once per task."""
    arguments: tuple[Any, ...] = pickle.loads(shared)
    return arguments


@contextlib.contextmanager
def open_executor(workers: int | None = 1, scheduler: str | None = None) -> Iterator[Executor]:
    """
    Provide an executor; on exit its processes end, and tasks that are not done are dropped.

    :param workers: local processes; 1 for this process, None for one per processor
    :param scheduler: address of a Dask scheduler, tcp://HOST:PORT, instead of local processes
    :raises RigError: if the scheduler cannot be used
    """
    workers = workers or os.cpu_count() or 1
    if scheduler is not None:
        if importlib.util.find_spec('distributed') is None:
            raise RigError("--scheduler needs Dask: pip install 'pneu_rig_ros[scale]'")
        from pneu_rig_ros.executor.cluster import connect

        with connect(scheduler) as cluster:
            yield cluster
    elif workers == 1:
        yield SerialExecutor()
    else:
        with ProcessExecutor(workers) as processes:
            yield processes
