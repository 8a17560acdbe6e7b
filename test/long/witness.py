"""A node beside the rig that commands it, and keeps every message that it receives."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.topics import PolledSubscription, create_publisher
from pneu_rig_ros.records.bag import open_bag
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.records.topics import DIAGNOSTICS, TOPICS

from .live_rig import PATIENCE

U = 0.34
COMMAND_PERIOD = 0.02
STROKE = 10.0
"""Command [V], how often it is given [s], and after how long it changes its sign [s]."""

WARN, ERROR = b'\x01', b'\x02'
LAST_WORDS_NS, LATE_NS = 1_000_000_000, 100_000_000
"""Before and after the death of a sender [ns]."""

WATCHED = [topic.name for topic in TOPICS.values() if not topic.extra and topic.name != '/clock']


class Received(NamedTuple):
    """A message: when it was received [ns since 1970], and its bytes."""

    time_ns: int
    cdr: bytes


class Status(NamedTuple):
    """What a node said last on /diagnostics."""

    level: bytes
    message: str
    values: dict[str, str]


class Witness:
    """
    Listens to a rig and commands it; a context manager.

    :param commands: whether to give commands, each a little different from all others
    :param topics: that it listens to
    """

    def __init__(self, commands: bool = True, topics: Sequence[str] = WATCHED) -> None:
        self._topics = topics
        self.received: dict[str, list[Received]] = defaultdict(list)
        self.said: dict[str, Status] = {}
        self.silent = not commands
        self.commands = 0
        self._due = 0.0

    def __enter__(self) -> Witness:
        self.context = Context()
        rclpy.init(context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node('witness', context=self.context)
        self._subscriptions = [PolledSubscription(self.node, topic) for topic in self._topics]
        self._publisher = None if self.silent else create_publisher(self.node, 'u')
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.node.destroy_node()
        self.context.try_shutdown()

    def turn(self) -> None:
        """Give a command if it is due, take what has come."""
        now = time.monotonic()
        if self._publisher is not None and not self.silent and now >= self._due:
            self._due = now + COMMAND_PERIOD
            self.commands += 1
            sign = 1.0 if now // STROKE % 2 else -1.0
            self._publisher.publish(pack_float64(sign * (U + 1e-9 * self.commands)))
        for subscription in self._subscriptions:
            for arrival in subscription.take_all_with_info():
                message = Received(arrival.received_ns, arrival.cdr)
                self.received[subscription.topic.name].append(message)
                if subscription.topic.name == DIAGNOSTICS:
                    self._hear(arrival.cdr)
        time.sleep(0.004)

    def _hear(self, cdr: bytes) -> None:
        message: Any = deserialize_message(cdr, DiagnosticArray)
        for status in message.status:
            values = {item.key: item.value for item in status.values}
            self.said[status.name.lstrip('/')] = Status(status.level, status.message, values)

    def listen(self, seconds: float) -> None:
        """Listen for a while [s]."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.turn()

    def until(
        self, condition: Callable[[], object], what: str, patience: float = PATIENCE
    ) -> float:
        """Listen until something is so; return how long it took [s]. RigError if too long."""
        start = time.monotonic()
        while not condition():
            if time.monotonic() - start > patience:
                raise RigError(f'not within {patience:g} s: {what}')
            self.turn()
        return time.monotonic() - start

    def hears(self, topic: str) -> float:
        """Listen until the next message of a topic; return how long it took [s]."""
        known = len(self.received[topic])
        return self.until(lambda: len(self.received[topic]) > known, f'a message on {topic}')

    def reports(self, node: str, level: bytes, word: str) -> str:
        """Listen until a node says something on /diagnostics at a level; return what it said."""

        def said() -> bool:
            status = self.said.get(node)
            return status is not None and status.level == level and word in status.message

        try:
            self.until(said, '')
        except RigError as error:
            last = self.said.get(node)
            raise RigError(f'{node} does not say {word!r} on /diagnostics: {last}') from error
        return self.said[node].message


def missing(
    received: dict[str, list[Received]], bag: Path, until_ns: int, deaths_ns: Sequence[int] = ()
) -> dict[str, int]:
    """
    Return how many messages a bag lacks, by topic, of those that lack some.

    What came before the first message of a topic in the bag is not expected in it. /diagnostics is
    not compared: between its fields are bytes that differ for each subscriber.

    :param until_ns: up to when what was received has to be in the bag [ns since 1970]
    :param deaths_ns: when senders were killed, whose last messages may have reached only the
        witness [ns since 1970]
    """
    kept: dict[str, Counter[bytes]] = defaultdict(Counter)
    first_ns: dict[str, int] = {}
    with open_bag(bag) as reader:
        for connection, time_ns, cdr in reader.messages():
            topic = connection.topic.lstrip('/')
            kept[topic][bytes(cdr)] += 1
            first_ns.setdefault(topic, time_ns + LATE_NS)

    def expected(topic: str, time_ns: int) -> bool:
        last = any(-LATE_NS <= death - time_ns <= LAST_WORDS_NS for death in deaths_ns)
        return first_ns.get(topic, 0) < time_ns <= until_ns and not last

    lost = {
        topic: (Counter(m.cdr for m in found if expected(topic, m.time_ns)) - kept[topic]).total()
        for topic, found in received.items()
        if topic != DIAGNOSTICS
    }
    return {topic: count for topic, count in lost.items() if count}
