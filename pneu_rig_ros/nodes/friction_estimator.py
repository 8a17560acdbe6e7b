"""The friction estimator node: Eq. 2 live, a stated delay behind the samples."""

import math
from collections.abc import Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context

from pneu_rig_ros.analysis.friction import CausalFriction, ForceBalance
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.joining import Joiner, position_reading, pressure_reading
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.records.cdr import FrictionMessage, unpack_string
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml, load_configuration


class FrictionEstimatorNode(RigNode):
    """
    Publishes the friction force of Eq. 2 with the stamp of the sample that it belongs to.

    Mass, areas and atmosphere are those of `rig_description`; on a rig without it, those of the
    parameters. A missing sample starts the filter anew: a force is never made of a torn record.
    """

    period_ns = 5_000_000

    PARAMETERS = (
        Parameter(
            'cylinder',
            '',
            'cylinder, name or YAML file, of a rig without rig_description; '
            'empty: wait for rig_description',
        ),
        Parameter(
            'load_mass', 0.0, 'external load of a rig without rig_description', 'kg', 0, 1e4
        ),
    )

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('friction_estimator', context, overrides)
        self._publish = self.outlet('friction').publish
        self._descriptions = self.inlet('rig_description')
        self._joints = self.inlet('joint_states')
        self._chambers = [self.inlet(f'chamber_{i}/pressure') for i in (1, 2)]
        self._joiner = Joiner(3)
        self._message = FrictionMessage()
        self._filter: CausalFriction | None = None
        self._interval_ns = 0
        self._last_ns = 0
        self._restarts = 0
        self._rate = Rate()
        if self.text('cylinder'):
            mass = self.number('load_mass')
            self._configure(load_configuration(self.text('cylinder'), load_mass=mass))

    def work(self) -> None:
        """Estimate the friction of all complete samples."""
        for cdr in self._descriptions.take_all():
            self._read_description(cdr)
        if self._filter is None or not self.ready():
            return
        self._take()
        for stamp_ns, (position, pressure_1, pressure_2) in self._joiner.joined():
            self._estimate(self._filter, stamp_ns, position, pressure_1, pressure_2)

    def _take(self) -> None:
        positions, *pressures = self._joiner.queues
        positions.extend(self.heard(self._joints, position_reading))
        for queue, chamber in zip(pressures, self._chambers, strict=True):
            queue.extend(self.heard(chamber, pressure_reading))

    def _estimate(
        self, causal: CausalFriction, stamp_ns: int, position: float, p1: float, p2: float
    ) -> None:
        if stamp_ns - self._last_ns != self._interval_ns:
            causal.reset()
            self._restarts += 1
        self._last_ns = stamp_ns
        force = causal.push(position, p1, p2)
        if force is not None and math.isfinite(force):
            belongs_to = stamp_ns - causal.delay_samples * self._interval_ns
            self._publish(self._message.pack(force, belongs_to))
            self._rate.count += 1

    def _read_description(self, cdr: bytes) -> None:
        try:
            self._configure(configuration_from_yaml(unpack_string(cdr), self._descriptions.name))
        except RigError as error:
            self.get_logger().error(f'{error}; keeping what was known')

    def _configure(self, configuration: RigConfiguration) -> None:
        self._interval_ns = configuration.interval_ns
        balance = ForceBalance.of(configuration)
        self._filter = CausalFriction(balance, configuration.interval_ns * 1e-9)

    def close(self) -> None:
        """Estimate what has arrived since the last turn."""
        self.work()

    def report(self) -> Report:
        """Return rate, delay and restarts of the filter for `/diagnostics`."""
        delay_ns = self._filter.delay_samples * self._interval_ns if self._filter else 0
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'published': self._rate.count,
            'delay [ms]': delay_ns * 1e-6,
            'filter starts': self._restarts,
            'incomplete samples': self._joiner.dropped,
        }
        waiting = self._filter is None
        level = DiagnosticStatus.WARN if waiting else DiagnosticStatus.OK
        return Report(level, 'waiting for rig_description' if waiting else 'running', values)


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([FrictionEstimatorNode])


if __name__ == '__main__':
    raise SystemExit(main())
