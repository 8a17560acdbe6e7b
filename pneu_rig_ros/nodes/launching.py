"""What the launch files share: the end of the rig with a node, and transforms for RViz."""

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext
from launch.action import Action
from launch.actions import LogInfo, Shutdown
from launch.events.process import ProcessExited
from launch_ros.actions import Node

TRANSFORMS = 'robot_state_publisher'
"""Package that publishes /tf from the robot description, and its node."""


def ended(event: ProcessExited, context: LaunchContext) -> list[Action]:
    """
    Shut down when a process has ended, unless all are ending.

    :raises RuntimeError: when it failed; `ros2 launch` then ends all, with exit code 1
    """
    if context.is_shutdown:
        return []
    if event.returncode:
        raise RuntimeError(f'{event.process_name} has ended with exit code {event.returncode}')
    return [Shutdown(reason=f'{event.process_name} has ended')]


def ended_unless_killed(event: ProcessExited, context: LaunchContext) -> list[Action]:
    """Shut down when a process has ended by itself; one that was killed is restarted."""
    return [] if event.returncode < 0 else ended(event, context)


def transforms_of(robot: str, namespace: str, **parameters: object) -> Action:
    """Return the publisher of /tf; frames have the namespace as a prefix."""
    try:
        get_package_prefix(TRANSFORMS)
    except PackageNotFoundError:
        return LogInfo(msg=f'no transforms: {TRANSFORMS} is not installed')
    prefix = f'{namespace}/' if namespace else ''
    return Node(
        package=TRANSFORMS,
        executable=TRANSFORMS,
        namespace=namespace,
        parameters=[{'robot_description': robot, 'frame_prefix': prefix, **parameters}],
        remappings=[('robot_description', '~/robot_description')],  # the rig has its own
    )
