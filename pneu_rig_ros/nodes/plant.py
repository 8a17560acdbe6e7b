"""The plant node: the emulated rig, sampled at exact intervals."""

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import cast

from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter as RosParameter
from std_srvs.srv import SetBool, Trigger

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import FRICTION_MODELS
from pneu_rig_ros.model.quantity import LARGEST_INTEGER, Quantity, specifications
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.managed_node import ManagedNode
from pneu_rig_ros.nodes.rig_node import Parameter
from pneu_rig_ros.nodes.timing import LoopTimer, PeriodicTimer, TickErrors, WallClock
from pneu_rig_ros.records.cdr_decoding import unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import PlantMessages, pack_string
from pneu_rig_ros.records.description import describe
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.configuration import OVERRIDES, Sampling
from pneu_rig_ros.rig.urdf import robot_description
from pneu_rig_ros.rig.valve_drive import valve_voltages

LATE_SHARE = 0.01
"""Share of late ticks [-] above which diagnostics warn."""

RUNTIME = ('supply_pressure', 'load_mass')
"""Quantities that may change while the rig runs."""

DESCRIPTIONS = {'rig_description': describe, 'robot_description': robot_description}


def quantity_parameters(cylinder: RigConfiguration) -> Iterator[Parameter]:
    """Yield the parameters whose defaults come from a cylinder."""
    operation = cylinder.model.operation
    for name, one in OVERRIDES.items():
        yield Parameter.of(name, one, float(getattr(operation, name)), name not in RUNTIME)


class PlantNode(ManagedNode):
    """
    Publishes the sensor readings of the rig and receives the valve voltages.

    At each tick the prepared sample is published first; then the newest voltages are held for one
    interval and the next sample is computed, so that computation does not delay publication.
    The stamp of tick k is start + k intervals; in simulated time start is 0 and the plant is the
    clock. In lock step (speed 0) sample k waits for exactly one answer on `valve_voltages`.
    """

    NAME = 'plant'
    PARAMETERS = (
        Parameter('cylinder', 'cylinder_2', 'name of a shipped cylinder, or a YAML file'),
        Parameter(
            'friction',
            '',
            'friction model; empty: that of the cylinder',
            choices=('', *FRICTION_MODELS),
        ),
        Parameter(
            'sensors', '', 'of the readings; empty: of the cylinder', choices=('', 'rig', 'ideal')
        ),
        Parameter(
            'seed',
            -1,
            'seed of the noise and the gains of the sensors; -1: of the cylinder',
            '-',
            -1,
            LARGEST_INTEGER,
        ),
        Parameter(
            'interval_ns',
            0,
            'sampling interval; 0: that of the cylinder',
            'ns',
            0,
            10**9,
            constraint='0, or at least 100000',
        ),
        Parameter(
            'speed',
            1.0,
            'simulated over real time; 0: lock step',
            '-',
            0.0,
            1000.0,
            constraint='0, or at least 0.001; other than 1 with use_sim_time only',
        ),
        Parameter('paused', False, 'whether to start paused; ~/pause changes it'),
    )

    def dependent_parameters(self) -> Iterator[Parameter]:
        """Return the quantities, whose defaults come from the cylinder."""
        return quantity_parameters(load_configuration(self.text('cylinder')))

    def set_up(self) -> None:
        """Read the cylinder, compile, create publishers, subscription and services."""
        self._rig = Rig(self._configuration())
        self._rig.warm_up()
        self.interval_ns = self._rig.configuration.interval_ns
        self.period_ns = self._checked_period_ns()
        self._paused = self.flag('paused')
        self._messages = PlantMessages(
            self._rig.sensors.pressure_variance, self.frame_prefix, self.simulated_time
        )
        topics = (*DESCRIPTIONS, *self._messages.pack(self._rig.sample, 0))
        self._publish = {topic: self.add_publisher(topic).publish for topic in topics}
        self._commands = self.subscribe('valve_voltages')
        self.add_service(Trigger, '~/reset', self._on_reset)
        self.add_service(SetBool, '~/pause', self._on_pause)
        self._described = False
        self._awaiting = False
        self._tick = 0
        self._saturated = 0
        self._timer = PeriodicTimer(self.period_ns) if self.period_ns else None

    def start(self) -> None:
        """Go on where the rig is, valves shut; the clock starts with the next tick."""
        self._voltages = valve_voltages(0.0)
        self._start_ns: int | None = None
        self._late_before = 0
        self._wall_clock = WallClock()
        self._await_nothing()
        if not self.simulated_time:
            self._tick = 0
        self._prepare()

    def _await_nothing(self) -> None:
        """Give up the answer to the last sample; the next one has the next stamp."""
        if self._awaiting:
            self._awaiting = False
            self._tick += 1

    def _configuration(self) -> RigConfiguration:
        """Return the configuration of the declared parameters; RigError if it is not valid."""
        seed = int(self.number('seed'))
        configuration = load_configuration(
            self.text('cylinder'),
            seed=None if seed < 0 else seed,
            sensors=self.text('sensors') or None,
            friction=self.text('friction') or None,
            **{name: self.number(name) for name in OVERRIDES},
        )
        interval_ns = int(self.number('interval_ns')) or configuration.interval_ns
        cast(Quantity, specifications(Sampling)['interval']).check(interval_ns, 'interval_ns')
        return replace(configuration, interval_ns=interval_ns)

    def _checked_period_ns(self) -> int:
        """Return the period of the loop, 0 in lock step; RigError if the speed is not allowed."""
        speed = self.number('speed')
        if speed != 1.0 and not self.simulated_time:
            raise RigError(
                f'plant: speed {speed:g} needs simulated time; set use_sim_time to true, '
                'or speed to 1'
            )
        if 0.0 < speed < 1e-3:
            raise RigError(f'plant: speed {speed:g}, allowed 0 (lock step) or 0.001 to 1000')
        return max(round(self.interval_ns / speed), 1) if speed else 0

    def loop_timer(self) -> LoopTimer:
        """Return the timer of the sampling interval; in lock step wait for voltages."""
        return self._timer or super().loop_timer()

    def update(self) -> None:
        """Do one tick; in lock step only after the answer to the last sample."""
        if not self._described:
            self._describe()
        if self._awaiting:
            answer = self._commands.take()
            if answer is None:
                return
            self._accept(answer)
            self._awaiting = False
            self._advance()
        if self._paused or not self.ready():
            # Wall time goes on, simulated time stands still.
            if self._start_ns is not None and not self.simulated_time:
                self._tick += 1
                self._prepare()
            return
        if self._start_ns is None:
            self._begin()
        for topic, cdr in self._ready_messages.items():
            self._publish[topic](cdr)
        self.rate.count += 1
        if self._timer:
            for cdr in list(self._commands.take_all())[-1:]:
                self._accept(cdr)
            self._advance()
        else:
            self._awaiting = True

    def _begin(self) -> None:
        """Set the stamp of tick 0 and restart the tick errors."""
        self._late_before = 0
        self._wall_clock = WallClock()
        if self.simulated_time:
            self._start_ns = 0
        else:
            # Wait for a multiple of the interval, so that the stamps of all starts share a grid.
            now = self.get_clock().now().nanoseconds
            remaining = -now % self.interval_ns
            time.sleep(remaining * 1e-9)
            self._start_ns = int(now + remaining)
        if self._timer:
            self._timer.restart(time.monotonic_ns())
        self._prepare()

    def _prepare(self) -> None:
        """Pack the present sample with the stamp of the present tick."""
        stamp_ns = (self._start_ns or 0) + self._tick * self.interval_ns
        self._ready_messages = self._messages.pack(self._rig.sample, stamp_ns)

    def _advance(self) -> None:
        """Hold the voltages for one interval."""
        self._rig.step(*self._voltages)
        self._saturated += self._rig.sensors.saturated
        self._tick += 1
        self._prepare()

    def _accept(self, cdr: bytes) -> None:
        """Apply the voltages of a message; keep the last ones if they are not valid."""
        with self.skip_invalid(self._commands, f'keeping {self._voltages}'):
            voltages = unpack_valve_voltages(cdr)
            if not all(map(math.isfinite, voltages)):
                raise RigError(f'{voltages} are not finite')
            self._voltages = voltages

    def _describe(self) -> None:
        """Publish both descriptions; not in the constructor, as a duplicate must not publish."""
        self._described = True
        for topic, text_of in DESCRIPTIONS.items():
            self._publish[topic](pack_string(text_of(self._rig.configuration)))

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Return to the initial state; time goes on."""
        self._rig.reset()
        self._voltages = valve_voltages(0.0)
        self._await_nothing()
        self._prepare()
        response.success = True
        response.message = 'initial state, noise restarted'
        return response

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._paused = request.data
        response.success = True
        response.message = 'paused' if self._paused else 'running'
        return response

    def on_parameters(self, changes: list[RosParameter]) -> SetParametersResult:
        """Apply changed parameters to the running rig and publish its new description."""
        result = super().on_parameters(changes)
        operation = {one.name: one.value for one in changes if one.name in RUNTIME}
        if result.successful and self.configured and operation:
            try:
                self._rig.change_operation(**operation)
            except RigError as error:
                return SetParametersResult(successful=False, reason=str(error))
            self._describe()
        return result

    def status(self) -> NodeStatus:
        """Return tick errors, late ticks and saturation for `/diagnostics`."""
        errors = self._timer.errors if self._timer else TickErrors()
        late, self._late_before = errors.late - self._late_before, errors.late
        saturated, self._saturated = self._saturated, 0
        values: dict[str, object] = {
            'published': self.rate.count,
            'late ticks': errors.late,
            'saturated samples in the last second': saturated,
            'paused': self._paused,
            'tick error p50 [ms]': f'{errors.percentile_ms(50):.3f}',
            'tick error p99 [ms]': f'{errors.percentile_ms(99):.3f}',
            'tick error max [ms]': f'{errors.max_ns * 1e-6:.3f}',
        }
        self._wall_clock.update()
        often = late > LATE_SHARE * self.rate.per_second
        warnings = (
            'sensor saturated' if saturated else None,
            f'{late} ticks late in the last second' if often else None,
            None if self.simulated_time else self._wall_clock.warning('stamps'),
        )
        return NodeStatus('paused' if self._paused else 'running', values, warnings)


main = partial(runner.main, [PlantNode])

if __name__ == '__main__':
    raise SystemExit(main())
