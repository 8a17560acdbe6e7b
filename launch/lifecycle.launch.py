"""
Bring up the rig by its lifecycle: the plant is configured once the recorder is active.

    ros2 launch pneu_rig_ros lifecycle.launch.py cylinder:=cylinder_3 output:=runs/monday

So the bag has the first sample. Then `ros2 lifecycle set /plant deactivate`, and so on.
"""

from launch import LaunchContext, LaunchDescription
from launch.action import Action
from launch.actions import EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition

from pneu_rig_ros.nodes.launching import described, ended, typed

PACKAGE = 'pneu_rig_ros'
ARGUMENTS = {
    'cylinder': ('cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    'output': ('', 'directory of the bag; empty: runs/ and the date'),
    'namespace': ('', 'namespace of the rig, so that several run side by side'),
}
CONFIGURE, ACTIVATE = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE


def rig_node(executable: str, **parameters: object) -> LifecycleNode:
    """Return a node of the rig, named like its executable."""
    return LifecycleNode(
        package=PACKAGE,
        executable=executable,
        name=executable,
        namespace=LaunchConfiguration('namespace'),
        parameters=[parameters],
        output='screen',
        on_exit=ended,
    )


def change(node: LifecycleNode, transition: int) -> Action:
    """Return the request of a transition."""
    event = ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition)
    return EmitEvent(event=event)


def after(node: LifecycleNode, transition: str, state: str, then: Action) -> Action:
    """Return what does something once a transition of a node has led to a state."""
    handler = OnStateTransition(
        target_lifecycle_node=node, start_state=transition, goal_state=state, entities=[then]
    )
    return RegisterEventHandler(handler)


def refused(node: LifecycleNode) -> Action:
    """Return what ends the rig, with exit code 1, when a node refuses to be configured."""

    def end(_: LaunchContext) -> None:
        raise RuntimeError(f'{node.node_name} cannot be configured')

    return after(node, 'configuring', 'unconfigured', OpaqueFunction(function=end))


def rig() -> list[Action]:
    """Return the nodes and the order of their transitions."""
    recorder = rig_node('recorder', **typed(output=str), autostart=False)
    plant = rig_node('plant', **typed(cylinder=str), autostart=False, wait_for_subscribers=1)
    return [
        rig_node('valve_command'),
        rig_node('friction_estimator'),
        refused(recorder),
        refused(plant),
        after(recorder, 'configuring', 'inactive', change(recorder, ACTIVATE)),
        after(recorder, 'activating', 'active', change(plant, CONFIGURE)),
        after(plant, 'configuring', 'inactive', change(plant, ACTIVATE)),
        recorder,
        plant,
        change(recorder, CONFIGURE),
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the rig."""
    return described(ARGUMENTS, *rig())
