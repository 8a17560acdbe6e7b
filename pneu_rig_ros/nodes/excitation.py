"""The excitation node: publishes a profile of commands or references, sample by sample."""

from functools import partial

from pneu_rig_ros.control.excitation import load_excitation
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.rig_node import Parameter, RigNode
from pneu_rig_ros.nodes.samples import SampleClock
from pneu_rig_ros.records.cdr_decoding import unpack_stamp
from pneu_rig_ros.records.cdr_encoding import pack_float64


class ExcitationNode(RigNode):
    """
    Answers each sample with the level of an excitation, on `u` [V] or `reference` [m].

    Time is that of the samples, starting at the first one, also in lock step and in simulated
    time, and again where stamps jump back. After the profile a command is 0, and a reference keeps
    its last value.
    """

    NAME = 'excitation'
    PARAMETERS = (
        Parameter('profile', 'staircase', 'name of a shipped excitation, or a YAML file'),
        Parameter('repeat', False, 'whether the profile is repeated'),
    )

    def set_up(self) -> None:
        """Load the profile; create publisher and subscription."""
        self._excitation = load_excitation(self.text('profile'))
        self._repeat = self.flag('repeat')
        self._publish = self.add_publisher(self._excitation.drives).publish
        self._samples = self.subscribe('joint_states')
        self._sample_clock = SampleClock()

    def update(self) -> None:
        """Answer the waiting samples."""
        if not self.ready():
            return
        for stamp_ns in self.take_decoded(self._samples, unpack_stamp):
            self._sample_clock.update(stamp_ns)
            self._publish(pack_float64(self._excitation.level(self._phase())))
            self.rate.count += 1

    def _phase(self) -> float:
        """Return the time since the last start of the profile [s]."""
        elapsed = self._sample_clock.elapsed
        return elapsed % self._excitation.duration if self._repeat else elapsed

    @property
    def played(self) -> bool:
        """Whether the profile has ended."""
        return not self._repeat and self._sample_clock.elapsed >= self._excitation.duration

    def status(self) -> NodeStatus:
        """Return profile and progress for `/diagnostics`."""
        values: dict[str, object] = {
            'profile': self._excitation.name,
            'drives': self._excitation.drives,
            'elapsed [s]': f'{self._phase():.2f}',
            'duration [s]': f'{self._excitation.duration:g}',
        }
        running = 'running' if self._sample_clock.started else 'waiting for joint_states'
        return NodeStatus('finished' if self.played else running, values)


main = partial(runner.main, [ExcitationNode])

if __name__ == '__main__':
    raise SystemExit(main())
