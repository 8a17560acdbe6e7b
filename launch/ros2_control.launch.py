"""
Control the rig by ros2_control: a controller manager and controllers of ros2_controllers.

    ros2 launch pneu_rig_ros ros2_control.launch.py controller:=position_pid
    ros2 launch pneu_rig_ros ros2_control.launch.py emulated:=false namespace:=bench

Needs the packages controller_manager, ros2_controllers and joint_state_topic_hardware_interface.
With the emulated rig it also takes the arguments of rig.launch.py.
"""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from pneu_rig_ros.nodes.launching import described, typed
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.urdf import controlled_description

PACKAGE = 'pneu_rig_ros'
SHARE = FindPackageShare(PACKAGE)
ARGUMENTS = {
    'emulated': ('true', 'whether to start the emulated rig; false: a real one publishes'),
    'cylinder': ('cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    'namespace': ('rig', "of the rig's topics; not empty, as the broadcaster has joint_states"),
    'controller': ('velocity_command', 'controller to start: velocity_command or position_pid'),
    'controllers': ('', 'YAML file of the controllers; empty: config/ros2_control.yaml'),
    'use_sim_time': ('false', 'whether the plant publishes /clock and all nodes follow it'),
}


def control(context: LaunchContext) -> list[Node]:
    """Return the controller manager, and the publisher of the URDF that names its hardware."""
    cylinder, namespace, controllers = (
        LaunchConfiguration(name).perform(context)
        for name in ('cylinder', 'namespace', 'controllers')
    )
    text = controlled_description(load_configuration(cylinder), namespace)
    shipped = Path(SHARE.perform(context), 'config', 'ros2_control.yaml')
    return [
        node('robot_state_publisher', 'robot_state_publisher', {'robot_description': text}),
        node('controller_manager', 'ros2_control_node', controllers or str(shipped)),
    ]


def node(package: str, executable: str, *parameters: object, **options: object) -> Node:
    """Return a node in the time of the rig."""
    given = [typed(use_sim_time=bool), *parameters]
    return Node(
        package=package, executable=executable, parameters=given, output='screen', **options
    )


def generate_launch_description() -> LaunchDescription:
    """Return the rig, the translation of its commands, and ros2_control."""
    namespace = LaunchConfiguration('namespace')
    active = ['joint_state_broadcaster', LaunchConfiguration('controller')]
    return described(
        ARGUMENTS,
        OpaqueFunction(function=control),  # first: what it raises orphans no process
        IncludeLaunchDescription(
            PathJoinSubstitution([SHARE, 'launch', 'rig.launch.py']),
            launch_arguments={'transforms': 'false'}.items(),
            condition=IfCondition(LaunchConfiguration('emulated')),
        ),
        node(PACKAGE, 'joint_command', namespace=namespace, name='joint_command'),
        node('controller_manager', 'spawner', arguments=active),
    )
