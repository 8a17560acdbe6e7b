"""What all nodes of the rig share: parameters from a table, work in turns, a report."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, ClassVar, NamedTuple, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import parameters, wiring
from pneu_rig_ros.nodes.mismatches import Mismatches
from pneu_rig_ros.nodes.pacing import Arrivals, Metronome, Pace
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.wiring import Inlet
from pneu_rig_ros.records.topics import TOPICS

_Value = TypeVar('_Value')

DELIVERY_SECONDS = 0.3

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


class Report(NamedTuple):
    """What a node says on `/diagnostics` once a second."""

    level: bytes
    summary: str
    values: dict[str, object]

    @classmethod
    def of(
        cls,
        fine: str,
        values: dict[str, object],
        warnings: Iterable[str | None] = (),
        errors: Iterable[str | None] = (),
    ) -> 'Report':
        """Return a report of all troubles, those that are None left out; `fine` without any."""
        worst, less = [e for e in errors if e], [w for w in warnings if w]
        level = DiagnosticStatus.ERROR if worst else DiagnosticStatus.WARN
        if worst or less:
            return cls(level, '; '.join((*worst, *less)), values)
        return cls(DiagnosticStatus.OK, fine, values)


class RigNode(Node):
    """
    A node that works in turns: its loop calls `work` when `pace` says so.

    :param name: of the node
    :param context: of ROS; the global one when not given
    :param overrides: parameter values that come before those of the command line
    """

    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()
    period_ns: int = 0
    """Least time between two turns [ns] when the node shares a loop with others."""
    done: bool = False
    """Whether the node has nothing left to do: its process ends."""
    unique: ClassVar[bool] = True
    """Whether there may be only one node of its name."""
    has_twin: bool = False
    """Whether there is another node of its name."""

    def __init__(
        self, name: str, context: Context | None, overrides: Mapping[str, Any] | None
    ) -> None:
        given = [RosParameter(key, value=value) for key, value in (overrides or {}).items()]
        super().__init__(name, context=context, parameter_overrides=given)
        parameters.declare(self, (*COMMON, *self.PARAMETERS))
        self.malformed = 0
        self._mismatches = Mismatches(self)
        self._outlets: list[Publisher] = []
        self.inlets: list[Inlet] = []
        self._began = False
        self._companions: Counter[str] = Counter()

    def outlet(self, topic_name: str) -> Publisher:
        """Return a new publisher for a topic of the table."""
        publisher = wiring.outlet(self, topic_name, self._mismatches)
        if not TOPICS[topic_name].latched:
            self._outlets.append(publisher)
        return publisher

    def inlet(self, topic_name: str) -> Inlet:
        """Return a new polled subscription to a topic of the table."""
        inlet = Inlet(self, topic_name, self._mismatches)
        self.inlets.append(inlet)
        return inlet

    def heard(self, inlet: Inlet, decode: Callable[[bytes], _Value]) -> Iterator[_Value]:
        """Yield the messages that wait, decoded; what is none is told and left out."""
        for cdr in inlet.take_all():
            with self.refusing(inlet):
                yield decode(cdr)

    @contextmanager
    def refusing(self, inlet: Inlet) -> Iterator[None]:
        """Leave out the message at hand when it cannot be used: count it, and say why."""
        try:
            yield
        except RigError as error:
            self.malformed += 1
            self.get_logger().warning(
                f'{inlet.name}: {error}; left out', throttle_duration_sec=1.0
            )

    def number(self, name: str) -> float:
        """Return a parameter that is a number."""
        return parameters.number(self, name)

    def text(self, name: str) -> str:
        """Return a parameter that is a text."""
        return parameters.text(self, name)

    @property
    def simulated_time(self) -> bool:
        """Whether time is simulated, i.e. `use_sim_time`."""
        return parameters.switch(self, 'use_sim_time')

    def expect(self, companions: Iterable['RigNode']) -> None:
        """Make `ready` wait also for the subscriptions of nodes in the same process."""
        self._companions = Counter(inlet.name for node in companions for inlet in node.inlets)

    def ready(self) -> bool:
        """Return whether every topic of this node has had the subscribers it is to wait for."""
        self._began = self._began or all(map(self._awaited, self._outlets))
        return self._began

    def _awaited(self, publisher: Publisher) -> bool:
        wanted = max(
            int(self.number('wait_for_subscribers')), self._companions[publisher.topic_name]
        )
        return publisher.get_subscription_count() >= wanted

    def pace(self) -> Pace:
        """Return what paces the loop of this node when it runs on its own."""
        if self.period_ns:
            return Metronome(self.period_ns)
        return Arrivals(self.inlets, self.context)

    def work(self) -> None:
        """Do what is due; never block."""
        raise NotImplementedError

    def report(self) -> Report:
        """Return what `/diagnostics` shows of this node."""
        return Report(DiagnosticStatus.OK, 'running', {})

    def full_report(self) -> Report:
        """Return the report with what troubles every node alike."""
        report = self.report()
        troubles = self._mismatches.told()
        level = max(report.level, DiagnosticStatus.WARN if troubles else DiagnosticStatus.OK)
        if self.has_twin:
            level = DiagnosticStatus.ERROR
            name = self.get_fully_qualified_name()
            troubles.append(f'another {name} is running: give one rig a namespace')
        if not troubles:
            return report
        if report.level != DiagnosticStatus.OK:
            troubles.insert(0, report.summary)
        return Report(level, '; '.join(troubles), report.values)

    def close(self) -> None:
        """Finish while ROS is still up: take what waits, write what is unwritten."""

    def withdraw(self) -> None:
        """Take back what was done before the first turn."""

    def await_delivery(self) -> None:
        """Wait, though not for long, until the subscribers have what was published."""
        for publisher in self.publishers:
            publisher.wait_for_all_acked(Duration(seconds=DELIVERY_SECONDS))
