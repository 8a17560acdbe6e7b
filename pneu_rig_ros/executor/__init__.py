"""Independent tasks in this process, in local processes or on a Dask cluster."""

import contextlib
import importlib.util
import os
from collections.abc import Iterator

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor.tasks import (
    Executor,
    ProcessExecutor,
    SerialExecutor,
    completed,
    map_tasks,
)

__all__ = ['Executor', 'SerialExecutor', 'completed', 'map_tasks', 'open_executor']


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
