"""The base class of all nodes: parameters, topics, a polling update and a status."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, ClassVar, TypeVar

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import parameters
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.loop_timer import LoopTimer, MessageWaitSet, PeriodicTimer
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.qos import QosMonitor
from pneu_rig_ros.nodes.topics import PolledSubscription, create_publisher
from pneu_rig_ros.records.topics import TOPICS

_Value = TypeVar('_Value')

ACKNOWLEDGEMENT_TIMEOUT = 0.3
"""Longest wait for the acknowledgements of each topic at the end [s]."""

COMMON = (
    Parameter(
        'realtime_priority',
        0,
        'priority of the loop under SCHED_FIFO where permitted, 0 = ordinary scheduling',
        '-',
        0,
        99,
    ),
    Parameter(
        'wait_for_subscribers',
        0,
        'subscribers that each topic of this node (but latched ones) must have before it begins',
        '-',
        0,
        100,
    ),
)


class RigNode(Node):
    """
    A node that polls its subscriptions: `Runner` calls `update` whenever its `loop_timer` returns.

    :param name: of the node
    :param context: of ROS; the global one when not given
    :param overrides: parameter values that come before those of the command line
    """

    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()
    period_ns: int = 0
    """Least time between two updates [ns]; 0: update as soon as a message arrives."""
    done: bool = False
    """Whether the node has finished, so that its process ends."""
    unique: ClassVar[bool] = True
    """Whether only one node of this name may run."""
    has_duplicate: bool = False
    """Whether another process runs a node of this name."""

    def __init__(
        self, name: str, context: Context | None, overrides: Mapping[str, Any] | None
    ) -> None:
        given = [RosParameter(key, value=value) for key, value in (overrides or {}).items()]
        super().__init__(name, context=context, parameter_overrides=given)
        parameters.declare(self, (*COMMON, *self.PARAMETERS))
        self.malformed = 0
        self._qos_monitor = QosMonitor(self)
        self._volatile_publishers: list[Publisher] = []
        self.polled_subscriptions: list[PolledSubscription] = []
        self._ready = False
        self._local_subscriptions: Counter[str] = Counter()

    def advertise(self, topic_name: str) -> Publisher:
        """Create a publisher of a topic in `records.topics`."""
        publisher = create_publisher(self, topic_name, self._qos_monitor)
        if not TOPICS[topic_name].latched:
            self._volatile_publishers.append(publisher)
        return publisher

    def subscribe(self, topic_name: str) -> PolledSubscription:
        """Create a polled subscription to a topic in `records.topics`."""
        subscription = PolledSubscription(self, topic_name, self._qos_monitor)
        self.polled_subscriptions.append(subscription)
        return subscription

    def take_decoded(
        self, subscription: PolledSubscription, decode: Callable[[bytes], _Value]
    ) -> Iterator[_Value]:
        """Yield all waiting messages decoded; an invalid one is reported and skipped."""
        for cdr in subscription.take_all():
            with self.skip_invalid(subscription):
                yield decode(cdr)

    @contextmanager
    def skip_invalid(self, subscription: PolledSubscription) -> Iterator[None]:
        """Count and report a message of which the processing in the block raises RigError."""
        try:
            yield
        except RigError as error:
            self.malformed += 1
            self.get_logger().warning(
                f'{subscription.name}: {error}; ignored', throttle_duration_sec=1.0
            )

    def number(self, name: str) -> float:
        """Return a parameter that is a number."""
        return parameters.number(self, name)

    def text(self, name: str) -> str:
        """Return a parameter that is a text."""
        return parameters.text(self, name)

    def flag(self, name: str) -> bool:
        """Return a parameter that is true or false."""
        return parameters.flag(self, name)

    @property
    def simulated_time(self) -> bool:
        """Whether time is simulated, i.e. `use_sim_time`."""
        return self.flag('use_sim_time')

    def set_process_nodes(self, nodes: Iterable['RigNode']) -> None:
        """Make `ready` wait also for the subscriptions of the nodes in this process."""
        self._local_subscriptions = Counter(
            subscription.name for node in nodes for subscription in node.polled_subscriptions
        )

    def ready(self) -> bool:
        """Return whether each topic of this node has had the required number of subscribers."""
        self._ready = self._ready or all(map(self._subscribed, self._volatile_publishers))
        return self._ready

    def _subscribed(self, publisher: Publisher) -> bool:
        local = self._local_subscriptions[publisher.topic_name]
        required = max(int(self.number('wait_for_subscribers')), local)
        return publisher.get_subscription_count() >= required

    def loop_timer(self) -> LoopTimer:
        """Return the timer of the loop in which this node is the first."""
        if self.period_ns:
            return PeriodicTimer(self.period_ns)
        return MessageWaitSet(self.polled_subscriptions, self.context)

    def update(self) -> None:
        """Process the waiting messages and publish what is due; never block."""
        raise NotImplementedError

    def status(self) -> NodeStatus:
        """Return the status of this node for `/diagnostics`."""
        return NodeStatus('running', {})

    def full_status(self) -> NodeStatus:
        """Return the status together with the problems that any node may have."""
        status = self.status()
        name = self.get_fully_qualified_name()
        duplicate = f'another {name} is running: give one rig a namespace'
        malformed = {'malformed messages': self.malformed} if self.malformed else {}
        return NodeStatus(
            status.state,
            {**status.values, **malformed},
            (*status.warnings, *self._qos_monitor.warnings()),
            (*status.errors, duplicate if self.has_duplicate else None),
        )

    def close(self) -> None:
        """Finish while ROS is still up: take the waiting messages, write what is unwritten."""

    def abort(self) -> None:
        """Undo what the constructor did, because the node is not going to run."""

    def wait_for_all_acked(self) -> None:
        """Wait a short time until the subscribers have acknowledged all messages."""
        for publisher in self.publishers:
            publisher.wait_for_all_acked(Duration(seconds=ACKNOWLEDGEMENT_TIMEOUT))
