"""The last rows of a stream of values, kept for whoever asks."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import islice
from threading import Lock

Row = Sequence[float | None]


class History:
    """
    Keeps the last rows; one thread adds, others ask.

    :param names: of the columns
    :param length: rows kept
    """

    def __init__(self, names: Sequence[str], length: int) -> None:
        self._names = tuple(names)
        self._rows: deque[Row] = deque(maxlen=length)
        self._count = 0
        self._lock = Lock()

    def extend(self, rows: Iterable[Row]) -> None:
        """Add rows, each with a value a column."""
        new = list(rows)
        with self._lock:
            self._rows.extend(new)
            self._count += len(new)

    def since(self, number: int) -> tuple[int, dict[str, list[float | None]]]:
        """Return how many rows there have been, and those kept after the first `number`."""
        with self._lock:
            fresh = min(max(self._count - number, 0), len(self._rows))
            rows = list(islice(reversed(self._rows), fresh))[::-1]
            count = self._count
        return count, {name: [row[k] for row in rows] for k, name in enumerate(self._names)}
