"""The shadow node: a model in parallel with a rig or a replayed bag, and their residuals."""

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rclpy.context import Context

from pneu_rig_ros.control.observer import (
    HORIZON,
    Measured,
    NoiseBand,
    Observer,
    Residual,
    Watch,
    residual,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.plant import PlantState
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus, RateCounter
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.sync import TimeSynchronizer, decode_position, decode_pressure
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
LONGEST_GAP = 20
"""Samples missing in a row after which the model waits for a rest."""


class ShadowNode(RigNode):
    """
    Publishes the prediction of each sample on `predicted/...`, its error on `residual/...`.

    The model gets the voltages (or commands) of the rig and is reset to the measurement at each
    rest, see `control.observer`. Supply pressure and load come from `rig_description`, if there is
    one. Diagnostics warn when a residual is outside the noise band for long.
    """

    period_ns = 5_000_000

    PARAMETERS = (
        Parameter('model', '', 'cylinder, name or YAML file; empty: from rig_description'),
        Parameter('input', VOLTAGES, 'topic that drives the model', choices=(VOLTAGES, COMMAND)),
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
            topic: self.advertise(topic).publish
            for topic in (f'{prefix}/{t}' for prefix in ('predicted', 'residual') for t in topics)
        }
        self._descriptions = self.subscribe('rig_description')
        self._inputs = self.subscribe(self.text('input'))
        self._joints, *self._chambers = [self.subscribe(topic) for topic in topics]
        self._synchronizer = TimeSynchronizer(3)
        self._velocities: dict[int, tuple[float, int]] = {}
        self._pending_inputs: deque[tuple[int, tuple[float, float]]] = deque()
        self._voltages = valve_voltages(0.0)
        self._observer: Observer | None = None
        self._last_ns = 0
        self._rate = RateCounter()
        self._refused = 0
        self._residual = Residual(0.0, 0.0, 0.0)
        if self.text('model'):
            self._start_model(load_configuration(self.text('model')))
        else:
            Observer(load_configuration('cylinder_2'))  # compile before the first sample

    def _start_model(self, configuration: RigConfiguration) -> None:
        """Start a model, its noise band and its alarm."""
        self._observer = Observer(configuration, self.number('horizon'))
        self._interval_ns = configuration.interval_ns
        self._band = NoiseBand(configuration.sensors, self.number('band'))
        window = self.number('alarm_window') * 1e9 / configuration.interval_ns
        self._alarm = Watch(max(1, round(window)))

    def update(self) -> None:
        """Predict all complete samples."""
        for cdr in self._descriptions.take_all():
            with self.skip_invalid(self._descriptions):
                self._use_description(
                    configuration_from_yaml(unpack_string(cdr), self._descriptions.name)
                )
        if self._observer is None or not self.ready():
            return
        self._take_samples()
        for stamp_ns, (position, p1, p2) in self._synchronizer.complete():
            velocity, sent_ns = self._velocities.pop(stamp_ns)
            self._apply_inputs_before(sent_ns)
            self._predict(self._observer, stamp_ns, Measured(position, p1, p2), velocity)
        self._velocities = {k: v for k, v in self._velocities.items() if k > self._last_ns}

    def _take_samples(self) -> None:
        for message in self._inputs.take_all_with_info():
            self._add_input(message.sent_ns, message.cdr)
        positions, *pressures = self._synchronizer.queues
        for message in self._joints.take_all_with_info():
            with self.skip_invalid(self._joints):
                positions.append(decode_position(message.cdr))
                reading = unpack_joint_state(message.cdr)
                self._velocities[reading.stamp_ns] = reading.velocity, message.sent_ns
        for queue, chamber in zip(pressures, self._chambers, strict=True):
            queue.extend(self.take_decoded(chamber, decode_pressure))

    def _add_input(self, sent_ns: int, cdr: bytes) -> None:
        """Add voltages, or those that follow from a command."""
        try:
            if self.text('input') == COMMAND:
                self._pending_inputs.append((sent_ns, valve_voltages(unpack_float64(cdr))))
            else:
                self._pending_inputs.append((sent_ns, unpack_valve_voltages(cdr)))
        except (RigError, ValueError) as error:
            self._refused += 1
            self.get_logger().warning(f'{error}, ignored', throttle_duration_sec=1.0)

    def _apply_inputs_before(self, sent_ns: int) -> None:
        """Apply the voltages that were sent before a sample, which therefore led to it."""
        while self._pending_inputs and self._pending_inputs[0][0] < sent_ns:
            self._voltages = self._pending_inputs.popleft()[1]

    def _predict(
        self, observer: Observer, stamp_ns: int, measured: Measured, velocity: float
    ) -> None:
        missing = (stamp_ns - self._last_ns) // self._interval_ns - 1
        self._last_ns = stamp_ns
        if missing > LONGEST_GAP or missing < 0:
            observer.reset()
        else:
            for _ in range(missing):
                observer.push(self._voltages, measured)
        predicted = observer.push(self._voltages, measured)
        if predicted is not None:
            self._publish_prediction(observer, stamp_ns, measured, velocity, predicted)

    def _publish_prediction(
        self, observer: Observer, stamp_ns: int, measured: Measured, velocity: float,
        predicted: PlantState,
    ) -> None:  # fmt: skip
        error = self._residual = residual(measured, predicted)
        x, _, p1, p2 = observer.origin
        self._alarm.note(self._band.outside(error, measured, Measured(x, p1, p2)))
        joint = predicted.position, predicted.velocity, predicted.friction_force
        pressures = predicted.pressure_1, predicted.pressure_2
        motion_error = error.position, velocity - predicted.velocity
        model, residuals = self._messages
        for topic, cdr in {
            **model.pack(stamp_ns, joint, pressures),
            **residuals.pack(stamp_ns, motion_error, error[1:]),
        }.items():
            self._publish[topic](cdr)
        self._rate.count += 1

    def _use_description(self, description: RigConfiguration) -> None:
        """Adopt the operating conditions of the rig, and its model if none is given."""
        if self._observer is None:
            self._start_model(description)
            return
        interval_ns = description.interval_ns
        if interval_ns != self._interval_ns:
            self._start_model(replace(self._observer.configuration, interval_ns=interval_ns))
        operation = description.model.operation
        self._observer.change_operation(
            supply_pressure=operation.supply_pressure, load_mass=operation.load_mass
        )

    def status(self) -> NodeStatus:
        """Return residuals and their shares outside the band for `/diagnostics`."""
        if self._observer is None:
            return NodeStatus('', {}, ('waiting for rig_description',))
        shares = self._alarm.shares()
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'model': self._observer.configuration.name,
            'restarts': self._observer.restarts,
            'refused messages': self._refused,
            'incomplete samples': self._synchronizer.dropped,
            **{f'{name} outside [%]': f'{100 * share:.1f}' for name, share in shares.items()},
            'position residual [mm]': f'{self._residual.position * 1e3:.3f}',
            'pressure_1 residual [Pa]': f'{self._residual.pressure_1:.0f}',
            'pressure_2 residual [Pa]': f'{self._residual.pressure_2:.0f}',
        }
        limit = self.number('alarm_share')
        outside = ', '.join(name for name, share in shares.items() if share > limit)
        alarm = f'model and rig disagree: {outside} outside the noise band' if outside else None
        state = 'running' if self._observer.running else 'waiting for a rest'
        return NodeStatus(state, values, (alarm,))


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([ShadowNode])


if __name__ == '__main__':
    raise SystemExit(main())
