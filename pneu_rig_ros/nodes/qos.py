"""QoS of every topic, and detection of endpoints that are incompatible with it."""

from collections.abc import Callable, Iterable

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from pneu_rig_ros.records.topics import DEPTH, Topic


def qos_profile(topic: Topic) -> QoSProfile:
    """Return a reliable, deep and volatile profile; latched: depth 1 and transient local."""
    reliable = ReliabilityPolicy.RELIABLE
    if topic.latched:
        durability = DurabilityPolicy.TRANSIENT_LOCAL
        return QoSProfile(depth=1, reliability=reliable, durability=durability)
    return QoSProfile(depth=DEPTH, reliability=reliable, durability=DurabilityPolicy.VOLATILE)


class QosMonitor:
    """
    Warns of endpoints whose QoS is incompatible with the publishers and subscriptions of a node.

    The middleware reports such an endpoint when it is discovered. Only then is the graph queried
    whether it still exists, because a query takes about a millisecond.

    :param node: owner of the monitored publishers and subscriptions
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._incompatible: dict[str, Callable[[], bool]] = {}

    def subscription_callbacks(self, topic: Topic) -> SubscriptionEventCallbacks:
        """Return the event callbacks for a new subscription."""

        def incompatible() -> bool:
            others = self._node.get_publishers_info_by_topic(topic.name)
            return not _all_compatible((o.qos_profile, qos_profile(topic)) for o in others)

        text = (
            f'a publisher of {self._node.resolve_topic_name(topic.name)} offers incompatible QoS'
        )
        callback = self._callback(f'{text}: its messages are not received', incompatible)
        return SubscriptionEventCallbacks(incompatible_qos=callback)

    def publisher_callbacks(self, topic: Topic) -> PublisherEventCallbacks:
        """Return the event callbacks for a new publisher."""

        def incompatible() -> bool:
            others = self._node.get_subscriptions_info_by_topic(topic.name)
            return not _all_compatible((qos_profile(topic), o.qos_profile) for o in others)

        name = self._node.resolve_topic_name(topic.name)
        text = f'a subscription to {name} requests incompatible QoS: it receives no messages'
        return PublisherEventCallbacks(incompatible_qos=self._callback(text, incompatible))

    def _callback(
        self, warning: str, incompatible: Callable[[], bool]
    ) -> Callable[[object], None]:
        def on_incompatible_qos(_: object) -> None:
            self._node.get_logger().warning(warning)
            self._incompatible[warning] = incompatible

        return on_incompatible_qos

    def warnings(self) -> list[str]:
        """Return one warning for each topic that still has an incompatible endpoint."""
        present = {text: check for text, check in self._incompatible.items() if check()}
        self._incompatible = present
        return list(present)


def _all_compatible(pairs: Iterable[tuple[QoSProfile, QoSProfile]]) -> bool:
    """Return whether each offered profile satisfies the requested one."""
    checks = (qos_check_compatible(offered, requested) for offered, requested in pairs)
    return all(compatibility != QoSCompatibility.ERROR for compatibility, _ in checks)
