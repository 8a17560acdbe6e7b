"""What the launch files share: arguments, the end of the rig with a node, transforms for RViz."""

from collections.abc import Mapping

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription
from launch.action import Action
from launch.actions import DeclareLaunchArgument, LogInfo, SetEnvironmentVariable, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

DISCOVERY = EnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', default_value='LOCALHOST')
"""Nodes are discovered on this host only, unless the environment says otherwise."""

TRANSFORMS = 'robot_state_publisher'
"""Package that publishes /tf from the robot description, and its node."""


def described(
    arguments: Mapping[str, tuple[str | None, str]], *actions: Action
) -> LaunchDescription:
    """
    Return what a launch file does.

    :param arguments: name -> default and meaning; one whose default is None must be given
    """
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (default, meaning) in arguments.items()
            ),
            SetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', DISCOVERY),
            *actions,
        ]
    )


def typed(**kinds: type) -> dict[str, ParameterValue]:
    """Return parameters whose values are launch arguments of the same name."""
    return {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, kind in kinds.items()
    }


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
