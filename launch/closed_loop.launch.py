"""
The rig with a position controller that follows a profile; also takes those of rig.launch.py.

    ros2 launch pneu_rig_ros closed_loop.launch.py law:=sliding_mode profile:=reference_steps
    ros2 launch pneu_rig_ros closed_loop.launch.py compensation:=false cylinder:=cylinder_1
"""

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from pneu_rig_ros.nodes.launching import described, ended_unless_killed, typed

PACKAGE = 'pneu_rig_ros'
ARGUMENTS = {
    'law': ('pid', 'pid or sliding_mode'),
    'compensation': ('true', 'whether friction and valve overlap are compensated'),
    'profile': ('reference_steps', 'profile that drives reference; empty: subscribe to reference'),
    'setpoint': ('0.1', 'initial position reference [m]'),
    'namespace': ('', 'namespace of the rig'),
    'use_sim_time': ('false', 'whether the plant publishes /clock and all nodes follow it'),
}


def generate_launch_description() -> LaunchDescription:
    """Return the rig and the controller."""
    rig = PathJoinSubstitution([FindPackageShare(PACKAGE), 'launch', 'rig.launch.py'])
    parameters = typed(law=str, compensation=bool, profile=str, setpoint=float, use_sim_time=bool)
    return described(
        ARGUMENTS,
        IncludeLaunchDescription(rig),
        Node(
            package=PACKAGE,
            executable='position_controller',
            name='position_controller',
            namespace=LaunchConfiguration('namespace'),
            parameters=[parameters],
            output='screen',
            respawn=True,
            respawn_delay=1.0,
            on_exit=ended_unless_killed,
        ),
    )
