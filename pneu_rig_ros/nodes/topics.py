"""Publishers and polled subscriptions for the topics of the rig, without message loss."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from pneu_rig_ros.nodes.qos import QosMonitor, qos_profile
from pneu_rig_ros.records.topics import TOPICS


class ReceivedMessage(NamedTuple):
    """A message in CDR with its message info; times are nanoseconds since 1970."""

    subscription: 'PolledSubscription'
    cdr: bytes
    sent_ns: int
    received_ns: int
    sequence_number: int


class _PolledGroup(CallbackGroup):
    """Excludes subscriptions, but not their QoS events, from execution by an executor."""

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


def create_publisher(node: Node, topic_name: str, monitor: QosMonitor | None = None) -> Publisher:
    """
    Create a publisher of a topic in `records.topics`; it takes raw CDR or a typed message.

    :param monitor: warns of incompatible subscriptions
    """
    topic = TOPICS[topic_name]
    return node.create_publisher(
        message_class(topic.type),
        topic.name,
        qos_profile(topic),
        event_callbacks=monitor.publisher_callbacks(topic) if monitor else None,
    )


class PolledSubscription:
    """
    A subscription from which the node takes raw CDR itself, much faster than an executor does.

    :param node: its namespace and remappings apply
    :param topic_name: a topic in `records.topics`
    :param monitor: warns of incompatible publishers
    """

    def __init__(self, node: Node, topic_name: str, monitor: QosMonitor | None = None) -> None:
        self.topic = TOPICS[topic_name]
        self._class = message_class(self.topic.type)
        self._subscription = node.create_subscription(
            self._class,
            topic_name,
            _unused_callback,
            qos_profile(self.topic),
            callback_group=_PolledGroup(),
            event_callbacks=monitor.subscription_callbacks(self.topic) if monitor else None,
            raw=True,
        )
        self.handle = self._subscription.handle
        self.name: str = self._subscription.topic_name

    def take(self) -> bytes | None:
        """Return the oldest waiting message, None if there is none."""
        taken = self.handle.take_message(self._class, True)
        return None if taken is None else taken[0]

    def take_all(self) -> Iterator[bytes]:
        """Yield all waiting messages, oldest first."""
        while (taken := self.handle.take_message(self._class, True)) is not None:
            yield taken[0]

    def take_all_with_info(self) -> Iterator[ReceivedMessage]:
        """Yield all waiting messages with the message info of the middleware, oldest first."""
        while (taken := self.handle.take_message(self._class, True)) is not None:
            cdr, info = taken
            yield ReceivedMessage(
                self,
                cdr,
                info['source_timestamp'],
                info['received_timestamp'],
                info['publication_sequence_number'],
            )


def _unused_callback(message: object) -> None:
    raise AssertionError('a polled subscription was executed')
