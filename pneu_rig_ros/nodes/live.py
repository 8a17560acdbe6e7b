"""The live node: what a page in a browser shows of a running rig, and the commands it gives."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_srvs.srv import Trigger

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.joining import Joiner
from pneu_rig_ros.nodes.live_history import History
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.records.cdr import (
    pack_float64,
    unpack_float64,
    unpack_fluid_pressure,
    unpack_joint_state,
    unpack_string,
    unpack_valve_voltages,
)
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml
from pneu_rig_ros.rig.configuration import OVERRIDES

KEPT = 17_241
"""Samples kept for a page that comes later: 20 s at 862 Hz."""

PERIOD_NS = 20_000_000
"""Commands go out at 50 Hz, often enough for any sensible `command_timeout`."""

SAMPLE = ('time', 'position', 'velocity', 'pressure_1', 'pressure_2',
          'u', 'voltage_1', 'voltage_2')  # fmt: skip
FRICTION = ('time', 'friction')


class LiveNode(RigNode):
    """
    Gathers the samples of a rig, holds a command on `u` and changes the plant's set-up.

    Other threads may call everything that `pneu_rig_ros.web.server.Rig` names; the rest is for
    the loop. Nothing is published before the first command, so that a controller is not disturbed.
    """

    period_ns = PERIOD_NS
    unique = False

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('live', context, overrides)
        self.streams = {'samples': History(SAMPLE, KEPT), 'friction': History(FRICTION, KEPT)}
        self._publish = self.outlet('u').publish
        self._connect()
        self._supply = self.create_client(SetParameters, 'plant/set_parameters')
        self._reset = self.create_client(Trigger, 'plant/reset')
        self._requests: deque[Callable[[], None]] = deque()
        self._wanted: float | None = None
        self._held: float | None = None
        self._u: float | None = None
        self._voltages: tuple[float | None, float | None] = (None, None)
        self._configuration: RigConfiguration | None = None
        self._start_ns: int | None = None
        self._told = ''
        self._rate = Rate()
        self._per_second = 0.0

    def _connect(self) -> None:
        self._joints = self.inlet('joint_states')
        self._chambers = [self.inlet(f'chamber_{i}/pressure') for i in (1, 2)]
        self._friction = self.inlet('friction')
        self._commands = self.inlet('u')
        self._valves = self.inlet('valve_voltages')
        self._descriptions = self.inlet('rig_description')
        self._joiner = Joiner(4)

    # --- for other threads ---

    def command(self, u: float | None) -> None:
        """Hold the command u [V] from now on; None leaves it to others, after u = 0."""
        self._wanted = u

    def set_supply_pressure(self, pressure: float) -> None:
        """Ask the plant for an absolute supply pressure [Pa]."""
        self._requests.append(lambda: self._ask_supply_pressure(pressure))

    def reset(self) -> None:
        """Ask the plant for its initial state."""
        self._requests.append(self._ask_reset)

    def state(self) -> dict[str, Any]:
        """Return what a page shows besides the samples, SI units."""
        limits = OVERRIDES['supply_pressure']
        return {
            'rig': self._described(),
            'held': self._wanted,
            'rate': self._per_second,
            'told': self._told,
            'supply_limits': [limits.low, limits.high],
            'changeable': self._supply.service_is_ready(),
        }

    def _described(self) -> dict[str, Any] | None:
        if self._configuration is None:
            return None
        model = self._configuration.model
        return {
            'name': self._configuration.name,
            'stroke': model.cylinder.stroke,
            'bore': model.cylinder.bore,
            'rod_diameter': model.cylinder.rod_diameter,
            'atmospheric_pressure': model.gas.atmospheric_pressure,
            'supply_pressure': model.operation.supply_pressure,
            'load_mass': model.operation.load_mass,
            'intake_voltage': model.valve.intake_voltage,
            'exhaust_voltage': model.valve.exhaust_voltage,
        }

    # --- the loop ---

    def work(self) -> None:
        """Hold the command, pass on what was asked for, and take what has come."""
        self._drive()
        while self._requests:
            self._requests.popleft()()
        for cdr in self._descriptions.take_all():
            self._read_description(cdr)
        self._take_valves()
        self._take_samples()

    def _drive(self) -> None:
        wanted = self._wanted
        if wanted is not None or self._held is not None:
            self._publish(pack_float64(wanted or 0.0))
        self._held = wanted

    def _take_valves(self) -> None:
        """Take the newest command and voltages, which have no stamps; they hold from here on."""
        for u in self.heard(self._commands, unpack_float64):
            self._u = _finite(u)
        for voltage_1, voltage_2 in self.heard(self._valves, unpack_valve_voltages):
            self._voltages = _finite(voltage_1), _finite(voltage_2)

    def _take_samples(self) -> None:
        positions, velocities, *pressures = self._joiner.queues
        for reading in self.heard(self._joints, unpack_joint_state):
            positions.append((reading.stamp_ns, reading.position))
            velocities.append((reading.stamp_ns, reading.velocity))
        for queue, chamber in zip(pressures, self._chambers, strict=True):
            queue.extend(reading[:2] for reading in self.heard(chamber, unpack_fluid_pressure))
        held = (self._u, *self._voltages)
        rows = [
            (self._time(ns), *map(_finite, values), *held) for ns, values in self._joiner.joined()
        ]
        self.streams['samples'].extend(rows)
        self._rate.count += len(rows)
        forces = self.heard(self._friction, unpack_joint_state)
        # A force belongs to a sample 29 ms back; one from before the first sample has no place.
        self.streams['friction'].extend(
            (self._time(force.stamp_ns), _finite(force.effort))
            for force in forces
            if self._start_ns is not None and force.stamp_ns >= self._start_ns
        )

    def _time(self, stamp_ns: int) -> float:
        """Return the time since the first sample [s]; a rig that was started anew begins at 0."""
        if self._start_ns is None or stamp_ns < self._start_ns:
            self._start_ns = stamp_ns
        return round((stamp_ns - self._start_ns) * 1e-9, 6)

    def _read_description(self, cdr: bytes) -> None:
        try:
            text = unpack_string(cdr)
            self._configuration = configuration_from_yaml(text, self._descriptions.name)
        except RigError as error:
            self.get_logger().error(f'{error}; keeping what was known')

    def _ask_supply_pressure(self, pressure: float) -> None:
        if not self._supply.service_is_ready():
            self._told = f'there is no {self._supply.srv_name}: the supply cannot be set'
            return
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=pressure)
        request = SetParameters.Request(
            parameters=[ParameterMessage(name='supply_pressure', value=value)]
        )
        self._supply.call_async(request).add_done_callback(self._on_supply_pressure)

    def _on_supply_pressure(self, future: Future) -> None:
        answer = future.result()
        result = answer.results[0] if answer and answer.results else None
        self._told = '' if result and result.successful else f'supply: {result and result.reason}'

    def _ask_reset(self) -> None:
        if self._reset.service_is_ready():
            self._reset.call_async(Trigger.Request())
            self._told = ''
        else:
            self._told = f'there is no {self._reset.srv_name}'

    def close(self) -> None:
        """Leave the valves shut if they were commanded from here."""
        self._wanted = None
        self._drive()

    def report(self) -> Report:
        """Return rate and command for `/diagnostics`."""
        self._per_second = self._rate.per_second()
        values: dict[str, object] = {
            'rate [Hz]': f'{self._per_second:.2f}',
            'u held [V]': self._wanted,
            'incomplete samples': self._joiner.dropped,
        }
        waiting = self._start_ns is None
        return Report(DiagnosticStatus.OK, 'waiting for samples' if waiting else 'running', values)


def _finite(value: float) -> float | None:
    return value if abs(value) < float('inf') else None


@contextmanager
def watch(namespace: str = '') -> Iterator[tuple[LiveNode, Callable[[Callable[[], bool]], None]]]:
    """
    Run a live node from a program; yield the node, and what runs it as long as it is told to.

    :param namespace: of the rig
    :raises RigError: when the namespace is none
    """
    if not re.fullmatch(r'(/?[A-Za-z_]\w*)*', namespace):
        raise RigError(f'namespace {namespace!r}: allowed are names such as left or lab/left')
    context = Context()
    remap = ['--ros-args', '-r', f'__ns:=/{namespace.strip("/")}'] if namespace else []
    rclpy.init(args=remap, context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = LiveNode(context)
        loop = Runner([node])
        try:
            yield node, loop.run
        finally:
            loop.close()
    finally:
        context.try_shutdown()
