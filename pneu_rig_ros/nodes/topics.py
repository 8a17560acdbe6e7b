"""Publishers and polled subscriptions for the topics of the rig, without message loss."""

import time
from collections import deque
from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from pneu_rig_ros.nodes.qos import QosMonitor, qos_profile
from pneu_rig_ros.records.topics import STREAM_DEPTH, TOPICS

SHARED_TOPICS = frozenset({'u', '/diagnostics'})
"""Topics that may have several publishers, whose sequence numbers interleave."""

ALTERNATION_TIME = 5.0
"""Two decreases of the sequence number within this time show several publishers [s]."""

MOST_PUBLISHERS = 4
"""Publishers of one topic whose sequence numbers are followed, the latest ones."""


class SequenceNumbers:
    """
    What the sequence numbers of one topic show: lost messages, and publishers that alternate.

    Each publisher counts upwards. A number below the last one is that of another publisher, or of
    the same one after a restart; each number belongs to the publisher whose last one it follows
    most closely. Two decreases within a few seconds are publishers that alternate.
    """

    def __init__(self) -> None:
        self.lost = 0
        """Messages that are missing between those of a publisher."""
        self._publishers: deque[int] = deque(maxlen=MOST_PUBLISHERS)
        self._decreases: deque[float] = deque(maxlen=2)

    def resume(self) -> None:
        """Begin again after a pause, in which no message was expected."""
        self._publishers.clear()

    def add(self, number: int) -> None:
        """Add the number of the next message."""
        publishers = self._publishers
        if publishers and number == publishers[-1] + 1:  # nearly always
            publishers[-1] = number
            return
        if publishers and number <= publishers[-1]:
            self._decreases.append(time.monotonic())
        before = max((last for last in publishers if last < number), default=None)
        if before is not None:
            self.lost += number - before - 1
            publishers.remove(before)
        publishers.append(number)

    @property
    def alternating(self) -> bool:
        """Whether several publishers have alternated within the last seconds."""
        decreases = self._decreases
        return len(decreases) == 2 and time.monotonic() - decreases[0] < ALTERNATION_TIME


class ReceivedMessage(NamedTuple):
    """A message in CDR with its message info; times are nanoseconds since 1970."""

    subscription: 'PolledSubscription'
    cdr: bytes
    sent_ns: int
    received_ns: int


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
    """Create a publisher of a topic in `records.topics`; it takes raw CDR or a typed message."""
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

    It is reliable, which shuts out publishers that are best effort, as those of sensors often are.
    A second subscription that is best effort is added when there is one. What reliable publishers
    send then comes twice and is taken once.

    :param node: its namespace and remappings apply
    :param topic_name: a topic in `records.topics`
    :param monitor: warns of incompatible publishers, and adds the second subscription
    :param depth: of its queue [messages]; 0: that of the publishers
    """

    def __init__(
        self, node: Node, topic_name: str, monitor: QosMonitor | None = None, depth: int = 0
    ) -> None:
        self.topic = TOPICS[topic_name]
        self._class = message_class(self.topic.type)
        self._node = node
        self._monitor = monitor
        self._depth = depth
        self._taken: dict[tuple[int, int], None] = {}
        self.sequence = SequenceNumbers()
        self.subscriptions: list[Subscription] = []
        """The reliable one, and that which is best effort."""
        self._subscribe(reliable=True)
        self.name: str = self.subscriptions[0].topic_name

    def _subscribe(self, reliable: bool) -> None:
        monitor = self._monitor
        subscription = self._node.create_subscription(
            self._class,
            self.topic.name,
            _unused_callback,
            qos_profile(self.topic, self._depth, reliable),
            callback_group=_PolledGroup(),
            event_callbacks=monitor.subscription_callbacks(self.topic, self._accept_best_effort)
            if monitor
            else None,
            raw=True,
        )
        self.subscriptions.append(subscription)

    def destroy(self) -> None:
        """End the subscription."""
        while self.subscriptions:
            self._node.destroy_subscription(self.subscriptions.pop())

    def _accept_best_effort(self) -> None:
        if len(self.subscriptions) == 1:
            self._subscribe(reliable=False)
            text = 'a publisher is best effort: its messages may be lost'
            self._node.get_logger().info(f'{self.name}: {text}')

    def _first_time(self, info: dict[str, int]) -> bool:
        """Return whether a message has not come by the other subscription before."""
        key = info['source_timestamp'], info['publication_sequence_number']
        if key in self._taken:
            del self._taken[key]
            return False
        self._taken[key] = None
        if len(self._taken) > STREAM_DEPTH:  # of publishers that are best effort: comes once
            del self._taken[next(iter(self._taken))]
        return True

    def take_all_with_info(self) -> Iterator[ReceivedMessage]:
        """Yield all waiting messages with the message info of the middleware, oldest first."""
        for subscription in self.subscriptions:
            while taken := subscription.handle.take_message(self._class, True):
                cdr, info = taken
                if len(self.subscriptions) == 1 or self._first_time(info):
                    self.sequence.add(info['publication_sequence_number'])
                    sent_ns, received_ns = info['source_timestamp'], info['received_timestamp']
                    yield ReceivedMessage(self, cdr, sent_ns, received_ns)

    def take_all(self) -> Iterator[bytes]:
        """Yield all waiting messages, oldest first."""
        return (message.cdr for message in self.take_all_with_info())

    def take(self) -> bytes | None:
        """Return the oldest waiting message, None if there is none."""
        return next(self.take_all(), None)


def _unused_callback(message: object) -> None:
    raise AssertionError('a polled subscription was executed')
