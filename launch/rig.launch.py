"""
Bring up the rig: plant, valve command, friction estimator, recorder, and transforms for RViz.

    ros2 launch pneu_rig_ros rig.launch.py cylinder:=cylinder_3 load_mass:=5.0
    ros2 launch pneu_rig_ros rig.launch.py model:=improved.yaml supply_pressure:=7e5
    ros2 launch pneu_rig_ros rig.launch.py namespace:=left record:=false

A node that is killed comes back; one that ends by itself, e.g. at a wrong parameter, ends the rig.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
    SetEnvironmentVariable,
    Shutdown,
)
from launch.conditions import IfCondition
from launch.events.process import ProcessExited
from launch.substitutions import EnvironmentVariable, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.urdf import robot_description

PACKAGE = 'pneu_rig_ros'
DISCOVERY = EnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', default_value='LOCALHOST')
"""Nodes are discovered on this host only, unless the environment says otherwise."""
ARGUMENTS = {
    'cylinder': ('cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    'model': (
        '',
        'YAML file of a whole model, such as improved.yaml; takes the place of cylinder',
    ),
    'friction': ('', "friction law; the cylinder's when empty"),
    'supply_pressure': ('', "absolute supply pressure [Pa]; the cylinder's when empty"),
    'load_mass': ('', "external load [kg]; the cylinder's when empty"),
    'initial_position': ('', "position at the start [m]; the cylinder's when empty"),
    'speed': ('1.0', 'simulated over real time, 0 for lock step; needs use_sim_time if not 1'),
    'use_sim_time': ('false', 'whether the plant publishes /clock and all follow it'),
    'record': ('true', 'whether to record every topic'),
    'output': ('', 'directory of the bag; runs/ and the date when empty'),
    'namespace': ('', 'namespace of the rig, so that several run side by side'),
    'transforms': ('true', 'whether robot_state_publisher makes /tf of joint_states, for RViz'),
}


def ended(event: ProcessExited, _: LaunchContext) -> list[Shutdown]:
    """Return what happens when a node has ended: nothing if it was killed, as it comes back."""
    if event.returncode < 0:
        return []
    return [Shutdown(reason=f'{event.process_name} has ended')]


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
        respawn=True,
        respawn_delay=1.0,
        on_exit=ended,
        **options,
    )


def source(context: LaunchContext) -> str:
    """Return the model, or the cylinder if there is none."""
    model = LaunchConfiguration('model').perform(context)
    return model or LaunchConfiguration('cylinder').perform(context)


def given(context: LaunchContext) -> dict[str, float]:
    """Return those of the cylinder's own values that were given."""
    names = ('supply_pressure', 'load_mass', 'initial_position')
    values = {name: LaunchConfiguration(name).perform(context) for name in names}
    return {name: float(value) for name, value in values.items() if value}


def plant(context: LaunchContext) -> list[Node]:
    """Return the plant with those of the cylinder's own values replaced that were given."""
    recorded = IfCondition(LaunchConfiguration('record')).evaluate(context)
    parameters = {
        'cylinder': source(context),
        'friction': ParameterValue(LaunchConfiguration('friction'), value_type=str),
        'speed': ParameterValue(LaunchConfiguration('speed'), value_type=float),
        'wait_for_subscribers': int(recorded),  # so that the bag has the first sample
        **given(context),
    }
    return [rig_node('plant', parameters)]


def transforms(context: LaunchContext) -> list[Node]:
    """Return what publishes /tf, the frames of each namespace under its name."""
    namespace = LaunchConfiguration('namespace').perform(context).strip('/')
    configuration = load_configuration(source(context), **given(context))
    return [
        Node(
            package='robot_state_publisher',
            executable='robot_state_publisher',
            namespace=namespace,
            parameters=[
                {
                    'robot_description': robot_description(configuration),
                    'frame_prefix': f'{namespace}/' if namespace else '',
                }
            ],
            remappings=[('robot_description', '~/robot_description')],  # the plant has its own
            condition=IfCondition(LaunchConfiguration('transforms')),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the nodes and what may be said of them on the command line."""
    profiles = PathJoinSubstitution([FindPackageShare(PACKAGE), 'config', 'fastdds.xml'])
    output = ParameterValue(LaunchConfiguration('output'), value_type=str)
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            SetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', DISCOVERY),
            SetEnvironmentVariable('FASTRTPS_DEFAULT_PROFILES_FILE', profiles),
            SetEnvironmentVariable('FASTDDS_DEFAULT_PROFILES_FILE', profiles),  # since Kilted
            OpaqueFunction(function=plant),
            OpaqueFunction(function=transforms),
            rig_node('valve_command', {}),
            rig_node('friction_estimator', {}),
            rig_node(
                'recorder',
                {'output': output},
                condition=IfCondition(LaunchConfiguration('record')),
            ),
        ]
    )
