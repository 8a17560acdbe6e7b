"""
Run a model in parallel with a running rig or a bag; predictions can be recorded.

    ros2 launch pneu_rig_ros shadow.launch.py model:=improved.yaml
    ros2 launch pneu_rig_ros shadow.launch.py model:=improved.yaml bag:=runs/BAG record:=true
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from pneu_rig_ros.nodes.launching import described, ended, typed

PACKAGE = 'pneu_rig_ros'
ARGUMENTS = {
    'model': ('', 'cylinder, name or YAML file; empty: the configuration of the rig'),
    'input': ('valve_voltages', 'topic that drives the model: valve_voltages or u'),
    'horizon': ('1.0', 'longest prediction of a piston that does not come to rest [s]'),
    'band': ('5.0', 'half width of the noise band in standard deviations'),
    'bag': ('', 'bag to play; empty: a running rig'),
    'rate': ('1.0', 'playback rate: recorded over playback time'),
    'record': ('false', 'whether to record every topic'),
    'output': ('', 'directory of the bag; empty: runs/ and the date'),
    'namespace': ('', 'namespace of the rig'),
}


def player(context: LaunchContext) -> list[IncludeLaunchDescription]:
    """Return the player of the bag, if there is one."""
    bag = LaunchConfiguration('bag').perform(context)
    file = PathJoinSubstitution([FindPackageShare(PACKAGE), 'launch', 'replay.launch.py'])
    given = {name: LaunchConfiguration(name) for name in ('bag', 'rate', 'namespace')}
    return [IncludeLaunchDescription(file, launch_arguments=given.items())] if bag else []


def generate_launch_description() -> LaunchDescription:
    """Return the shadow, the recorder and the player."""
    common = {
        'package': PACKAGE,
        'namespace': LaunchConfiguration('namespace'),
        'output': 'screen',
        'on_exit': ended,
    }
    return described(
        ARGUMENTS,
        OpaqueFunction(function=player),  # first: what it raises orphans no process
        Node(
            executable='shadow',
            name='shadow',
            parameters=[typed(model=str, input=str, horizon=float, band=float)],
            **common,
        ),
        Node(
            executable='recorder',
            name='recorder',
            parameters=[typed(output=str)],
            condition=IfCondition(LaunchConfiguration('record')),
            **common,
        ),
    )
