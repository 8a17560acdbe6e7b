"""The shadow node: a model beside a real rig or a replayed bag, and where the two part."""

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context

from pneu_rig_ros.control.observer import HORIZON, Measured, Observer
from pneu_rig_ros.control.residual import NoiseBand, Residual, Watch, residual
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.plant import PlantState
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.joining import Joiner, position_reading, pressure_reading
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.records.cdr import (
    SampleMessages,
    unpack_float64,
    unpack_joint_state,
    unpack_string,
    unpack_valve_voltages,
)
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

VOLTAGES, COMMAND = 'valve_voltages', 'u'
MOST_MISSING = 20
"""Samples that may be missing in a row before the model waits for a rest."""


class ShadowNode(RigNode):
    """
    Publishes on `predicted/...` what a model says of each sample, on `residual/...` the rest.

    The model gets the voltages (or commands) of the rig and is brought back to the measurement
    at each rest, see `control.observer`. Supply pressure and load are those of `rig_description`,
    if there is one. Diagnostics warn when a residual has left the noise band for long.
    """

    period_ns = 5_000_000

    PARAMETERS = (
        Parameter('model', '', 'cylinder, name or YAML file; empty: that of rig_description'),
        Parameter('input', VOLTAGES, 'what drives the model', choices=(VOLTAGES, COMMAND)),
        Parameter(
            'horizon',
            HORIZON,
            'longest prediction of a piston that does not come to rest',
            's',
            0.05,
            3600.0,
        ),
        Parameter('band', 5.0, 'half width of the noise band in standard deviations', '-', 1, 1e3),
        Parameter('alarm_window', 5.0, 'time over which residuals are judged', 's', 0.1, 3600.0),
        Parameter(
            'alarm_share', 0.5, 'share of it outside the band that raises a warning', '-', 0.0, 1.0
        ),
    )

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('shadow', context, overrides)
        self._messages = [SampleMessages('predicted/', True), SampleMessages('residual/', False)]
        topics = ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure')
        self._publish = {
            topic: self.outlet(topic).publish
            for topic in (f'{prefix}/{t}' for prefix in ('predicted', 'residual') for t in topics)
        }
        self._descriptions = self.inlet('rig_description')
        self._inputs = self.inlet(self.text('input'))
        self._joints, *self._chambers = [self.inlet(topic) for topic in topics]
        self._joiner = Joiner(3)
        self._velocities: dict[int, tuple[float, int]] = {}
        self._commands: deque[tuple[int, tuple[float, float]]] = deque()
        self._voltages = valve_voltages(0.0)
        self._observer: Observer | None = None
        self._last_ns = 0
        self._rate = Rate()
        self._refused = 0
        self._left = Residual(0.0, 0.0, 0.0)
        if self.text('model'):
            self._shadow(load_configuration(self.text('model')))
        else:
            Observer(load_configuration('cylinder_2'))  # compiles before samples wait for it

    def _shadow(self, configuration: RigConfiguration) -> None:
        """Put the model beside the rig."""
        self._observer = Observer(configuration, self.number('horizon'))
        self._interval_ns = configuration.interval_ns
        self._band = NoiseBand(configuration.sensors, self.number('band'))
        window = self.number('alarm_window') * 1e9 / configuration.interval_ns
        self._watch = Watch(max(1, round(window)))

    def work(self) -> None:
        """Predict all complete samples."""
        for cdr in self._descriptions.take_all():
            self._read_description(cdr)
        if self._observer is None or not self.ready():
            return
        self._take()
        for stamp_ns, (position, p1, p2) in self._joiner.joined():
            velocity, sent_ns = self._velocities.pop(stamp_ns)
            self._use_commands_before(sent_ns)
            self._follow(self._observer, stamp_ns, Measured(position, p1, p2), velocity)
        self._velocities = {k: v for k, v in self._velocities.items() if k > self._last_ns}

    def _take(self) -> None:
        for arrival in self._inputs.arrivals():
            self._hear(arrival.sent_ns, arrival.cdr)
        positions, *pressures = self._joiner.queues
        for arrival in self._joints.arrivals():
            with self.refusing(self._joints):
                positions.append(position_reading(arrival.cdr))
                reading = unpack_joint_state(arrival.cdr)
                self._velocities[reading.stamp_ns] = reading.velocity, arrival.sent_ns
        for queue, chamber in zip(pressures, self._chambers, strict=True):
            queue.extend(self.heard(chamber, pressure_reading))

    def _hear(self, sent_ns: int, cdr: bytes) -> None:
        """Note voltages, or the command that they follow from."""
        try:
            if self.text('input') == COMMAND:
                self._commands.append((sent_ns, valve_voltages(unpack_float64(cdr))))
            else:
                self._commands.append((sent_ns, unpack_valve_voltages(cdr)))
        except (RigError, ValueError) as error:
            self._refused += 1
            self.get_logger().warning(f'{error}, left out', throttle_duration_sec=1.0)

    def _use_commands_before(self, sent_ns: int) -> None:
        """Take over the voltages that were sent before a sample, and so led to it."""
        while self._commands and self._commands[0][0] < sent_ns:
            self._voltages = self._commands.popleft()[1]

    def _follow(
        self, observer: Observer, stamp_ns: int, measured: Measured, velocity: float
    ) -> None:
        missing = (stamp_ns - self._last_ns) // self._interval_ns - 1
        self._last_ns = stamp_ns
        if missing > MOST_MISSING or missing < 0:
            observer.reset()
        else:
            for _ in range(missing):
                observer.push(self._voltages, measured)
        predicted = observer.push(self._voltages, measured)
        if predicted is not None:
            self._tell(observer, stamp_ns, measured, velocity, predicted)

    def _tell(
        self, observer: Observer, stamp_ns: int, measured: Measured, velocity: float,
        predicted: PlantState,
    ) -> None:  # fmt: skip
        left = self._left = residual(measured, predicted)
        x, _, p1, p2 = observer.origin
        self._watch.note(self._band.outside(left, measured, Measured(x, p1, p2)))
        joint = predicted.position, predicted.velocity, predicted.friction_force
        pressures = predicted.pressure_1, predicted.pressure_2
        off = left.position, velocity - predicted.velocity
        model, rest = self._messages
        for topic, cdr in {
            **model.pack(stamp_ns, joint, pressures),
            **rest.pack(stamp_ns, off, left[1:]),
        }.items():
            self._publish[topic](cdr)
        self._rate.count += 1

    def _read_description(self, cdr: bytes) -> None:
        """Take over the conditions of the rig, and the whole of it if there is no model yet."""
        try:
            described = configuration_from_yaml(unpack_string(cdr), self._descriptions.name)
            if self._observer is None:
                self._shadow(described)
            else:
                self._adopt(self._observer, described)
        except RigError as error:
            self.get_logger().error(f'{error}; keeping what was known')

    def _adopt(self, observer: Observer, described: RigConfiguration) -> None:
        if described.interval_ns != self._interval_ns:
            self._shadow(replace(observer.configuration, interval_ns=described.interval_ns))
        operation = described.model.operation
        assert self._observer is not None
        self._observer.change_operation(
            supply_pressure=operation.supply_pressure, load_mass=operation.load_mass
        )

    def report(self) -> Report:
        """Return residuals and their shares outside the band for `/diagnostics`."""
        if self._observer is None:
            return Report(DiagnosticStatus.WARN, 'waiting for rig_description', {})
        shares = self._watch.shares()
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'model': self._observer.configuration.name,
            'restarts': self._observer.restarts,
            'refused messages': self._refused,
            'incomplete samples': self._joiner.dropped,
            **{f'{name} outside [%]': f'{100 * share:.1f}' for name, share in shares.items()},
            'position residual [mm]': f'{self._left.position * 1e3:.3f}',
            'pressure_1 residual [Pa]': f'{self._left.pressure_1:.0f}',
            'pressure_2 residual [Pa]': f'{self._left.pressure_2:.0f}',
        }
        limit = self.number('alarm_share')
        parted = [name for name, share in shares.items() if share > limit]
        if parted:
            said = f'model and rig disagree: {", ".join(parted)} outside the noise band'
            return Report(DiagnosticStatus.WARN, said, values)
        running = self._observer.running
        return Report(DiagnosticStatus.OK, 'running' if running else 'waiting for a rest', values)


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([ShadowNode])


if __name__ == '__main__':
    raise SystemExit(main())
