"""The rig and its excitation in one process, which ends when the profile has been played."""

from collections.abc import Iterable

from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.pacing import Arrivals, Pace
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode


class LoopPlant(PlantNode):
    """
    Wakes the process at each message of the loop, not only at the answer to its own.

    On a busy machine a message may come after the turn in which its node looked for it; the next
    turn would be 20 ms later.
    """

    def expect(self, companions: Iterable[RigNode]) -> None:
        """Take note of the nodes in the same process."""
        nodes = list(companions)
        super().expect(nodes)
        loop = PlantNode, ExcitationNode, ValveCommandNode
        self._loop = [inlet for n in nodes if isinstance(n, loop) for inlet in n.inlets]

    def pace(self) -> Pace:
        """Return the pace of the loop."""
        return Arrivals(self._loop, self.context)


class ProfileOnce(ExcitationNode):
    """Ends the process when the profile has been played."""

    def work(self) -> None:
        """Answer the samples that wait."""
        super().work()
        self.done = self.played


NODES = (LoopPlant, ProfileOnce, ValveCommandNode, FrictionEstimatorNode, RecorderNode)
"""In the order of their messages, so that lock step goes on without waiting."""


def main() -> int:
    """Run the nodes until the end of the profile, or Ctrl-C; return the exit code."""
    return runner.main(NODES)


if __name__ == '__main__':
    raise SystemExit(main())
