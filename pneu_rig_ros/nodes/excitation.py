"""The excitation node: plays a profile of commands or references, sample by sample."""

from collections.abc import Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context

from pneu_rig_ros.control.excitation import load_excitation
from pneu_rig_ros.nodes import parameters, runner
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.records.cdr import pack_float64, unpack_stamp


class ExcitationNode(RigNode):
    """
    Answers each sample with the level of an excitation, on `u` [V] or `reference` [m].

    Time is that of the samples, from the first one on: the same in lock step, in simulated and in
    real time. Afterwards the valves are shut, and a reference is kept.
    """

    PARAMETERS = (
        Parameter('profile', 'staircase', 'name of a shipped excitation, or a YAML file'),
        Parameter('repeat', False, 'whether it begins anew at its end'),
    )

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('excitation', context, overrides)
        self._excitation = load_excitation(self.text('profile'))
        self._repeat = parameters.switch(self, 'repeat')
        self._publish = self.outlet(self._excitation.drives).publish
        self._samples = self.inlet('joint_states')
        self._start_ns: int | None = None
        self._elapsed = 0.0
        self._rate = Rate()

    def work(self) -> None:
        """Answer the samples that wait."""
        if not self.ready():
            return
        for stamp_ns in self.heard(self._samples, unpack_stamp):
            if self._start_ns is None:
                self._start_ns = stamp_ns
            self._elapsed = (stamp_ns - self._start_ns) * 1e-9
            self._publish(pack_float64(self._excitation.level(self._phase())))
            self._rate.count += 1

    def _phase(self) -> float:
        """Return the time since the profile last began [s]."""
        return self._elapsed % self._excitation.duration if self._repeat else self._elapsed

    @property
    def played(self) -> bool:
        """Whether the end has been played."""
        return not self._repeat and self._elapsed >= self._excitation.duration

    def report(self) -> Report:
        """Return profile, progress and rate for `/diagnostics`."""
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'profile': self._excitation.name,
            'drives': self._excitation.drives,
            'elapsed [s]': f'{self._phase():.2f}',
            'duration [s]': f'{self._excitation.duration:g}',
        }
        waiting = 'waiting for joint_states' if self._start_ns is None else 'running'
        return Report(DiagnosticStatus.OK, 'finished' if self.played else waiting, values)


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([ExcitationNode])


if __name__ == '__main__':
    raise SystemExit(main())
