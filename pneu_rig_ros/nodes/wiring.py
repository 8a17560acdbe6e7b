"""Publishers and polled subscriptions by name, with the one QoS that loses nothing."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from pneu_rig_ros.nodes.mismatches import Mismatches
from pneu_rig_ros.records.topics import DEPTH, TOPICS, Topic


class Arrival(NamedTuple):
    """A message as it came: bytes, when it was sent and received [ns since 1970], its number."""

    cdr: bytes
    sent_ns: int
    received_ns: int
    number: int


class _Polled(CallbackGroup):
    """Keeps subscriptions, but not their events, out of executors: the node's loop takes them."""

    def can_execute(self, entity: Any) -> bool:
        return not isinstance(entity, Subscription)

    def beginning_execution(self, entity: Any) -> bool:
        return not isinstance(entity, Subscription)

    def ending_execution(self, entity: Any) -> None:
        pass


def message_class(type_name: str) -> Any:
    """Return the class of 'std_msgs/msg/Float64'."""
    package, _, name = type_name.split('/')
    return getattr(import_module(f'{package}.msg'), name)


def quality(topic: Topic) -> QoSProfile:
    """Return the quality of service of a topic: reliable and deep; one kept if latched."""
    reliable = ReliabilityPolicy.RELIABLE
    if topic.latched:
        durability = DurabilityPolicy.TRANSIENT_LOCAL
        return QoSProfile(depth=1, reliability=reliable, durability=durability)
    return QoSProfile(depth=DEPTH, reliability=reliable, durability=DurabilityPolicy.VOLATILE)


def outlet(node: Node, topic_name: str, mismatches: Mismatches | None = None) -> Publisher:
    """Return a publisher for a topic of the table; it takes raw CDR or a typed message."""
    topic = TOPICS[topic_name]
    profile = quality(topic)
    events = mismatches.of_publisher(topic.name, profile) if mismatches else None
    return node.create_publisher(
        message_class(topic.type), topic.name, profile, event_callbacks=events
    )


class Inlet:
    """
    A subscription that is polled for raw CDR, many times cheaper than an executor.

    :param node: whose namespace and remaps apply
    :param topic_name: a name of the table
    :param mismatches: is told of publishers that cannot be heard
    """

    def __init__(self, node: Node, topic_name: str, mismatches: Mismatches | None = None) -> None:
        self.topic = TOPICS[topic_name]
        self._class = message_class(self.topic.type)
        profile = quality(self.topic)
        events = mismatches.of_subscription(topic_name, profile) if mismatches else None
        self._subscription = node.create_subscription(
            self._class, topic_name, _never_called, profile,
            callback_group=_Polled(), event_callbacks=events, raw=True,
        )  # fmt: skip
        self.handle = self._subscription.handle
        self.name: str = self._subscription.topic_name

    def take(self) -> bytes | None:
        """Return the oldest message that waits, None if there is none."""
        taken = self.handle.take_message(self._class, True)
        return None if taken is None else taken[0]

    def take_all(self) -> Iterator[bytes]:
        """Yield all messages that wait, oldest first."""
        while (taken := self.handle.take_message(self._class, True)) is not None:
            yield taken[0]

    def arrivals(self) -> Iterator[Arrival]:
        """Yield all messages that wait, with what the middleware knows of them."""
        while (taken := self.handle.take_message(self._class, True)) is not None:
            cdr, info = taken
            yield Arrival(
                cdr,
                info['source_timestamp'],
                info['received_timestamp'],
                info['publication_sequence_number'],
            )


def _never_called(message: object) -> None:
    raise AssertionError('a polled subscription was executed')
