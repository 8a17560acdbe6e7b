"""Tasks on the workers of a Dask cluster."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import platform
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from importlib import metadata
from pathlib import Path
from typing import Any, TypeVar

from distributed import Client, KilledWorker
from distributed.comm.core import CommClosedError
from distributed.comm.core import connect as open_connection

from pneu_rig_ros.errors import RigError

Result = TypeVar('Result')
CONNECT_TIMEOUT = 5.0
"""For the scheduler to answer and to have a worker [s]."""
POLL_INTERVAL = 1.0
"""Between two questions to the scheduler for the number of workers [s]."""
MOST_POLLS = 120
"""A cluster that has no worker in so many polls in succession is given up."""
PACKAGES = ('numpy', 'scipy', 'numba')
"""Results depend on their versions."""


@contextlib.contextmanager
def connect(address: str) -> Iterator[DaskExecutor]:
    """
    Connect to a Dask scheduler.

    :param address: tcp://HOST:PORT
    :raises RigError: if there is no scheduler, it has no worker, versions differ, or the
        connection or workers are lost
    """
    for name in list(logging.root.manager.loggerDict):
        if name.startswith(('distributed', 'tornado')):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        asyncio.run(_handshake(address))
        client = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, asyncio.TimeoutError):
        raise RigError(
            f'--scheduler {address}: no Dask scheduler answers there; '
            f'expected tcp://HOST:PORT as dask scheduler prints it'
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_TIMEOUT)
        except TimeoutError:
            raise RigError(f'--scheduler {address}: it has no workers') from None
        _check_versions(client, address)
        try:
            yield DaskExecutor(client)
        except KilledWorker as error:
            raise RigError(
                f'--scheduler {address}: a task ended {error.allowed_failures + 1} workers in '
                f'succession; is there enough memory?'
            ) from None
        except (CommClosedError, CancelledError):
            raise RigError(f'--scheduler {address}: workers or connection are lost') from None


async def _handshake(address: str) -> None:
    """Connect once with a timeout; that of Client has none where something else listens."""
    connection = await asyncio.wait_for(open_connection(address), CONNECT_TIMEOUT)
    await connection.close()


def _check_versions(client: Client, address: str) -> None:
    """Raise RigError unless scheduler and workers have the versions of this process."""
    found = client.run(versions, on_error='return')
    try:
        found['the scheduler'] = client.run_on_scheduler(versions)
    except ImportError as error:
        found['the scheduler'] = error
    own = versions()
    for place, theirs in found.items():
        if isinstance(theirs, Exception):
            raise RigError(f'--scheduler {address}: {place} lacks pneu_rig_ros: {theirs}')
        for name, version in own.items():
            if theirs.get(name) != version:
                there = f'{name} is {theirs.get(name)} at {place}'
                raise RigError(f'--scheduler {address}: {there}, here {version}')


def versions() -> dict[str, str]:
    """Return the versions that results depend on; of this package a hash of its sources."""
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parents[1].rglob('*.py')):
        digest.update(source.read_bytes())
    own = {'pneu_rig_ros': digest.hexdigest()[:12], 'Python': platform.python_version()}
    return own | {name: metadata.version(name) for name in PACKAGES}


class DaskExecutor:
    """Runs tasks on the workers of a Dask client; Dask repeats those whose worker died."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False)
        self._polled, self._threads, self._polls_without = -POLL_INTERVAL, 1, 0

    @property
    def workers(self) -> int:
        """Threads of all workers, which may come and go; CancelledError if none comes back."""
        if time.monotonic() - self._polled >= POLL_INTERVAL:
            self._threads = sum(self._client.nthreads().values())
            self._polls_without = 0 if self._threads else self._polls_without + 1
            self._polled = time.monotonic()
        if self._client.status == 'closed' or self._polls_without > MOST_POLLS:
            raise CancelledError
        return max(self._threads, 1)

    def share(self, arguments: tuple[Any, ...]) -> list[Any]:
        """Send arguments to each worker, once for all tasks."""
        # a list of its own for each, as scatter() spreads the items of a list
        return [self._client.scatter([each], broadcast=True, hash=False)[0] for each in arguments]

    def submit(
        self, function: Callable[..., Result], task: Any, shared: list[Any]
    ) -> Future[Result]:
        """Start a task."""
        future: Future[Result] = self._executor.submit(function, task, *shared)
        return future
