"""Time: the wall clock and its steps, that of samples, simulated time of other messages."""

import time
from bisect import bisect_right

SMALLEST_STEP_NS = 5_000_000
"""A smaller step cannot be distinguished from an interruption between two clock readings [ns]."""

LONGEST_AGE_NS = 1_000_000_000
"""An older message may carry the stamp of a clock that was set since the last update [ns]."""


class WallClock:
    """
    The wall clock without the steps made since this object was created.

    NTP slews the wall clock and the monotonic clock alike; their difference changes only when
    the wall clock is set, or when the computer is suspended.
    """

    def __init__(self) -> None:
        self._offset_ns = _wall_minus_monotonic_ns()
        self._previous_step_ns = 0
        self.step_ns = 0
        """Sum of the steps [ns]."""

    def update(self) -> None:
        """Detect whether the clock has been set since the last update."""
        self._previous_step_ns = self.step_ns
        step_ns = _wall_minus_monotonic_ns() - self._offset_ns
        if abs(step_ns - self.step_ns) > SMALLEST_STEP_NS:
            self.step_ns = step_ns

    def without_steps(self, wall_ns: int) -> int:
        """Return a wall time read before the last update [ns] without the steps before it."""
        corrected, now = wall_ns - self.step_ns, time.monotonic_ns() + self._offset_ns
        if self._previous_step_ns == self.step_ns and abs(corrected - now) < LONGEST_AGE_NS:
            return corrected
        # Read before or after a step: of the possible corrections take the one closest to now,
        # including that of a step since the last update.
        newest_step_ns = _wall_minus_monotonic_ns() - self._offset_ns
        steps = self._previous_step_ns, self.step_ns, newest_step_ns
        return min((wall_ns - step for step in steps), key=lambda candidate: abs(candidate - now))

    def warning(self, unaffected: str) -> str | None:
        """Return a warning of a clock that was set, None if it was not."""
        if not self.step_ns:
            return None
        return f'wall clock set by {self.step_ns * 1e-9:+.3f} s, {unaffected} are not affected'


def _wall_minus_monotonic_ns() -> int:
    """Return wall less monotonic time [ns], from the readings taken closest together."""
    readings = []
    for _ in range(3):
        before, wall, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        readings.append((after - before, wall - (before + after) // 2))
    return min(readings)[1]


class SampleClock:
    """
    Time by the stamps of samples, which starts again where they jump back.

    So they do when a simulation is restarted or a bag is played again.
    """

    def __init__(self) -> None:
        self._start_ns: int | None = None
        self._last_ns = 0
        self.elapsed = 0.0
        """Time since the start [s]."""
        self.interval = 0.0
        """Time since the sample before, 0 at the start [s]."""

    @property
    def started(self) -> bool:
        """Whether there was a sample."""
        return self._start_ns is not None

    def update(self, stamp_ns: int) -> None:
        """Set the times to those of the next sample."""
        if self._start_ns is None or stamp_ns < self._last_ns:
            self._start_ns = self._last_ns = stamp_ns
        self.elapsed = (stamp_ns - self._start_ns) * 1e-9
        self.interval = (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns


class SimulatedTime:
    """
    Maps source times of messages to simulated time.

    The stamp of a sample holds from the moment when the sample was sent until the next one is
    sent. This depends on the order of cause and effect only, so that two runs in lock step agree,
    however late the messages were read.
    """

    def __init__(self) -> None:
        self._sent: list[int] = []
        self._stamps: list[int] = []

    def add_sample(self, sent_ns: int, stamp_ns: int) -> None:
        """Add the sample of `stamp_ns`, sent at `sent_ns` and after all samples added before."""
        self._sent.append(sent_ns)
        self._stamps.append(stamp_ns)

    def is_known(self, sent_ns: int) -> bool:
        """Return whether a later sample is known, so that the time asked for is final."""
        return bool(self._sent) and sent_ns <= self._sent[-1]

    def at(self, sent_ns: int) -> int:
        """Return the stamp of the newest sample sent before [ns]; 0 before the first one."""
        index = bisect_right(self._sent, sent_ns)
        return self._stamps[index - 1] if index else 0

    def discard_before(self, sent_ns: int) -> None:
        """Discard the samples that no message sent after `sent_ns` needs."""
        keep = max(bisect_right(self._sent, sent_ns) - 1, 0)
        del self._sent[:keep], self._stamps[:keep]
