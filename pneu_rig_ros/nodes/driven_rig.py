"""The rig and its excitation in one process, which ends when the profile has been played."""

from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode


class ProfileOnce(ExcitationNode):
    """Ends the process when the profile has been played."""

    def work(self) -> None:
        """Answer the samples that wait."""
        super().work()
        self.done = self.played


NODES = (PlantNode, ProfileOnce, ValveCommandNode, FrictionEstimatorNode, RecorderNode)
"""In the order of their messages, so that lock step goes on without waiting."""


def main() -> int:
    """Run the nodes until the end of the profile, or Ctrl-C; return the exit code."""
    return runner.main(NODES)


if __name__ == '__main__':
    raise SystemExit(main())
