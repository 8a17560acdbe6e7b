"""Who cannot talk to a node because the qualities of service do not fit."""

from collections.abc import Callable

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


class Mismatches:
    """
    The misfits of one node's publishers and subscriptions, for as long as they are there.

    The middleware tells when one comes; whether it is still there is looked up in the graph, only
    then, as that costs a millisecond.

    :param node: whose they are
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._found: dict[str, Callable[[], bool]] = {}

    def of_subscription(self, topic: str, quality: QoSProfile) -> SubscriptionEventCallbacks:
        """Return what a new subscription is to call."""
        text = 'a publisher of {} has a quality of service that does not fit: it is not heard'

        def there() -> bool:
            name = self._node.resolve_topic_name(topic)
            others = self._node.get_publishers_info_by_topic(name)
            return any(_misfit(other.qos_profile, quality) for other in others)

        return SubscriptionEventCallbacks(incompatible_qos=self._noting(topic, text, there))

    def of_publisher(self, topic: str, quality: QoSProfile) -> PublisherEventCallbacks:
        """Return what a new publisher is to call."""
        text = 'a subscriber of {} asks for a quality of service that does not fit: it gets none'

        def there() -> bool:
            name = self._node.resolve_topic_name(topic)
            others = self._node.get_subscriptions_info_by_topic(name)
            return any(_misfit(quality, other.qos_profile) for other in others)

        return PublisherEventCallbacks(incompatible_qos=self._noting(topic, text, there))

    def _noting(
        self, topic: str, text: str, there: Callable[[], bool]
    ) -> Callable[[object], None]:
        def note(_: object) -> None:
            told = text.format(self._node.resolve_topic_name(topic))
            self._node.get_logger().warning(told)
            self._found[told] = there

        return note

    def told(self) -> list[str]:
        """Return what to say of those that are there, and forget the others."""
        self._found = {text: there for text, there in self._found.items() if there()}
        return list(self._found)


def _misfit(offered: QoSProfile, wanted: QoSProfile) -> bool:
    """Return whether more is wanted than offered, in what publishers here differ in."""
    return bool(
        (
            wanted.reliability == ReliabilityPolicy.RELIABLE
            and offered.reliability == ReliabilityPolicy.BEST_EFFORT
        )
        or (
            wanted.durability == DurabilityPolicy.TRANSIENT_LOCAL
            and offered.durability == DurabilityPolicy.VOLATILE
        )
    )
