"""What a bag proves: every stamp of every topic, and as many messages as were published."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader

from pneu_rig_ros.records.cdr import typestore, unpack_stamp

STAMPED = ('/joint_states', '/chamber_1/pressure', '/chamber_2/pressure', '/friction')
PUBLISHED = {
    'plant': ('/joint_states', '/position', '/velocity', '/chamber_1/pressure',
              '/chamber_2/pressure'),
    'valve_command': ('/valve_voltages',),
    'friction_estimator': ('/friction',),
}  # fmt: skip
WINDOW_NS = 60_000_000_000
"""Over which the least delay of a message is looked for [ns]: it is free of jitter."""


@dataclass
class Content:
    """
    What was found in a bag.

    :param gaps: stamps that are missing, by topic
    :param published: messages of each topic by what its publisher reported at its end
    """

    counts: Counter[str] = field(default_factory=Counter)
    gaps: Counter[str] = field(default_factory=Counter)
    published: dict[str, int] = field(default_factory=dict)
    drift_ms: float = 0.0
    rate_hz: float = 0.0

    @property
    def samples(self) -> int:
        """Samples in the bag."""
        return self.counts['/joint_states']

    @property
    def messages(self) -> int:
        """Messages in the bag."""
        return sum(self.counts.values())

    @property
    def lost(self) -> dict[str, int]:
        """Messages that are missing, by topic: the larger of gaps and of what was published."""
        return {
            topic.lstrip('/'): max(count - self.counts[topic], self.gaps[topic])
            for topic, count in self.published.items()
        }


def read_content(bag: Path) -> Content:
    """Read every message of a complete bag."""
    content = Content()
    with Reader(bag) as reader:
        length = reader.duration
        window = min(WINDOW_NS, length // 3)
        ends = reader.start_time + window, reader.end_time - window
        delays = Delays(*ends)
        intervals = {topic: Steps() for topic in STAMPED}
        for connection, arrival, cdr in reader.messages():
            content.counts[connection.topic] += 1
            if connection.topic in intervals:
                stamp = unpack_stamp(bytes(cdr))
                intervals[connection.topic].add(stamp)
                if connection.topic == '/joint_states':
                    delays.add(arrival, stamp)
            elif connection.topic == '/diagnostics':
                message = typestore().deserialize_cdr(cdr, connection.msgtype)
                content.published |= dict(_published(message))
    content.gaps.update({topic: steps.missing for topic, steps in intervals.items()})
    content.drift_ms = delays.drift_ns * 1e-6
    content.rate_hz = delays.rate_hz
    return content


def _published(message: Any) -> Iterator[tuple[str, int]]:
    for status in message.status:
        values = {item.key: item.value for item in status.values}
        for topic in PUBLISHED.get(status.name.lstrip('/'), ()):
            yield topic, int(values['published'])


class Steps:
    """Counts the stamps that are missing between others."""

    def __init__(self) -> None:
        self.missing = 0
        self._last = self._step = 0

    def add(self, stamp_ns: int) -> None:
        """Note the next stamp; the first two say what the sampling interval is."""
        step = stamp_ns - self._last if self._last else 0
        self._step = self._step or step
        if step:
            self.missing += round(step / self._step) - 1
        self._last = stamp_ns


class Delays:
    """
    Delays from the stamp to the arrival of samples, near the start and near the end.

    :param start_ends: time of arrival up to which a sample is near the start [ns]
    :param end_begins: from which it is near the end [ns]
    """

    def __init__(self, start_ends: int, end_begins: int) -> None:
        self._start_ends, self._end_begins = start_ends, end_begins
        self._early: int | None = None
        self._late: int | None = None
        self._count = 0
        self._first = self._last = 0

    def add(self, arrival: int, stamp: int) -> None:
        """Note a sample."""
        delay = arrival - stamp
        self._count += 1
        self._first, self._last = self._first or arrival, arrival
        if arrival < self._start_ends:
            self._early = delay if self._early is None else min(delay, self._early)
        elif arrival > self._end_begins:
            self._late = delay if self._late is None else min(delay, self._late)

    @property
    def drift_ns(self) -> int:
        """By how much the least delay has grown [ns]."""
        assert self._early is not None
        assert self._late is not None
        return self._late - self._early

    @property
    def rate_hz(self) -> float:
        """Mean rate of arrival [Hz]."""
        return (self._count - 1) / ((self._last - self._first) * 1e-9)
