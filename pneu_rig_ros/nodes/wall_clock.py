"""The wall clock, and whether somebody has set it."""

import time

SMALLEST_JUMP_NS = 5_000_000
"""Less is not told from a process that was interrupted while it read its clocks [ns]."""

LONGEST_WAIT_NS = 1_000_000_000
"""What seems older may have been stamped by a clock that was set since the last look [ns]."""


class WallClock:
    """
    The wall clock as it went when this was made, however it is set afterwards.

    NTP bends it and the monotonic clock alike; what parts them is that somebody sets it, or that
    the computer slept.
    """

    def __init__(self) -> None:
        self._offset_ns = _offset_ns()
        self._before_ns = 0
        self.jump_ns = 0
        """By how much it has been set since then [ns]."""

    def look(self) -> None:
        """Notice whether it has been set since the last look."""
        self._before_ns = self.jump_ns
        jump_ns = _offset_ns() - self._offset_ns
        if abs(jump_ns - self.jump_ns) > SMALLEST_JUMP_NS:
            self.jump_ns = jump_ns

    def steady(self, wall_ns: int) -> int:
        """Return what it would have shown when it showed `wall_ns`, after the look before."""
        reading, now = wall_ns - self.jump_ns, time.monotonic_ns() + self._offset_ns
        if self._before_ns == self.jump_ns and abs(reading - now) < LONGEST_WAIT_NS:
            return reading
        # it may also have been set since the last look
        jumps = self._before_ns, self.jump_ns, _offset_ns() - self._offset_ns
        return min((wall_ns - jump for jump in jumps), key=lambda one: abs(one - now))

    def told(self, unmoved: str) -> str | None:
        """Return what to say of a clock that was set, None when it was not; and what goes on."""
        if not self.jump_ns:
            return None
        return f'wall clock set by {self.jump_ns * 1e-9:+.3f} s, {unmoved} go on without it'


def _offset_ns() -> int:
    """Return wall less monotonic time [ns], read where the two were read closest together."""
    return min(map(_reading, range(3)))[1]


def _reading(_: int) -> tuple[int, int]:
    before, wall, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
    return after - before, wall - (before + after) // 2
