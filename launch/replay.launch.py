"""
Play a bag back beside the friction estimator; everything ends with the bag.

    ros2 launch pneu_rig_ros replay.launch.py bag:=runs/BAG rate:=2.0
    ros2 launch pneu_rig_ros replay.launch.py bag:=runs/BAG exclude:=u namespace:=left
"""

from launch import LaunchContext, LaunchDescription
from launch.action import Action
from launch.actions import OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from pneu_rig_ros.nodes.launching import described, ended, transforms_of, typed
from pneu_rig_ros.records.bag import last_text, open_bag

PACKAGE = 'pneu_rig_ros'
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


def transforms(context: LaunchContext) -> list[Action]:
    """Return the publisher of /tf, in the time of the player."""
    with open_bag(LaunchConfiguration('bag').perform(context)) as reader:
        robot = last_text(reader, 'robot_description')
    namespace = LaunchConfiguration('namespace').perform(context).strip('/')
    clock = typed(clock=bool)['clock']
    return [transforms_of(robot, namespace, use_sim_time=clock)] if robot else []


def generate_launch_description() -> LaunchDescription:
    """Return the player and the estimator."""
    parameters = typed(
        bag=str, rate=float, repeat=bool, clock=bool, topics=str, exclude=str, delay=float
    )
    common = {'package': PACKAGE, 'namespace': LaunchConfiguration('namespace')}
    return described(
        ARGUMENTS,
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
    )
