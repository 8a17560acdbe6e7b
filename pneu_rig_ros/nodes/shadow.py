"""The shadow node: a model in parallel with a rig or a replayed bag, and their residuals."""

from collections import deque
from dataclasses import replace
from functools import partial

from pneu_rig_ros.control.observer import (
    HORIZON,
    Measured,
    NoiseBand,
    Observer,
    Watch,
    residual,
)
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.managed_node import ManagedNode
from pneu_rig_ros.nodes.rig_node import Parameter
from pneu_rig_ros.nodes.samples import Sample, SampleSubscription
from pneu_rig_ros.records.cdr_decoding import unpack_float64, unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import template
from pneu_rig_ros.records.topics import DERIVED, SAMPLE_TOPICS
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.valve_drive import checked_command, valve_voltages

VOLTAGES, COMMAND = 'valve_voltages', 'u'
LONGEST_GAP = 20
"""Samples missing in a row after which the model waits for a rest."""


class ShadowNode(ManagedNode):
    """
    Publishes the prediction of each sample on `predicted/...`, its error on `residual/...`.

    The model gets the voltages (or commands) of the rig and is reset to the measurement at each
    rest, see `control.observer`. Supply pressure and load come from `rig_description`, if there is
    one. Diagnostics warn when a residual is outside the noise band for long.
    """

    NAME = 'shadow'
    period_ns = 5_000_000

    PARAMETERS = (
        Parameter('model', '', 'cylinder, name or YAML file; empty: from rig_description'),
        Parameter('input', VOLTAGES, 'topic that drives the model', choices=(VOLTAGES, COMMAND)),
        Parameter('horizon', HORIZON, 'longest prediction without a rest', 's', 0.05, 3600.0),
        Parameter('band', 5.0, 'half width of the noise band in standard deviations', '-', 1, 1e3),
        Parameter('alarm_window', 5.0, 'time over which residuals are judged', 's', 0.1, 3600.0),
        Parameter('alarm_share', 0.5, 'fraction outside the band to warn at', '-', 0.0, 1.0),
    )

    def set_up(self) -> None:
        """Create publishers and subscriptions; load the model, or compile one."""
        topics = [f'{prefix}{name}' for prefix in DERIVED for name in SAMPLE_TOPICS]
        self._messages = {topic: template(topic, self.frame_prefix) for topic in topics}
        self._publish = {topic: self.add_publisher(topic).publish for topic in topics}
        self._descriptions = self.subscribe('rig_description')
        self._inputs = self.subscribe(self.text('input'))
        self._samples = SampleSubscription(self)
        self._pending_inputs: deque[tuple[int, tuple[float, float]]] = deque()
        self._observer: Observer | None = None
        self._last_ns = 0
        self._residual = Measured(0.0, 0.0, 0.0)
        if self.text('model'):
            self._start_model(load_configuration(self.text('model')))
        else:
            Observer(load_configuration('cylinder_2'))  # compile before the first sample

    def start(self) -> None:
        """Begin with the next rest, valves shut."""
        self._pending_inputs.clear()
        self._voltages = valve_voltages(0.0)
        if self._observer is not None:
            self._observer.reset()

    def _start_model(self, configuration: RigConfiguration) -> None:
        """Start a model, its noise band and its alarm."""
        self._observer = Observer(configuration, self.number('horizon'))
        self._interval_ns = configuration.interval_ns
        self._band = NoiseBand(configuration.sensors, self.number('band'))
        window = self.number('alarm_window') * 1e9 / configuration.interval_ns
        self._alarm = Watch(max(1, round(window)))

    def update(self) -> None:
        """Predict all complete samples."""
        self.take_configurations(self._descriptions, self._use_description)
        if self._observer is None or not self.ready():
            return
        by_command = self.text('input') == COMMAND
        for message in self._inputs.take_all_with_info():
            with self.skip_invalid(self._inputs):
                if by_command:
                    voltages = valve_voltages(checked_command(unpack_float64(message.cdr)))
                else:
                    voltages = unpack_valve_voltages(message.cdr)
                self._pending_inputs.append((message.sent_ns, voltages))
        for sample in self._samples.take_all():
            # The inputs that were sent before a sample led to it.
            while self._pending_inputs and self._pending_inputs[0][0] < sample.sent_ns:
                self._voltages = self._pending_inputs.popleft()[1]
            self._predict(self._observer, sample)

    def _predict(self, observer: Observer, sample: Sample) -> None:
        measured = Measured(sample.position, sample.pressure_1, sample.pressure_2)
        missing = (sample.stamp_ns - self._last_ns) // self._interval_ns - 1
        self._last_ns = sample.stamp_ns
        if missing > LONGEST_GAP or missing < 0:
            observer.reset()
        else:
            for _ in range(missing):
                observer.push(self._voltages, measured)
        predicted = observer.push(self._voltages, measured)
        if predicted is None:
            return
        error = self._residual = residual(measured, predicted)
        x, _, p1, p2 = observer.origin
        self._alarm.note(self._band.outside(error, measured, Measured(x, p1, p2)))
        motion = predicted.position, predicted.velocity, predicted.friction_force
        numbers = {
            'predicted/joint_states': motion,
            'predicted/chamber_1/pressure': (predicted.pressure_1,),
            'predicted/chamber_2/pressure': (predicted.pressure_2,),
            'residual/joint_states': (error.position, sample.velocity - predicted.velocity),
            'residual/chamber_1/pressure': (error.pressure_1,),
            'residual/chamber_2/pressure': (error.pressure_2,),
        }
        for topic, values in numbers.items():
            self._publish[topic](self._messages[topic].at(sample.stamp_ns, *values))
        self.rate.count += 1

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
            'model': self._observer.configuration.name,
            'restarts': self._observer.restarts,
            'incomplete samples': self._samples.dropped,
            **{f'{name} outside [%]': f'{100 * share:.1f}' for name, share in shares.items()},
            'position residual [mm]': f'{self._residual.position * 1e3:.3f}',
            'pressure_1 residual [Pa]': f'{self._residual.pressure_1:.0f}',
            'pressure_2 residual [Pa]': f'{self._residual.pressure_2:.0f}',
        }
        limit = self.number('alarm_share')
        outside = ', '.join(name for name, share in shares.items() if share > limit)
        alarm = f'model and rig disagree: {outside} outside the noise band' if outside else None
        state = 'running' if self._observer.running else 'waiting for a rest'
        return NodeStatus(state, values, (self._samples.off_grid(self._interval_ns), alarm))


main = partial(runner.main, [ShadowNode])

if __name__ == '__main__':
    raise SystemExit(main())
