"""The rig and an excitation in one process that ends with the profile, for experiments."""

from functools import partial

from pneu_rig_ros.nodes import rig, runner
from pneu_rig_ros.nodes.excitation import ExcitationNode


class ProfileOnce(ExcitationNode):
    """Ends the process with the profile."""

    def update(self) -> None:
        """Answer the waiting samples."""
        super().update()
        self.done = self.played


PLANT, *OTHERS = rig.NODES
NODES = (PLANT, ProfileOnce, *OTHERS)
"""In the order of their messages, so that one update of all nodes is one lock step."""

main = partial(runner.main, NODES)

if __name__ == '__main__':
    raise SystemExit(main())
