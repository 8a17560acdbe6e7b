"""The live node: samples of a running rig for a web page, and the commands from it."""

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import islice
from threading import Lock
from typing import Any

from rcl_interfaces.srv import SetParameters
from rclpy.client import Client
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_srvs.srv import Trigger

from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.embedding import COMMAND_PERIOD_NS
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.samples import SampleSubscription
from pneu_rig_ros.records.cdr_decoding import (
    unpack_float64,
    unpack_joint_state,
    unpack_valve_voltages,
)
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.configuration import OVERRIDES

HISTORY_LENGTH = 17_241
"""Samples kept for a page that is opened later: 20 s at 862 Hz."""

SIGNALS = 'position', 'velocity', 'pressure_1', 'pressure_2', 'u', 'voltage_1', 'voltage_2'

Row = Sequence[float | None]


class History:
    """Keeps the last rows of a stream of values; one thread adds, others read."""

    def __init__(self, names: Sequence[str], length: int) -> None:
        self._names = tuple(names)
        self._rows: deque[Row] = deque(maxlen=length)
        self._count = 0
        self._lock = Lock()

    def extend(self, rows: Iterable[Row]) -> None:
        """Add rows with one value per column."""
        new = list(rows)
        with self._lock:
            self._rows.extend(new)
            self._count += len(new)

    def since(self, number: int) -> tuple[int, dict[str, list[float | None]]]:
        """Return the total number of rows, and the rows kept after the first `number`."""
        with self._lock:
            fresh = min(max(self._count - number, 0), len(self._rows))
            rows = list(islice(reversed(self._rows), fresh))[::-1]
            count = self._count
        return count, {name: [row[k] for row in rows] for k, name in enumerate(self._names)}


class LiveNode(RigNode):
    """
    Collects the samples of a rig, holds a command on `u` and sets the supply of the plant.

    Other threads may call the methods of `pneu_rig_ros.web.server.Rig`; the others belong to the
    loop. Nothing is published before the first command, so that a controller is not disturbed.
    """

    NAME = 'live'
    period_ns = COMMAND_PERIOD_NS
    unique = False

    def set_up(self) -> None:
        """Create publisher, subscriptions and clients."""
        self.streams = {
            'samples': History(('time', *SIGNALS), HISTORY_LENGTH),
            'friction': History(('time', 'friction'), HISTORY_LENGTH),
        }
        self._publish = self.add_publisher('u').publish
        self._samples = SampleSubscription(self)
        self._friction = self.subscribe('friction')
        self._commands = self.subscribe('u')
        self._valves = self.subscribe('valve_voltages')
        self._descriptions = self.subscribe('rig_description')
        self._supply = self.create_client(SetParameters, 'plant/set_parameters')
        self._reset = self.create_client(Trigger, 'plant/reset')
        self._requests: deque[tuple[Client, Any]] = deque()
        self._wanted: float | None = None
        self._held: float | None = None
        self._u: float | None = None
        self._voltages: tuple[float | None, float | None] = (None, None)
        self._configuration: RigConfiguration | None = None
        self._start_ns: int | None = None
        self._message = ''

    # Methods for other threads.

    def command(self, u: float | None) -> None:
        """Hold the command u [V]; None stops the commands after u = 0."""
        self._wanted = u

    def set_supply_pressure(self, pressure: float) -> None:
        """Request an absolute supply pressure [Pa] from the plant."""
        change = Parameter('supply_pressure', value=pressure).to_parameter_msg()
        self._requests.append((self._supply, SetParameters.Request(parameters=[change])))

    def reset(self) -> None:
        """Request the initial state from the plant."""
        self._requests.append((self._reset, Trigger.Request()))

    def state(self) -> dict[str, Any]:
        """Return what a page shows besides the samples, in SI units."""
        limits, rig = OVERRIDES['supply_pressure'], self._configuration
        load = rig.model.operation.load_mass if rig else 0.0
        return {
            'rig': rig and {'name': rig.name, 'load_mass': load, **rig.geometry()},
            'held': self._wanted,
            'rate': self.rate.per_second,
            'message': self._message,
            'supply_limits': [limits.low, limits.high],
            'changeable': self._supply.service_is_ready(),
        }

    # Methods of the loop.

    def update(self) -> None:
        """Publish the command, send the requests and take the waiting messages."""
        self._publish_command()
        while self._requests:
            self._request(*self._requests.popleft())
        self.take_configurations(self._descriptions, self._use_description)
        # Commands and voltages have no stamp: the newest ones apply to the next samples.
        for u in self.take_decoded(self._commands, unpack_float64):
            self._u = _finite(u)
        for voltage_1, voltage_2 in self.take_decoded(self._valves, unpack_valve_voltages):
            self._voltages = _finite(voltage_1), _finite(voltage_2)
        self._take_samples()

    def _use_description(self, configuration: RigConfiguration) -> None:
        self._configuration = configuration

    def _publish_command(self) -> None:
        wanted = self._wanted
        if wanted is not None or self._held is not None:
            self._publish(pack_float64(wanted or 0.0))
        self._held = wanted

    def _take_samples(self) -> None:
        rows = []
        for s in self._samples.take_all():
            motion = s.position, _finite(s.velocity), s.pressure_1, s.pressure_2
            rows.append((self._time(s.stamp_ns), *motion, self._u, *self._voltages))
        self.streams['samples'].extend(rows)
        self.rate.count += len(rows)
        forces = self.take_decoded(self._friction, unpack_joint_state)
        # A force belongs to a sample 29 ms earlier; one of a sample before the first is skipped.
        self.streams['friction'].extend(
            (self._time(force.stamp_ns), _finite(force.effort))
            for force in forces
            if self._start_ns is not None and force.stamp_ns >= self._start_ns
        )

    def _time(self, stamp_ns: int) -> float:
        """Return the time since the first sample [s]; it restarts at 0 with the rig."""
        if self._start_ns is None or stamp_ns < self._start_ns:
            self._start_ns = stamp_ns
        return round((stamp_ns - self._start_ns) * 1e-9, 6)

    def _request(self, client: Client, request: Any) -> None:
        supply = client is self._supply
        if not client.service_is_ready():
            what = 'supply: ' if supply else ''
            self._message = f'{what}service {client.srv_name} not available'
            return
        future = client.call_async(request)
        if supply:
            future.add_done_callback(self._on_supply_pressure)
        else:
            self._message = ''

    def _on_supply_pressure(self, future: Future) -> None:
        response = future.result()
        result = response.results[0] if response and response.results else None
        accepted = result is not None and result.successful
        self._message = '' if accepted else f'supply: {result and result.reason}'

    def close(self) -> None:
        """Close the valves if this node has commanded them."""
        self._wanted = None
        self._publish_command()

    def status(self) -> NodeStatus:
        """Return the command for `/diagnostics`."""
        values: dict[str, object] = {
            'u held [V]': self._wanted,
            'incomplete samples': self._samples.dropped,
        }
        waiting = self._start_ns is None
        return NodeStatus('waiting for samples' if waiting else 'running', values)


def _finite(value: float) -> float | None:
    return value if abs(value) < float('inf') else None
