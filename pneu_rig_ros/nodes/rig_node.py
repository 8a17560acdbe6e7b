"""The base class of all nodes: parameters, topics, a polling update and a status."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import astuple
from typing import Any, ClassVar, NamedTuple, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.context import Context
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.nodes.diagnostics import NodeStatus, RateCounter
from pneu_rig_ros.nodes.qos import QosMonitor
from pneu_rig_ros.nodes.timing import LoopTimer, MessageWaitSet, PeriodicTimer
from pneu_rig_ros.nodes.topics import SHARED_TOPICS, PolledSubscription, create_publisher
from pneu_rig_ros.records.cdr_decoding import unpack_string
from pneu_rig_ros.records.topics import DIAGNOSTICS, TOPICS
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml


class Parameter(NamedTuple):
    """
    One parameter of a node.

    :param default: its type is the type of the parameter
    :param unit: SI unit, empty for texts and flags
    :param low: smallest allowed number [unit]
    :param high: largest allowed number [unit]
    :param choices: allowed names; empty for any text
    :param constraint: what else its value must be
    :param read_only: whether it is fixed while the node runs
    """

    name: str
    default: bool | int | float | str
    description: str
    unit: str = ''
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    read_only: bool = True
    constraint: str = ''

    @property
    def names(self) -> str:
        """The choices as text."""
        return ', '.join(choice or "''" for choice in self.choices)

    @property
    def allowed(self) -> str:
        """The constraints besides type and range; '' without any."""
        return f'one of {self.names}' if self.choices else self.constraint

    @classmethod
    def of(
        cls, name: str, quantity: Quantity, default: float, read_only: bool = True
    ) -> 'Parameter':
        """Return the parameter for a quantity of the rig."""
        unit, low, high, description = astuple(quantity)
        return cls(name, default, description, unit, low, high, read_only=read_only)

    def descriptor(self) -> ParameterDescriptor:
        """Return the descriptor, by which ROS tools show the parameter and rclpy checks it."""
        descriptor = ParameterDescriptor(
            description=self.description + (f' [{self.unit}]' if self.unit else ''),
            additional_constraints=self.allowed,
            read_only=self.read_only,
        )
        if math.isfinite(self.low) and math.isfinite(self.high):
            if isinstance(self.default, float):
                limits = FloatingPointRange(from_value=self.low, to_value=self.high)
                descriptor.floating_point_range = [limits]
            else:
                whole = IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)
                descriptor.integer_range = [whole]
        return descriptor


Overrides = Mapping[str, Any] | None
"""Parameter values that come before those of the command line."""

_Value = TypeVar('_Value')

COMMON = (
    Parameter('realtime_priority', 0, 'SCHED_FIFO priority where permitted; 0: none', '-', 0, 99),
    Parameter('wait_for_subscribers', 0, 'subscribers of each topic to wait for', '-', 0, 100),
)


class RigNode(Node):
    """A node that polls its subscriptions: `Runner` calls `update` when `loop_timer` returns."""

    NAME: ClassVar[str]
    SHARED: ClassVar[tuple[Parameter, ...]] = COMMON
    """Parameters that all nodes of this kind have."""
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()
    """Further parameters."""
    period_ns: int = 0
    """Least time between two updates [ns]; 0: update as soon as a message arrives."""
    active: bool = True
    """Whether the node runs; see `ManagedNode`."""
    done: bool = False
    """Whether the node has finished, so that its process ends."""
    unique: ClassVar[bool] = True
    """Whether only one node of this name may run."""
    has_duplicate: bool = False
    """Whether another process runs a node of this name."""

    def __init__(self, context: Context | None = None, overrides: Overrides = None) -> None:
        given = [RosParameter(key, value=value) for key, value in (overrides or {}).items()]
        super().__init__(self.NAME, context=context, parameter_overrides=given)
        self._declare((*self.SHARED, *self.PARAMETERS))
        self._declare(self.dependent_parameters())
        self.add_on_set_parameters_callback(self.on_parameters)
        self.rate = RateCounter()
        """Messages published, or recorded."""
        self.refused = 0
        """Messages that were invalid."""
        self.polled_subscriptions: list[PolledSubscription] = []
        self._qos_monitor = QosMonitor(self)
        self._volatile_publishers: list[Publisher] = []
        self._ready = False
        self.process_nodes: Iterable[RigNode] = ()
        """The nodes of this process, once a `Runner` has them."""
        self._owned = ExitStack()
        self._diagnostics = create_publisher(self, DIAGNOSTICS)
        self.begin()

    def _declare(self, table: Iterable[Parameter]) -> None:
        """Declare parameters; RigError when a given value has a wrong type or is out of range."""
        for one in table:
            where = f'{self.get_name()}: parameter {one.name}'
            try:
                value = self.declare_parameter(one.name, one.default, one.descriptor()).value
            except ParameterException as error:
                raise RigError(f'{where}: {error}') from error
            if one.choices and value not in one.choices:
                raise RigError(f'{where}: {value!r}, allowed {one.names}')

    def begin(self) -> None:
        """Make the new node ready to run."""
        self.set_up()

    def set_up(self) -> None:
        """Read files, compile, create publishers and subscriptions; may raise RigError."""

    def on_parameters(self, changes: list[RosParameter]) -> SetParametersResult:
        """Refuse another time source for a running node: stamps would jump by decades."""
        if any(change.name == 'use_sim_time' for change in changes):
            return SetParametersResult(reason='use_sim_time is fixed while the node runs')
        return SetParametersResult(successful=True)

    def dependent_parameters(self) -> Iterable[Parameter]:
        """Return the parameters whose defaults depend on the value of another."""
        return ()

    def add_publisher(self, topic_name: str) -> Publisher:
        """Create a publisher of a topic in `records.topics`."""
        publisher = create_publisher(self, topic_name, self._qos_monitor)
        if not TOPICS[topic_name].transient_local:
            self._volatile_publishers.append(publisher)
        self._owned.callback(self.destroy_publisher, publisher)
        return publisher

    def subscribe(self, topic_name: str, depth: int = 0) -> PolledSubscription:
        """Create a polled subscription to a topic in `records.topics`; depth 0: as published."""
        subscription = PolledSubscription(self, topic_name, self._qos_monitor, depth)
        self.polled_subscriptions.append(subscription)
        self._owned.callback(subscription.destroy)
        return subscription

    def take_decoded(
        self, subscription: PolledSubscription, decode: Callable[[bytes], _Value]
    ) -> Iterator[_Value]:
        """Yield all waiting messages decoded; an invalid one is refused."""
        for cdr in subscription.take_all():
            with self.skip_invalid(subscription):
                yield decode(cdr)

    def take_configurations(
        self, descriptions: PolledSubscription, use: Callable[[RigConfiguration], None]
    ) -> None:
        """Call `use` with each waiting `rig_description`; an invalid one is refused."""
        for cdr in descriptions.take_all():
            with self.skip_invalid(descriptions):
                use(configuration_from_yaml(unpack_string(cdr), descriptions.name))

    @contextmanager
    def skip_invalid(
        self, subscription: PolledSubscription, consequence: str = 'ignored'
    ) -> Iterator[None]:
        """Refuse a message of which the processing in the block raises RigError or ValueError."""
        try:
            yield
        except (RigError, ValueError) as error:
            self.refuse(f'{subscription.name}: {error}; {consequence}')

    def refuse(self, warning: str) -> None:
        """Count an invalid message, and warn of it at most once a second."""
        self.refused += 1
        self.get_logger().warning(warning, throttle_duration_sec=1.0)

    def number(self, name: str) -> float:
        """Return a parameter that is a number."""
        return float(self.get_parameter(name).value)

    def text(self, name: str) -> str:
        """Return a parameter that is a text."""
        return str(self.get_parameter(name).value)

    def flag(self, name: str) -> bool:
        """Return a parameter that is true or false."""
        return bool(self.get_parameter(name).value)

    @property
    def frame_prefix(self) -> str:
        """Prefix of the frames in headers, that of the launch files: the namespace of the rig."""
        namespace = self.get_namespace().strip('/')
        return f'{namespace}/' if namespace else ''

    @property
    def simulated_time(self) -> bool:
        """Whether time is simulated, i.e. `use_sim_time`."""
        return self.flag('use_sim_time')

    def ready(self) -> bool:
        """Return whether each topic of this node has had the required number of subscribers."""
        if not self._ready:
            required = int(self.number('wait_for_subscribers'))
            local = Counter(s.name for n in self.process_nodes for s in n.polled_subscriptions)
            self._ready = all(
                publisher.get_subscription_count() >= max(required, local[publisher.topic_name])
                for publisher in self._volatile_publishers
            )
        return self._ready

    def loop_timer(self) -> LoopTimer:
        """Return the timer of the loop in which this node is the first."""
        if self.period_ns:
            return PeriodicTimer(self.period_ns)
        return MessageWaitSet(self.awaited, self.context)

    def awaited(self) -> Iterator[PolledSubscription]:
        """Yield the inputs of all nodes of this process that answer messages at once."""
        for node in self.process_nodes:
            if node.active and not node.period_ns and node.ready():
                yield from node.inputs()

    def inputs(self) -> Iterable[PolledSubscription]:
        """Return the subscriptions whose messages `update` takes as it is; others can wait."""
        return self.polled_subscriptions

    def update(self) -> None:
        """Process the waiting messages and publish what is due; never block."""
        raise NotImplementedError

    def status(self) -> NodeStatus:
        """Return what this node reports on `/diagnostics` besides `full_status`."""
        return NodeStatus('running', {})

    def publish_status(self) -> None:
        """Publish the full status on `/diagnostics`."""
        self._diagnostics.publish(self.full_status().to_message(self))

    def full_status(self) -> NodeStatus:
        """Return the status with the rate and the problems that any node may have."""
        rate = self.rate.update()
        status = self.status() if self.active else NodeStatus('inactive', {})
        name = self.get_fully_qualified_name()
        duplicate = f'another {name} is running: give one rig a namespace'
        conflicts = (
            f'{one.name} comes from several publishers'
            for one in self.polled_subscriptions
            if one.topic.name not in SHARED_TOPICS and one.sequence.alternating
        )
        return NodeStatus(
            status.state,
            {'rate [Hz]': f'{rate:.2f}', **status.values, 'refused messages': self.refused},
            (*status.warnings, *self._qos_monitor.warnings(), *conflicts),
            (*status.errors, duplicate if self.has_duplicate else None),
        )

    def close(self) -> None:
        """Finish while ROS is still up: take the waiting messages, write what is unwritten."""

    def abort(self) -> None:
        """Undo what the constructor did, because the node is not going to run."""
