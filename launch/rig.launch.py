"""
Bring up the rig: plant, valve command, friction estimator, recorder, and transforms for RViz.

    ros2 launch pneu_rig_ros rig.launch.py cylinder:=cylinder_3 load_mass:=5.0
    ros2 launch pneu_rig_ros rig.launch.py model:=improved.yaml supply_pressure:=7e5
    ros2 launch pneu_rig_ros rig.launch.py namespace:=left record:=false

A node that is killed is restarted; one that exits, e.g. at a wrong parameter, ends the rig.
"""

from launch import LaunchContext, LaunchDescription
from launch.action import Action
from launch.actions import OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.launching import described, ended_unless_killed, transforms_of, typed
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.urdf import robot_description

PACKAGE = 'pneu_rig_ros'
ARGUMENTS = {
    'cylinder': ('cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    'model': (
        '',
        'YAML file of a whole model, such as improved.yaml; replaces cylinder',
    ),
    'friction': ('', "friction law; empty: the cylinder's"),
    'supply_pressure': ('', "absolute supply pressure [Pa]; empty: the cylinder's"),
    'load_mass': ('', "external load [kg]; empty: the cylinder's"),
    'initial_position': ('', "position at the start [m]; empty: the cylinder's"),
    'speed': ('1.0', 'simulated over real time, 0 for lock step; needs use_sim_time if not 1'),
    'paused': ('false', 'whether the plant starts paused, for a controller in lock step; ~/pause'),
    'use_sim_time': ('false', 'whether the plant publishes /clock and all nodes follow it'),
    'record': ('true', 'whether to record every topic'),
    'output': ('', 'directory of the bag; empty: runs/ and the date'),
    'namespace': ('', 'namespace of the rig, so that several run side by side'),
    'transforms': ('true', 'whether to run robot_state_publisher, for RViz'),
}


def rig_node(executable: str, parameters: dict[str, object], **options: object) -> Node:
    """Return a node of the rig, named like its executable, in the rig's namespace and time."""
    return Node(
        package=PACKAGE,
        executable=executable,
        name=executable,
        namespace=LaunchConfiguration('namespace'),
        parameters=[{**typed(use_sim_time=bool), **parameters}],
        output='screen',
        respawn=True,
        respawn_delay=1.0,
        on_exit=ended_unless_killed,
        **options,
    )


def source(context: LaunchContext) -> str:
    """Return the model, or the cylinder if there is none."""
    model = LaunchConfiguration('model').perform(context)
    return model or LaunchConfiguration('cylinder').perform(context)


def given(context: LaunchContext) -> dict[str, float]:
    """Return the arguments that replace values of the cylinder."""
    names = ('supply_pressure', 'load_mass', 'initial_position')
    return {
        name: number(context, name) for name in names if LaunchConfiguration(name).perform(context)
    }


def number(context: LaunchContext, name: str) -> float:
    """Return an argument as a number; RigError if it is none."""
    text = LaunchConfiguration(name).perform(context)
    try:
        return float(text)
    except ValueError:
        raise RigError(f'argument {name}: {text!r} is not a number') from None


def plant(context: LaunchContext) -> list[Node]:
    """Return the plant."""
    recorded = IfCondition(LaunchConfiguration('record')).evaluate(context)
    parameters = {
        'cylinder': source(context),
        **typed(friction=str, speed=float, paused=bool),
        'wait_for_subscribers': int(recorded),  # so that the bag has the first sample
        **given(context),
    }
    return [rig_node('plant', parameters)]


def valve_command(context: LaunchContext) -> list[Node]:
    """Return the valve command; in lock step it waits for its controller."""
    lock_step = number(context, 'speed') == 0.0
    return [rig_node('valve_command', {'command_timeout': 0.0} if lock_step else {})]


def transforms(context: LaunchContext) -> list[Action]:
    """Return the publisher of /tf."""
    namespace = LaunchConfiguration('namespace').perform(context).strip('/')
    configuration = load_configuration(source(context), **given(context))
    return [transforms_of(robot_description(configuration), namespace)]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the nodes."""
    return described(
        ARGUMENTS,
        OpaqueFunction(  # first, as it reads the model: what it raises orphans no process
            function=transforms,
            condition=IfCondition(LaunchConfiguration('transforms')),
        ),
        OpaqueFunction(function=plant),
        OpaqueFunction(function=valve_command),
        rig_node('friction_estimator', {}),
        rig_node(
            'recorder',
            typed(output=str),
            condition=IfCondition(LaunchConfiguration('record')),
        ),
    )
