"""The topics of the rig, for nodes, recorder, bags and documents."""

from typing import NamedTuple

CLOCK = '/clock'
DIAGNOSTICS = '/diagnostics'
PISTON = 'piston'
"""Name of the only joint in `joint_states` and `friction`."""

DEPTH = 20_000
"""Queue [messages]: 23 s at 862 Hz, so that a reader that paused loses nothing."""

EACH_SAMPLE = 'each sample'
EACH_COMMAND = 'each command'
ONCE = 'once, kept for late joiners'
EACH_SECOND = '1 Hz'


class Topic(NamedTuple):
    """
    One topic: name (relative, unless ROS fixes it), type, content with units, when published.

    `latched` topics are transient local: a late subscriber gets the last message. `extra` topics
    come from nodes that not every rig has; a bag lists them only with messages.
    """

    name: str
    type: str
    content: str
    when: str
    latched: bool = False
    extra: bool = False


_TABLE = (
    Topic(
        'u',
        'std_msgs/msg/Float64',
        'command of Eq. 1 [V], from any controller',
        EACH_COMMAND,
    ),
    Topic(
        'valve_voltages',
        'std_msgs/msg/Float64MultiArray',
        'u1, u2 [V] after DAC quantisation and saturation 0-5 V, labelled layout',
        EACH_COMMAND,
    ),
    Topic(
        'joint_states',
        'sensor_msgs/msg/JointState',
        'joint `piston`: position [m], velocity [m/s], stamped',
        EACH_SAMPLE,
    ),
    Topic('position', 'std_msgs/msg/Float64', 'the same position [m], plain', EACH_SAMPLE),
    Topic('velocity', 'std_msgs/msg/Float64', 'the same velocity [m/s], plain', EACH_SAMPLE),
    Topic(
        'chamber_1/pressure',
        'sensor_msgs/msg/FluidPressure',
        'cap end: absolute [Pa], variance of the sensor [Pa^2], stamped',
        EACH_SAMPLE,
    ),
    Topic(
        'chamber_2/pressure',
        'sensor_msgs/msg/FluidPressure',
        'rod end: absolute [Pa], variance of the sensor [Pa^2], stamped',
        EACH_SAMPLE,
    ),
    Topic(
        'friction',
        'sensor_msgs/msg/JointState',
        'joint `piston`: effort = friction force F_r [N] by Eq. 2, '
        'stamped with the sample it belongs to',
        EACH_SAMPLE,
    ),
    Topic(
        'rig_description',
        'std_msgs/msg/String',
        'YAML of the whole rig configuration, with the git revision',
        ONCE,
        latched=True,
    ),
    Topic(
        'robot_description',
        'std_msgs/msg/String',
        'URDF of the cylinder, with the prismatic joint `piston`, for RViz and Foxglove',
        ONCE,
        latched=True,
        extra=True,
    ),
    Topic(
        'reference',
        'std_msgs/msg/Float64',
        'position reference [m], for position_controller',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(
        'predicted/joint_states',
        'sensor_msgs/msg/JointState',
        'of the live model: position [m], velocity [m/s], effort = friction [N]',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(
        'predicted/chamber_1/pressure',
        'sensor_msgs/msg/FluidPressure',
        'of the live model: cap end, absolute [Pa]',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(
        'predicted/chamber_2/pressure',
        'sensor_msgs/msg/FluidPressure',
        'of the live model: rod end, absolute [Pa]',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(
        'residual/joint_states',
        'sensor_msgs/msg/JointState',
        'measured minus predicted: position [m], velocity [m/s]',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(
        'residual/chamber_1/pressure',
        'sensor_msgs/msg/FluidPressure',
        'measured minus predicted: cap end [Pa]',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(
        'residual/chamber_2/pressure',
        'sensor_msgs/msg/FluidPressure',
        'measured minus predicted: rod end [Pa]',
        EACH_SAMPLE,
        extra=True,
    ),
    Topic(CLOCK, 'rosgraph_msgs/msg/Clock', 'in simulated time only', EACH_SAMPLE),
    Topic(
        DIAGNOSTICS,
        'diagnostic_msgs/msg/DiagnosticArray',
        'rate, deadline misses, saturation',
        EACH_SECOND,
    ),
)

TOPICS: dict[str, Topic] = {topic.name: topic for topic in _TABLE}


def topic_named(name: str) -> Topic | None:
    """Return the topic that an absolute name in any namespace stands for, None if unknown."""
    ends = (t for t in TOPICS.values() if name == t.name or name.endswith(f'/{t.name}'))
    return max(ends, key=lambda topic: len(topic.name), default=None)


DERIVED = ('predicted/', 'residual/')
"""Prefixes of topics that repeat the topics of the rig."""
