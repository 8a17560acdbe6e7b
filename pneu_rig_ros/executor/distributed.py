"""Tasks on the workers of a Dask client, whatever cluster that is."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any

from distributed import Client, KilledWorker
from distributed.client import Future
from distributed.comm.core import CommClosedError

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor.tasks import Result, Task

LOOK = 1.0
"""Time between looks at the connection, and at how many workers there are [s]."""
LOST = 120.0
"""Time without any worker after which none is waited for [s]; a busy machine takes a while."""


class Distributed:
    """
    Runs tasks on the workers of a Dask client.

    A worker keeps its results until they are fetched, and they are lost with it. So there are
    never more tasks under way than workers: the next is begun when a result has been fetched, and
    a worker that is killed costs its task, and a result at most that was about to be fetched.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._looked, self._threads = -LOOK, 1

    @property
    def workers(self) -> int:
        """Threads of all workers, which may come and go; 1 at least."""
        now = time.monotonic()
        if now - self._looked >= LOOK:
            self._looked, self._threads = now, sum(self._client.nthreads().values())
        return max(self._threads, 1)

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

        begin(self.workers)
        try:
            while under_way:
                future = self._next(done)
                yield under_way.pop(future), future.result()
                begin(max(self.workers - len(under_way), 0))
        finally:
            self._client.cancel(list(under_way), force=True)

    def _next(self, done: SimpleQueue[Future[Any]]) -> Future[Any]:
        """Wait for a task that is done, as long as there is a scheduler, and a worker or soon."""
        seen = time.monotonic()
        while True:
            with contextlib.suppress(Empty):
                return done.get(timeout=LOOK)
            if self._client.status == 'closed' or time.monotonic() - seen > LOST:
                raise CancelledError
            if self._client.nthreads():
                seen = time.monotonic()

    @contextlib.contextmanager
    def _complaints(self) -> Iterator[None]:
        """Say in a line what Dask complains about."""
        try:
            yield
        except KilledWorker as error:
            raise RigError(
                f'a task ended the {error.allowed_failures + 1} processes that it was given to, '
                f'one after the other; is there enough memory?'
            ) from None
        except (CommClosedError, CancelledError):
            raise RigError('the workers, or the connection to their scheduler, are lost') from None
