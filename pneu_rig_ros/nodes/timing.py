"""Timers of the loop: absolute deadlines, or the arrival of a message; the wall clock."""

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Protocol

from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation

from pneu_rig_ros.nodes.topics import PolledSubscription

SMALLEST_STEP_NS = 5_000_000
"""A smaller step cannot be distinguished from an interruption between two clock readings [ns]."""

LONGEST_AGE_NS = 1_000_000_000
"""An older message may carry the stamp of a clock that was set since the last update [ns]."""


class LoopTimer(Protocol):
    """Blocks until the next cycle of the loop."""

    def wait(self) -> None:
        """Return when the next cycle is due, at the latest after some 20 ms."""


class TickErrors:
    """Lateness of the ticks: its histogram [us], and the exact maximum."""

    def __init__(self) -> None:
        self.count = 0
        self.late = 0
        self.max_ns = 0
        self._microseconds: Counter[int] = Counter()

    def add(self, error_ns: int, period_ns: int) -> None:
        """Count one tick that was `error_ns` after its deadline."""
        self.count += 1
        self.late += error_ns > period_ns
        self.max_ns = max(self.max_ns, error_ns)
        self._microseconds[max(error_ns, 0) // 1000] += 1

    def percentile_ms(self, percent: float) -> float:
        """Return the tick error [ms] that `percent` of the ticks did not exceed."""
        ticks = 0
        for microseconds, count in sorted(self._microseconds.items()):
            ticks += count
            if ticks >= self.count * percent / 100.0:
                return microseconds * 1e-3
        return 0.0


class PeriodicTimer:
    """
    Ticks at absolute deadlines on the monotonic clock.

    A late tick does not delay the following ones, and none is ever skipped: the next ticks follow
    without a pause until the deadlines are met again.
    """

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self.errors = TickErrors()
        self._deadline = 0

    def restart(self, now_ns: int) -> None:
        """Restart deadlines and tick errors at a reading of the monotonic clock [ns]."""
        self._deadline = now_ns
        self.errors = TickErrors()

    def wait(self) -> None:
        """Sleep until the next deadline; return immediately if it has passed."""
        self._deadline = (self._deadline or time.monotonic_ns()) + self.period_ns
        remaining = self._deadline - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)
        self.errors.add(time.monotonic_ns() - self._deadline, self.period_ns)


class MessageWaitSet:
    """
    Waits for a message on any of several subscriptions.

    :param awaited: returns the subscriptions; called at each cycle
    :param gap_ns: least time between two cycles [ns], so that many messages are taken together
    """

    _TIMEOUT_NS = 20_000_000

    def __init__(
        self,
        awaited: Callable[[], Iterable[PolledSubscription]],
        context: Context,
        gap_ns: int = 0,
    ) -> None:
        self._gap_ns = gap_ns
        self._cycle_ns = 0
        self._awaited = awaited
        self._context = context
        self._size = -1

    def wait(self) -> None:
        """Return when there is a message to take, or after 20 ms."""
        handles = [each.handle for one in self._awaited() for each in one.subscriptions]
        if not handles:  # which an empty set would refuse
            time.sleep(self._TIMEOUT_NS * 1e-9)
            return
        if len(handles) != self._size:
            self._size, context = len(handles), self._context.handle
            assert context is not None
            with context:
                self._set = rclpy_implementation.WaitSet(self._size, 0, 0, 0, 0, 0, context)
        self._set.clear_entities()
        for handle in handles:
            self._set.add_subscription(handle)
        self._set.wait(self._TIMEOUT_NS)
        if self._gap_ns:
            early = self._cycle_ns + self._gap_ns - time.monotonic_ns()
            if early > 0:
                time.sleep(early * 1e-9)
            self._cycle_ns = time.monotonic_ns()


def claim_realtime_priority(priority: int) -> str | None:
    """Run this thread under SCHED_FIFO, 1 to 99, 0: do not; return why it is not permitted."""
    if priority <= 0:
        return None
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError) as error:
        return f'real-time priority {priority} is not permitted here ({error})'
    return None


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
