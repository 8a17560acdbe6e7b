"""QoS of every topic, and detection of endpoints that are incompatible with it."""

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from pneu_rig_ros.records.topics import Topic


def qos_profile(topic: Topic, depth: int = 0, reliable: bool = True) -> QoSProfile:
    """
    Return the profile of a topic: volatile, or transient local if the topic is.

    :param depth: of a subscription [messages]; 0: that of the publishers
    :param reliable: False for publishers that are best effort
    """
    kept = topic.transient_local
    return QoSProfile(
        depth=1 if kept else depth or topic.depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE,
    )


class QosMonitor:
    """
    Warns of endpoints whose QoS is incompatible with the publishers and subscriptions of a node.

    The middleware reports such an endpoint when it is discovered. Only then is the graph queried
    whether it still exists, because a query takes about a millisecond.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._incompatible: dict[str, Callable[[], bool]] = {}

    def subscription_callbacks(
        self, topic: Topic, accept_best_effort: Callable[[], None]
    ) -> SubscriptionEventCallbacks:
        """
        Return the event callbacks of a new subscription.

        :param accept_best_effort: called when there is a best-effort publisher
        """
        requested = qos_profile(topic, reliable=False)
        name = self._node.resolve_topic_name(topic.name)
        text = f'a publisher of {name} offers incompatible QoS: its messages are not received'

        def incompatible() -> bool:
            others = self._node.get_publishers_info_by_topic(topic.name)
            return not all(_compatible(other.qos_profile, requested) for other in others)

        def on_incompatible_qos(event: Any) -> None:
            if event.last_policy_kind == QoSPolicyKind.RELIABILITY:
                accept_best_effort()
            else:
                self._warn(text, incompatible)

        return SubscriptionEventCallbacks(incompatible_qos=on_incompatible_qos)

    def publisher_callbacks(self, topic: Topic) -> PublisherEventCallbacks:
        """Return the event callbacks for a new publisher."""
        offered = qos_profile(topic)
        name = self._node.resolve_topic_name(topic.name)
        text = f'a subscription to {name} requests incompatible QoS: it receives no messages'

        def incompatible() -> bool:
            others = self._node.get_subscriptions_info_by_topic(topic.name)
            return not all(_compatible(offered, other.qos_profile) for other in others)

        return PublisherEventCallbacks(incompatible_qos=lambda _: self._warn(text, incompatible))

    def _warn(self, text: str, incompatible: Callable[[], bool]) -> None:
        self._node.get_logger().warning(text)
        self._incompatible[text] = incompatible

    def warnings(self) -> list[str]:
        """Return one warning for each topic that still has an incompatible endpoint."""
        present = {text: check for text, check in self._incompatible.items() if check()}
        self._incompatible = present
        return list(present)


def _compatible(offered: QoSProfile, requested: QoSProfile) -> bool:
    """Return whether an offered profile satisfies the requested one."""
    # without their deadlines: the graph reports none as infinite, which is refused
    compared = (
        QoSProfile(depth=1, reliability=profile.reliability, durability=profile.durability)
        for profile in (offered, requested)
    )
    compatibility, _ = qos_check_compatible(*compared)
    return bool(compatibility != QoSCompatibility.ERROR)
