"""The topics of the rig, for nodes, recorder, bags and documents."""

from collections.abc import Iterator
from typing import NamedTuple

CLOCK = '/clock'
DIAGNOSTICS = '/diagnostics'
PISTON = 'piston'
"""Name of the only joint in `joint_states` and `friction`."""
BASE, TUBE = 'base', 'cylinder'
"""Links of `robot_description` that headers name: of the joint, of the pressure sensors."""

STREAM_DEPTH, DIAGNOSTICS_DEPTH = 5_000, 100
"""
Queue of a publisher [messages]: what a subscriber that was suspended for 5.8 s at 862 Hz receives.

A publisher also keeps it for a killed subscriber, until DDS gives that one up after 20 s, and its
memory never shrinks. 5 000 messages of each of its topics are 28 MB in the plant.
"""

RECORDER_DEPTH = 20_000
"""Queue of the recorder [messages]: 23 s at 862 Hz in which its disk may not respond."""

EACH_SAMPLE = 'each sample'
EACH_COMMAND = 'each command'
ONCE = 'once, kept for late joiners'
EACH_SECOND = '1 Hz'


class Topic(NamedTuple):
    """
    One topic: name (relative, unless ROS fixes it), type, content with units, when published.

    `transient_local` topics: a late subscriber gets the last message. `extra` topics
    come from nodes that not every rig has; a bag lists them only with messages.
    """

    name: str
    type: str
    content: str
    when: str
    transient_local: bool = False
    extra: bool = False

    @property
    def depth(self) -> int:
        """Queue of its publishers [messages], also when a bag is played."""
        if self.transient_local:
            return 1
        return DIAGNOSTICS_DEPTH if self.when == EACH_SECOND else STREAM_DEPTH


FLOAT64, STRING = 'std_msgs/msg/Float64', 'std_msgs/msg/String'
VOLTAGES = 'std_msgs/msg/Float64MultiArray'
JOINT, PRESSURE = 'sensor_msgs/msg/JointState', 'sensor_msgs/msg/FluidPressure'

SAMPLE_TOPICS = ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure')
"""Topics that every rig has; together they are a sample."""

DERIVED = ('predicted/', 'residual/')
"""Prefixes of topics that repeat the topics of the rig."""


def _rig_topics() -> Iterator[Topic]:
    command = 'command of Eq. 1 [V], from any controller, -1000 to 1000'
    yield Topic('u', FLOAT64, command, EACH_COMMAND)
    voltages = 'u1, u2 [V] after DAC quantisation and saturation 0-5 V, labelled layout'
    yield Topic('valve_voltages', VOLTAGES, voltages, EACH_COMMAND)
    joint = 'joint `piston`: position [m], velocity [m/s], stamped'
    yield Topic('joint_states', JOINT, joint, EACH_SAMPLE)
    yield Topic('position', FLOAT64, 'the same position [m], plain', EACH_SAMPLE)
    yield Topic('velocity', FLOAT64, 'the same velocity [m/s], plain', EACH_SAMPLE)
    for chamber, end in ((1, 'cap'), (2, 'rod')):
        pressure = f'{end} end: absolute [Pa], variance of the sensor [Pa^2], stamped'
        yield Topic(f'chamber_{chamber}/pressure', PRESSURE, pressure, EACH_SAMPLE)
    force = 'joint `piston`: effort = friction force F_r [N] by Eq. 2, stamped with its sample'
    yield Topic('friction', JOINT, force, EACH_SAMPLE)
    yaml = 'YAML of the whole rig configuration, with the git revision'
    yield Topic('rig_description', STRING, yaml, ONCE, transient_local=True)
    urdf = 'URDF of the cylinder, with the prismatic joint `piston`, for RViz and Foxglove'
    yield Topic('robot_description', STRING, urdf, ONCE, transient_local=True, extra=True)
    reference = 'position reference [m], for position_controller'
    yield Topic('reference', FLOAT64, reference, EACH_SAMPLE, extra=True)
    commands = 'joint `piston`: velocity [m/s] or effort [N], from ros2_control, for joint_command'
    yield Topic('joint_commands', JOINT, commands, EACH_COMMAND, extra=True)


def _shadow_topics() -> Iterator[Topic]:
    motion = 'position [m], velocity [m/s]'
    contents = {
        'predicted/': ('of the live model:', f'{motion}, effort = friction [N]', ', absolute'),
        'residual/': ('measured minus predicted:', motion, ''),
    }
    for prefix, (source, joint, absolute) in contents.items():
        yield Topic(f'{prefix}joint_states', JOINT, f'{source} {joint}', EACH_SAMPLE, extra=True)
        for chamber, end in ((1, 'cap'), (2, 'rod')):
            name, pressure = f'{prefix}chamber_{chamber}/pressure', f'{end} end{absolute} [Pa]'
            yield Topic(name, PRESSURE, f'{source} {pressure}', EACH_SAMPLE, extra=True)


_STATUS = 'rate, deadline misses, saturation'
_TABLE = (
    *_rig_topics(),
    *_shadow_topics(),
    Topic(CLOCK, 'rosgraph_msgs/msg/Clock', 'in simulated time only', EACH_SAMPLE),
    Topic(DIAGNOSTICS, 'diagnostic_msgs/msg/DiagnosticArray', _STATUS, EACH_SECOND),
)

TOPICS: dict[str, Topic] = {topic.name: topic for topic in _TABLE}


def absolute_names(namespace: str) -> dict[str, str]:
    """Return topic -> its name in a namespace, '' or '/rig_a' ..., as bags and ROS 2 have it."""
    return {t: t if t.startswith('/') else f'{namespace}/{t}' for t in TOPICS}


def topic_named(name: str) -> Topic | None:
    """Return the topic that an absolute name in any namespace stands for, None if unknown."""
    ends = (t for t in TOPICS.values() if name == t.name or name.endswith(f'/{t.name}'))
    return max(ends, key=lambda topic: len(topic.name), default=None)
