"""
Independent tasks on one processor, on many, or on many machines: one interface, on Dask.

A task is a function that can be imported and one argument; it has to depend on nothing else. Its
result is then the same wherever it is run, whatever the number of workers, and when it has to be
run once more because its worker was killed.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import importlib.util
import logging
import os
import platform
import signal
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from importlib import metadata
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from distributed import Client, LocalCluster
    from distributed.client import Future

Task = TypeVar('Task')
Result = TypeVar('Result')
Progress = Callable[[int], None]
"""Told the number of tasks done."""

SHARE = 4
"""Tasks under way for each thread of the workers, so that none waits for the next."""
LEAST_WINDOW = 64
"""Tasks under way at least: workers may join a cluster later."""
LOOK = 1.0
"""Time between looks at the connection while no task is done [s]."""
PATIENCE = 5.0
"""Time to reach a scheduler and for it to have a worker [s]."""
SAME_PACKAGES = ('numpy', 'scipy', 'numba')
"""What has to be of one version on all machines, as results depend on it."""


class Executor(Protocol):
    """Where tasks are run."""

    workers: int

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
    if scheduler is not None:
        with _joined(scheduler) as client:
            yield _Distributed(client)
    elif workers == 1:
        yield Here()
    else:
        with _local_processes(workers) as client:
            yield _Distributed(client)


class Here:
    """Runs tasks one after the other in this process."""

    workers = 1

    def completed(
        self, function: Callable[..., Result], tasks: Iterable[Task], *shared: Any
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number and the result of each task."""
        for number, task in enumerate(tasks):
            yield number, function(task, *shared)


class _Distributed:
    """Runs tasks on the workers of a Dask client."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self.workers = sum(client.nthreads().values())

    def completed(
        self, function: Callable[..., Result], tasks: Iterable[Task], *shared: Any
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number and the result of each task."""
        with self._complaints():
            yield from self._run(function, enumerate(tasks), self._everywhere(shared))

    def _everywhere(self, shared: Sequence[Any]) -> list[Future[Any]]:
        if not shared:
            return []
        sent: list[Future[Any]] = self._client.scatter(list(shared), broadcast=True, hash=False)
        return sent

    def _run(
        self, function: Callable[..., Any], tasks: Iterator[tuple[int, Any]],
        shared: list[Future[Any]],
    ) -> Iterator[tuple[int, Any]]:  # fmt: skip
        under_way: dict[Future[Any], int] = {}
        done: SimpleQueue[Future[Any]] = SimpleQueue()

        def begin(count: int) -> None:
            for number, task in islice(tasks, count):
                future = self._client.submit(function, task, *shared, pure=False)
                under_way[future] = number
                future.add_done_callback(done.put)

        begin(max(LEAST_WINDOW, SHARE * self.workers))
        try:
            while under_way:
                future = self._next(done)
                yield under_way.pop(future), future.result()
                begin(1)
        finally:
            self._client.cancel(list(under_way), force=True)

    def _next(self, done: SimpleQueue[Future[Any]]) -> Future[Any]:
        """Wait for a task that is done, as long as there is a scheduler."""
        while True:
            with contextlib.suppress(Empty):
                return done.get(timeout=LOOK)
            if self._client.status == 'closed':
                raise CancelledError

    @contextlib.contextmanager
    def _complaints(self) -> Iterator[None]:
        """Say in a line what Dask complains about."""
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        try:
            yield
        except KilledWorker as error:
            raise RigError(
                f'a task ended the {error.allowed_failures + 1} processes that it was given to, '
                f'one after the other; is there enough memory?'
            ) from None
        except (CommClosedError, CancelledError):
            raise RigError('the workers, or the connection to their scheduler, are lost') from None


@contextlib.contextmanager
def _joined(address: str) -> Iterator[Client]:
    """Have a client of a scheduler that has workers of the same version."""
    from distributed import Client

    _be_quiet()
    try:
        asyncio.run(_reach(address))
    except (OSError, ValueError, asyncio.TimeoutError):
        raise RigError(
            f'--scheduler {address}: no Dask scheduler answers there; '
            f'expected tcp://HOST:PORT as dask scheduler prints it'
        ) from None
    with Client(address, timeout=PATIENCE, set_as_default=False) as client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise RigError(f'--scheduler {address}: it has no workers') from None
        _compare(client, address)
        yield client


def _compare(client: Client, address: str) -> None:
    """Raise RigError unless the scheduler and all workers have the programs of this process."""
    places = client.run(surroundings, on_error='return')
    try:
        places['the scheduler'] = client.run_on_scheduler(surroundings)
    except ImportError as error:
        places['the scheduler'] = error
    own = surroundings()
    for place, found in places.items():
        if isinstance(found, Exception):
            raise RigError(f'--scheduler {address}: {place} lacks pneu_rig_ros: {found}')
        for name, version in own.items():
            if found.get(name) != version:
                there = f'{name} is {found.get(name)} at {place}'
                raise RigError(f'--scheduler {address}: {there}, here {version}')


def surroundings() -> dict[str, str]:
    """Return what results depend on besides their tasks: name -> version, or hash of sources."""
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.rglob('*.py')):
        digest.update(source.read_bytes())
    versions = {name: metadata.version(name) for name in SAME_PACKAGES}
    return {
        'pneu_rig_ros': digest.hexdigest()[:12],
        'Python': platform.python_version(),
    } | versions


async def _reach(address: str) -> None:
    """Shake hands with a scheduler; OSError if there is none, ValueError for no address."""
    from distributed.comm.core import connect

    await (await asyncio.wait_for(connect(address, timeout=PATIENCE), PATIENCE)).close()


@contextlib.contextmanager
def _local_processes(workers: int) -> Iterator[Client]:
    """Have a client of processes on this machine."""
    from distributed import Client, LocalCluster

    _be_quiet()
    threads = max(1, (os.cpu_count() or 1) // workers)
    with tempfile.TemporaryDirectory(prefix='pneu-rig-') as folder:
        with _interrupts_kept_from_children():
            cluster = LocalCluster(
                workers, threads_per_worker=1, processes=True, dashboard_address=None,
                host='127.0.0.1', silence_logs=logging.CRITICAL, local_directory=folder,
                env={'NUMBA_NUM_THREADS': str(threads)},
            )  # fmt: skip
        with cluster, Client(cluster, set_as_default=False) as client:
            try:
                yield client
            except BaseException:
                _kill(cluster)
                raise


@contextlib.contextmanager
def _interrupts_kept_from_children() -> Iterator[None]:
    """
    Block SIGINT meanwhile; one that comes is taken up afterwards.

    Threads begun here, and the processes that they begin, keep it blocked: Ctrl-C in a terminal
    is for all of its processes, and the workers are ended by this one.
    """
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def _kill(cluster: LocalCluster) -> None:
    """End the processes at once, whatever they are doing."""
    for nanny in cluster.workers.values():
        nanny.auto_restart = False
        if nanny.pid is not None:
            os.kill(nanny.pid, signal.SIGKILL)


def _be_quiet() -> None:
    """Keep what Dask logs about lost workers and connections from the terminal."""
    for name in list(logging.root.manager.loggerDict):
        if name.startswith(('distributed', 'tornado')):
            logging.getLogger(name).setLevel(logging.CRITICAL)
