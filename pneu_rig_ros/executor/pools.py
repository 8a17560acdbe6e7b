"""Tasks in processes of this machine."""

from __future__ import annotations

import functools
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import resource_tracker
from typing import Any

from pneu_rig_ros.executor.tasks import Result


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
