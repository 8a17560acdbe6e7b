"""The friction estimator node: Eq. 2 in real time, with the constant delay of its filter."""

import math
from functools import partial

from pneu_rig_ros.analysis.friction import CausalFriction, ForceBalance
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.managed_node import ManagedNode
from pneu_rig_ros.nodes.rig_node import Parameter
from pneu_rig_ros.nodes.samples import SampleSubscription
from pneu_rig_ros.records.cdr_encoding import template
from pneu_rig_ros.rig import RigConfiguration, load_configuration


class FrictionEstimatorNode(ManagedNode):
    """
    Publishes the friction force of Eq. 2 with the stamp of its sample.

    Mass, areas and atmospheric pressure come from `rig_description`, or from the parameters on a
    rig without it. After a missing sample the filter restarts, so that no force spans a gap.
    """

    NAME = 'friction_estimator'
    period_ns = 5_000_000

    PARAMETERS = (
        Parameter('cylinder', '', 'name or YAML file; empty: wait for rig_description'),
        Parameter('load_mass', 0.0, 'external load, if cylinder is given', 'kg', 0.0, 1e4),
    )

    def set_up(self) -> None:
        """Create publisher and subscriptions; read the cylinder, if one is given."""
        self._publish = self.add_publisher('friction').publish
        self._descriptions = self.subscribe('rig_description')
        self._samples = SampleSubscription(self)
        self._message = template('friction', self.frame_prefix)
        self._filter: CausalFriction | None = None
        self._interval_ns = 0
        self._last_ns = 0
        self._restarts = 0
        if cylinder := self.text('cylinder'):
            self._configure(load_configuration(cylinder, load_mass=self.number('load_mass')))

    def _configure(self, configuration: RigConfiguration) -> None:
        self._interval_ns = configuration.interval_ns
        balance = ForceBalance.of(configuration)
        self._filter = CausalFriction(balance, configuration.interval_ns * 1e-9)

    def update(self) -> None:
        """Estimate the friction of all complete samples."""
        self.take_configurations(self._descriptions, self._configure)
        if self._filter is None or not self.ready():
            return
        for sample in self._samples.take_all():
            if sample.stamp_ns - self._last_ns != self._interval_ns:
                self._filter.reset()
                self._restarts += 1
            self._last_ns = sample.stamp_ns
            force = self._filter.push(sample.position, sample.pressure_1, sample.pressure_2)
            if force is not None and math.isfinite(force):
                stamp_ns = sample.stamp_ns - self._filter.delay_samples * self._interval_ns
                self._publish(self._message.at(stamp_ns, force))
                self.rate.count += 1

    def start(self) -> None:
        """Restart the filter with the next sample."""
        self._last_ns = 0

    def stop(self) -> None:
        """Estimate the friction of the samples since the last update."""
        self.update()

    def status(self) -> NodeStatus:
        """Return delay and restarts of the filter for `/diagnostics`."""
        delay_ns = self._filter.delay_samples * self._interval_ns if self._filter else 0
        values: dict[str, object] = {
            'published': self.rate.count,
            'delay [ms]': delay_ns * 1e-6,
            'filter starts': self._restarts,
            'incomplete samples': self._samples.dropped,
        }
        if self._filter is None:
            return NodeStatus('', values, ('waiting for rig_description',))
        return NodeStatus('running', values, (self._samples.off_grid(self._interval_ns),))


main = partial(runner.main, [FrictionEstimatorNode])

if __name__ == '__main__':
    raise SystemExit(main())
