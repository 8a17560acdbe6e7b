"""`/diagnostics` at 1 Hz: the status of a node, and the counters and checks behind it."""

import os
import socket
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from pneu_rig_ros.nodes.topics import create_publisher
from pneu_rig_ros.records.topics import DIAGNOSTICS

PERIOD_NS = 1_000_000_000

PROCESS_KEY = 'process'
"""Key on `/diagnostics` under which a node states its process."""

SHARED_TOPICS = frozenset({'u', '/diagnostics'})
"""Topics with several publishers, whose sequence numbers interleave."""

ALTERNATION_TIME = 5.0
"""Two decreases of the sequence number within this time show several publishers [s]."""


def process_id() -> str:
    """Return a name that no other process has: its number and host."""
    return f'{os.getpid()}@{socket.gethostname()}'


def hardware_id(namespace: str) -> str:
    """Return the name of the rig, one for all nodes in a namespace: 'pneu_rig/left'."""
    return f'pneu_rig{namespace.rstrip("/")}'


class NodeStatus(NamedTuple):
    """
    Status of a node.

    :param state: what the node does, shown when there is no problem
    :param values: key -> value
    :param warnings: problems, None for those that are absent
    :param errors: worse problems, None for those that are absent
    """

    state: str
    values: Mapping[str, object]
    warnings: tuple[str | None, ...] = ()
    errors: tuple[str | None, ...] = ()

    @property
    def level(self) -> bytes:
        """The level of the worst problem."""
        warning = DiagnosticStatus.WARN if any(self.warnings) else DiagnosticStatus.OK
        return bytes(DiagnosticStatus.ERROR if any(self.errors) else warning)

    @property
    def message(self) -> str:
        """All problems, errors first; the state if there is none."""
        return '; '.join(filter(None, (*self.errors, *self.warnings))) or self.state


class DiagnosticsPublisher:
    """
    Publishes the status of one node once a second.

    :param status: returns the present status
    """

    def __init__(self, node: Node, status: Callable[[], NodeStatus]) -> None:
        self._node = node
        self._status = status
        self._publisher = create_publisher(node, DIAGNOSTICS)
        self._due = 0

    def publish_if_due(self, now_ns: int) -> None:
        """Publish the status unless the last one is younger than a second."""
        if now_ns >= self._due:
            self._due = now_ns + PERIOD_NS
            self.publish()

    def publish(self) -> None:
        """Publish the status now."""
        present = self._status()
        values = {**present.values, PROCESS_KEY: process_id()}
        status = DiagnosticStatus(
            level=present.level,
            name=self._node.get_fully_qualified_name(),
            hardware_id=hardware_id(self._node.get_namespace()),
            message=present.message,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)


class RateCounter:
    """Counts events: increase `count`, the number since the start."""

    def __init__(self) -> None:
        self.count = 0
        self.per_second = 0.0
        """Mean rate between the last two updates [Hz]."""
        self._last_count = 0
        self._last_ns = time.monotonic_ns()

    def update(self) -> float:
        """Return the mean rate since the last update [Hz]."""
        now = time.monotonic_ns()
        elapsed = (now - self._last_ns) * 1e-9
        self.per_second = (self.count - self._last_count) / elapsed if elapsed > 0 else 0.0
        self._last_ns, self._last_count = now, self.count
        return self.per_second


class LossCounter:
    """Counts lost messages by gaps in the sequence numbers of topics with one publisher."""

    def __init__(self) -> None:
        self.total = 0
        self._last: dict[str, int] = {}

    def add(self, topic_name: str, sequence_number: int) -> None:
        """Add the next message of a topic; a restarted publisher counts from the beginning."""
        last = self._last.get(topic_name, sequence_number)
        if sequence_number > last + 1 and topic_name not in SHARED_TOPICS:
            self.total += sequence_number - last - 1
        self._last[topic_name] = sequence_number


class PublisherConflict:
    """
    Detects several publishers of one topic by their sequence numbers.

    Each publisher counts upwards. A decrease is another publisher, or the same one after a
    restart; two decreases within a few seconds are publishers that alternate.
    """

    def __init__(self) -> None:
        self._last = 0
        self._decreases: deque[float] = deque(maxlen=2)

    def add(self, sequence_number: int) -> None:
        """Add the next message of the topic."""
        if sequence_number <= self._last:
            self._decreases.append(time.monotonic())
        self._last = sequence_number

    @property
    def detected(self) -> bool:
        """Whether several publishers have alternated within the last seconds."""
        decreases = self._decreases
        return len(decreases) == 2 and time.monotonic() - decreases[0] < ALTERNATION_TIME
