"""The rig and an excitation in one process that ends with the profile, for experiments."""

from functools import partial

from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.timing import LoopTimer, MessageWaitSet
from pneu_rig_ros.nodes.valve_command import ValveCommandNode


class PlantWokenByLoop(PlantNode):
    """
    Wakes the process at each message between plant, excitation and valve command.

    On a busy computer a message may arrive after its node was updated; if only the answer to the
    plant woke the process, that message would wait for 20 ms.
    """

    def loop_timer(self) -> LoopTimer:
        """Return what waits for the messages of the loop."""
        loop = PlantNode, ExcitationNode, ValveCommandNode
        nodes = (node for node in self.process_nodes if isinstance(node, loop))
        return MessageWaitSet([s for n in nodes for s in n.polled_subscriptions], self.context)


class ProfileOnce(ExcitationNode):
    """Ends the process with the profile."""

    def update(self) -> None:
        """Answer the waiting samples."""
        super().update()
        self.done = self.played


NODES = (PlantWokenByLoop, ProfileOnce, ValveCommandNode, FrictionEstimatorNode, RecorderNode)
"""In the order of their messages, so that one update of all nodes is one lock step."""

main = partial(runner.main, NODES)

if __name__ == '__main__':
    raise SystemExit(main())
