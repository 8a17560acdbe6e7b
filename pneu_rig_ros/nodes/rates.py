"""Counts events and tells how many came a second since it was last asked."""

import time


class Rate:
    """
    An event counter. Increase `count`, ask `per_second`.

    `count` is the number of events since the start.
    """

    def __init__(self) -> None:
        self.count = 0
        self._last_count = 0
        self._last_ns = time.monotonic_ns()

    def per_second(self) -> float:
        """Return the mean rate since the last call [Hz]."""
        now = time.monotonic_ns()
        elapsed = (now - self._last_ns) * 1e-9
        rate = (self.count - self._last_count) / elapsed if elapsed > 0 else 0.0
        self._last_ns, self._last_count = now, self.count
        return rate
