"""
Play a bag back beside the friction estimator; everything ends with the bag.

    ros2 launch pneu_rig_ros replay.launch.py bag:=runs/BAG rate:=2.0
    ros2 launch pneu_rig_ros replay.launch.py bag:=runs/BAG exclude:=u namespace:=left
"""

from launch import LaunchContext, LaunchDescription
from launch.action import Action
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from pneu_rig_ros.nodes.launching import ended, transforms_of
from pneu_rig_ros.records.bag import last_text, open_bag

PACKAGE = 'pneu_rig_ros'
DISCOVERY = EnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', default_value='LOCALHOST')
"""Nodes are discovered on this host only, unless the environment says otherwise."""
ARGUMENTS = {
    'bag': (None, 'directory of the bag'),
    'rate': ('1.0', 'playback rate: recorded over playback time, 0.01 to 100'),
    'repeat': ('false', 'whether the bag is played in a loop'),
    'clock': ('false', 'whether /clock is published, from the log times'),
    'topics': ('', 'topics to play, comma-separated; empty: all that no node computes'),
    'exclude': ('', 'topics to exclude, comma-separated'),
    'delay': ('2.0', 'time for discovery before the start [s]'),
    'estimate': ('true', 'whether to run the friction estimator'),
    'namespace': ('', 'namespace to play into'),
    'transforms': ('true', 'whether to run robot_state_publisher, for RViz'),
}
TYPES = {
    'bag': str,
    'rate': float,
    'repeat': bool,
    'clock': bool,
    'topics': str,
    'exclude': str,
    'delay': float,
}


def transforms(context: LaunchContext) -> list[Action]:
    """Return the publisher of /tf, in the time of the player."""
    with open_bag(LaunchConfiguration('bag').perform(context)) as reader:
        robot = last_text(reader, 'robot_description')
    namespace = LaunchConfiguration('namespace').perform(context).strip('/')
    clock = ParameterValue(LaunchConfiguration('clock'), value_type=bool)
    return [transforms_of(robot, namespace, use_sim_time=clock)] if robot else []


def generate_launch_description() -> LaunchDescription:
    """Return the player and the estimator."""
    parameters = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, kind in TYPES.items()
    }
    common = {'package': PACKAGE, 'namespace': LaunchConfiguration('namespace')}
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            SetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', DISCOVERY),
            OpaqueFunction(  # first, as it reads the bag: what it raises orphans no process
                function=transforms,
                condition=IfCondition(LaunchConfiguration('transforms')),
            ),
            Node(
                executable='replay',
                name='replay',
                parameters=[parameters],
                output='screen',
                on_exit=ended,
                **common,
            ),
            Node(
                executable='friction_estimator',
                name='friction_estimator',
                output='screen',
                condition=IfCondition(LaunchConfiguration('estimate')),
                **common,
            ),
        ]
    )
