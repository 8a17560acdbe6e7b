"""
Bring up the rig: plant, valve command, friction estimator and recorder.

    ros2 launch pneu_rig_ros rig.launch.py cylinder:=cylinder_3 load_mass:=5.0
    ros2 launch pneu_rig_ros rig.launch.py namespace:=left record:=false
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
    SetEnvironmentVariable,
    Shutdown,
)
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = 'pneu_rig_ros'
ARGUMENTS = {
    'cylinder': ('cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    'friction': ('', "friction model; the cylinder's when empty"),
    'supply_pressure': ('', "absolute supply pressure [Pa]; the cylinder's when empty"),
    'load_mass': ('', "external load [kg]; the cylinder's when empty"),
    'speed': ('1.0', 'simulated over real time, 0 for lock step; needs use_sim_time if not 1'),
    'use_sim_time': ('false', 'whether the plant publishes /clock and all follow it'),
    'record': ('true', 'whether to record every topic'),
    'output': ('', 'directory of the bag; runs/ and the date when empty'),
    'namespace': ('', 'namespace of the rig, so that several run side by side'),
}


def rig_node(executable: str, parameters: dict[str, object], **options: object) -> Node:
    """Return a node of the rig, named like its executable, in the rig's namespace and time."""
    use_sim_time = ParameterValue(LaunchConfiguration('use_sim_time'), value_type=bool)
    return Node(
        package=PACKAGE,
        executable=executable,
        name=executable,
        namespace=LaunchConfiguration('namespace'),
        parameters=[{'use_sim_time': use_sim_time, **parameters}],
        output='screen',
        **options,
    )


def plant(context: LaunchContext) -> list[Node]:
    """Return the plant with those of the cylinder's own values replaced that were given."""
    names = ('supply_pressure', 'load_mass')
    given = {name: LaunchConfiguration(name).perform(context) for name in names}
    recorded = IfCondition(LaunchConfiguration('record')).evaluate(context)
    parameters = {
        'cylinder': ParameterValue(LaunchConfiguration('cylinder'), value_type=str),
        'friction': ParameterValue(LaunchConfiguration('friction'), value_type=str),
        'speed': ParameterValue(LaunchConfiguration('speed'), value_type=float),
        'wait_for_subscribers': int(recorded),  # so that the bag has the first sample
        **{name: float(value) for name, value in given.items() if value},
    }
    return [rig_node('plant', parameters, on_exit=Shutdown())]


def generate_launch_description() -> LaunchDescription:
    """Return the four nodes and what may be said of them on the command line."""
    profiles = PathJoinSubstitution([FindPackageShare(PACKAGE), 'config', 'fastdds.xml'])
    output = ParameterValue(LaunchConfiguration('output'), value_type=str)
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            SetEnvironmentVariable('FASTRTPS_DEFAULT_PROFILES_FILE', profiles),
            SetEnvironmentVariable('FASTDDS_DEFAULT_PROFILES_FILE', profiles),  # since Kilted
            OpaqueFunction(function=plant),
            rig_node('valve_command', {}),
            rig_node('friction_estimator', {}),
            rig_node(
                'recorder',
                {'output': output},
                condition=IfCondition(LaunchConfiguration('record')),
            ),
        ]
    )
