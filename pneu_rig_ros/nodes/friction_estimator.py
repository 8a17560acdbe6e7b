"""The friction estimator node: Eq. 2 in real time, with the constant delay of its filter."""

import math
from collections.abc import Mapping
from typing import Any

from rclpy.context import Context

from pneu_rig_ros.analysis.friction import CausalFriction, ForceBalance
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus, RateCounter
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.sync import TimeSynchronizer, decode_position, decode_pressure
from pneu_rig_ros.records.cdr import FrictionMessage, unpack_string
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml, load_configuration


class FrictionEstimatorNode(RigNode):
    """
    Publishes the friction force of Eq. 2 with the stamp of its sample.

    Mass, areas and atmospheric pressure come from `rig_description`, or from the parameters on a
    rig without it. After a missing sample the filter restarts, so that no force spans a gap.
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
        self._publish = self.advertise('friction').publish
        self._descriptions = self.subscribe('rig_description')
        self._joints = self.subscribe('joint_states')
        self._chambers = [self.subscribe(f'chamber_{i}/pressure') for i in (1, 2)]
        self._synchronizer = TimeSynchronizer(3)
        self._message = FrictionMessage()
        self._filter: CausalFriction | None = None
        self._interval_ns = 0
        self._last_ns = 0
        self._restarts = 0
        self._rate = RateCounter()
        if self.text('cylinder'):
            mass = self.number('load_mass')
            self._configure(load_configuration(self.text('cylinder'), load_mass=mass))

    def update(self) -> None:
        """Estimate the friction of all complete samples."""
        for cdr in self._descriptions.take_all():
            with self.skip_invalid(self._descriptions):
                self._configure(
                    configuration_from_yaml(unpack_string(cdr), self._descriptions.name)
                )
        if self._filter is None or not self.ready():
            return
        self._take_samples()
        for stamp_ns, (position, pressure_1, pressure_2) in self._synchronizer.complete():
            self._estimate(self._filter, stamp_ns, position, pressure_1, pressure_2)

    def _take_samples(self) -> None:
        positions, *pressures = self._synchronizer.queues
        positions.extend(self.take_decoded(self._joints, decode_position))
        for queue, chamber in zip(pressures, self._chambers, strict=True):
            queue.extend(self.take_decoded(chamber, decode_pressure))

    def _estimate(
        self, causal: CausalFriction, stamp_ns: int, position: float, p1: float, p2: float
    ) -> None:
        if stamp_ns - self._last_ns != self._interval_ns:
            causal.reset()
            self._restarts += 1
        self._last_ns = stamp_ns
        force = causal.push(position, p1, p2)
        if force is not None and math.isfinite(force):
            sample_ns = stamp_ns - causal.delay_samples * self._interval_ns
            self._publish(self._message.pack(force, sample_ns))
            self._rate.count += 1

    def _configure(self, configuration: RigConfiguration) -> None:
        self._interval_ns = configuration.interval_ns
        balance = ForceBalance.of(configuration)
        self._filter = CausalFriction(balance, configuration.interval_ns * 1e-9)

    def close(self) -> None:
        """Estimate the friction of the samples since the last update."""
        self.update()

    def status(self) -> NodeStatus:
        """Return rate, delay and restarts of the filter for `/diagnostics`."""
        delay_ns = self._filter.delay_samples * self._interval_ns if self._filter else 0
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'published': self._rate.count,
            'delay [ms]': delay_ns * 1e-6,
            'filter starts': self._restarts,
            'incomplete samples': self._synchronizer.dropped,
        }
        warnings = () if self._filter else ('waiting for rig_description',)
        return NodeStatus('running', values, warnings)


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([FrictionEstimatorNode])


if __name__ == '__main__':
    raise SystemExit(main())
