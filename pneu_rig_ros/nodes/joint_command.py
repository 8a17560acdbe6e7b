"""The joint command node: `u` from the commands of ros2_control."""

import math
from functools import partial

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.rig_node import Parameter, RigNode
from pneu_rig_ros.records.cdr_decoding import JointReading, unpack_joint_command
from pneu_rig_ros.records.cdr_encoding import pack_float64


class JointCommandNode(RigNode):
    """
    Publishes `u` [V] for each message on `joint_commands`.

    u = velocity_scale * velocity + effort_scale * effort of joint `piston`. A field that is empty
    or NaN does not count: an interface that no controller has claimed is NaN. A message with
    neither is not a command, so that the valves close after the `command_timeout` of
    valve_command. A position alone is refused: no law here would follow it.
    """

    NAME = 'joint_command'
    PARAMETERS = (
        Parameter('velocity_scale', 3.0, 'u per velocity', 'V*s/m', -1e3, 1e3, read_only=False),
        Parameter('effort_scale', 0.01, 'u per effort', 'V/N', -1e3, 1e3, read_only=False),
    )

    def set_up(self) -> None:
        """Create publisher and subscription."""
        self._publish = self.add_publisher('u').publish
        self._commands = self.subscribe('joint_commands')
        self._idle = 0

    def update(self) -> None:
        """Answer every waiting command."""
        if not self.ready():
            return
        for cdr in self._commands.take_all():
            with self.skip_invalid(self._commands):
                self._answer(unpack_joint_command(cdr))

    def _answer(self, command: JointReading) -> None:
        scaled = {
            'velocity': self.number('velocity_scale') * command.velocity,
            'effort': self.number('effort_scale') * command.effort,
        }
        given = {name: u for name, u in scaled.items() if not math.isnan(u)}
        u = sum(given.values())
        if not math.isfinite(u):
            raise RigError(f'{" and ".join(given)} not finite')
        if given:
            self._publish(pack_float64(u))
            self.rate.count += 1
        elif math.isfinite(command.position):
            raise RigError('a position only, allowed are velocity and effort')
        else:
            self._idle += 1

    def status(self) -> NodeStatus:
        """Return the number of commands for `/diagnostics`."""
        values = {'published': self.rate.count, 'messages without a command': self._idle}
        return NodeStatus('running' if self.rate.count else 'waiting', values)


main = partial(runner.main, [JointCommandNode])

if __name__ == '__main__':
    raise SystemExit(main())
