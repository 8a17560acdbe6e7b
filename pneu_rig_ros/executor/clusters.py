"""Where Dask's workers are: processes on this machine, or a cluster that is joined."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import os
import platform
import signal
import tempfile
from collections.abc import Iterator
from importlib import metadata
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

import dask.config
from distributed import Client, LocalCluster
from distributed.comm.core import connect

from pneu_rig_ros.errors import RigError

PATIENCE = 5.0
"""Time to reach a scheduler and for it to have a worker [s]."""
LOCAL = '127.0.0.1'
NO_PAGES: dict[str, Any] = {
    'distributed.scheduler.http.routes': [],
    'distributed.worker.http.routes': [],
}
"""Dask's servers of pages have none for anyone on this machine."""
KEPT: dict[str, Any] = {'distributed.deploy.lost-worker-timeout': '1 hour'}
"""A worker that is killed comes back, however long a busy machine takes."""
PAGES_KEPT: dict[str, Any] = {
    f'distributed.nanny.pre-spawn-environ.MALLOC_{name}': value
    for name, value in {
        'TRIM_THRESHOLD_': 2**30,
        'MMAP_THRESHOLD_': 2**30,
        'ARENA_MAX': 1,
    }.items()
}
"""
A worker uses its memory again: by default it goes back to the kernel after every simulation, and
the workers wait for each other's pages.
"""
SAME_PACKAGES = ('numpy', 'scipy', 'numba')
"""What has to be of one version on all machines, as results depend on it."""


@contextlib.contextmanager
def joined(address: str) -> Iterator[Client]:
    """Have a client of a scheduler that has workers of the same version."""
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
    for source in sorted(Path(__file__).parents[1].rglob('*.py')):
        digest.update(source.read_bytes())
    versions = {name: metadata.version(name) for name in SAME_PACKAGES}
    return {
        'pneu_rig_ros': digest.hexdigest()[:12],
        'Python': platform.python_version(),
    } | versions


async def _reach(address: str) -> None:
    """Shake hands with a scheduler; OSError if there is none, ValueError for no address."""
    await (await asyncio.wait_for(connect(address, timeout=PATIENCE), PATIENCE)).close()


@contextlib.contextmanager
def local_processes(workers: int) -> Iterator[Client]:
    """Have a client of processes on this machine."""
    _be_quiet()
    with tempfile.TemporaryDirectory(prefix='pneu-rig-') as folder:
        settings = dask.config.set(NO_PAGES | KEPT | PAGES_KEPT | {'temporary-directory': folder})
        with (
            settings,
            _started(workers) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            try:
                yield client
            except BaseException:
                _kill(cluster)
                raise


def _started(workers: int) -> LocalCluster:
    """Start processes that take no interrupt, and share the processors between them."""
    threads = max(1, (os.cpu_count() or 1) // workers)
    with _interrupts_kept_from_children():
        return LocalCluster(
            workers, threads_per_worker=1, processes=True, host=LOCAL,
            dashboard_address=f'{LOCAL}:0', scheduler_kwargs={'dashboard': False},
            silence_logs=logging.CRITICAL, env={'NUMBA_NUM_THREADS': str(threads)},
        )  # fmt: skip


@contextlib.contextmanager
def _interrupts_kept_from_children() -> Iterator[None]:
    """
    Block SIGINT meanwhile; one that comes is taken up afterwards.

    Threads begun here, and the processes that they begin, keep it blocked: Ctrl-C in a terminal
    is for all of its processes, and the workers are ended by this one. The tracker of
    `multiprocessing` would let it through again for the thread that starts it.
    """
    resource_tracker.ensure_running()
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
