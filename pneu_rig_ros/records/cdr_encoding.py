"""
The rig's messages as raw CDR, the bytes that travel on the wire and lie in the bag.

Each message is serialised once as a template; a tick then only patches its numbers. That is four
times cheaper than typed messages, and the live nodes and the offline simulation write the same
bytes because they use the same templates. No ROS is needed here.
"""

import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from pneu_rig_ros.arrays import Floats, Integers
from pneu_rig_ros.records.topics import BASE, CLOCK, JOINT, PISTON, STRING, TOPICS, TUBE
from pneu_rig_ros.rig import Sample

NANOSECONDS = 1_000_000_000
"""In a second."""
TIME = struct.Struct('<iI')
_DOUBLE = struct.Struct('<d')
COUNT = struct.Struct('<I')
LITTLE_ENDIAN = b'\x00\x01\x00\x00'
ENCAPSULATION = len(LITTLE_ENDIAN)
# Placeholders for the numbers in a new template. Their bytes occur nowhere else in a message, so
# a search for them finds the offsets at which the numbers are patched.
_MARKS = (1.2345678e-101, 2.3456789e-102, 3.4567891e-103)

_JOINT_FIELDS = {
    'joint_states': ('position', 'velocity'),
    'predicted/joint_states': ('position', 'velocity', 'effort'),
    'residual/joint_states': ('position', 'velocity'),
}
"""Topic of JointStates -> what its numbers are; an effort on all others."""


@cache
def typestore() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


def _message(type_name: str, **fields: Any) -> Any:
    return typestore().types[type_name](**fields)


def _header(frame_id: str) -> Any:
    stamp = _message('builtin_interfaces/msg/Time', sec=0, nanosec=0)
    return _message('std_msgs/msg/Header', stamp=stamp, frame_id=frame_id)


class Template:
    """A serialised message whose stamp, if any, and numbers, at first `_MARKS`, are patched."""

    def __init__(self, message: Any) -> None:
        self.type: str = message.__msgtype__
        self.stamped = hasattr(message, 'header')
        self.buffer = bytearray(typestore().serialize_cdr(message, self.type))
        marks = map(_DOUBLE.pack, _MARKS)
        self.offsets = [self.buffer.index(mark) for mark in marks if mark in self.buffer]

    def fill(self, *values: float) -> bytes:
        """Return the message with these numbers."""
        for offset, value in zip(self.offsets, values, strict=True):
            _DOUBLE.pack_into(self.buffer, offset, value)
        return bytes(self.buffer)

    def at(self, stamp_ns: int, *values: float) -> bytes:
        """Return the message with this stamp [ns] and these numbers."""
        # The stamp is the first field of a header, and a header that of its message.
        TIME.pack_into(self.buffer, ENCAPSULATION, *divmod(stamp_ns, NANOSECONDS))
        return self.fill(*values)


def template(topic: str, frame_prefix: str = '', variance: float = 0.0) -> Template:
    """
    Return the message of a topic of the rig, its shadow or a measured `force`, for its numbers.

    :param frame_prefix: of the frame in the header, as robot_state_publisher gives it to it
    :param variance: of a pressure [Pa^2]; 0 for one that is not known, as sensor_msgs says
    """
    if topic == 'valve_voltages':
        return _voltages()
    if topic in ('u', 'position', 'velocity'):
        return Template(_message(TOPICS[topic].type, data=_MARKS[0]))
    if topic.endswith('/pressure'):
        content = {'fluid_pressure': _MARKS[0], 'variance': variance}
        header = _header(frame_prefix + TUBE)
        return Template(_message(TOPICS[topic].type, header=header, **content))
    marks = dict(zip(_JOINT_FIELDS.get(topic, ('effort',)), _MARKS, strict=False))
    fields = ('position', 'velocity', 'effort')
    arrays = {name: np.array([marks[name]] if name in marks else [], float) for name in fields}
    return Template(_message(JOINT, header=_header(frame_prefix + BASE), name=[PISTON], **arrays))


@cache
def _voltages() -> Template:
    label = 'valve_1, valve_2 [V]'
    dimension = _message('std_msgs/msg/MultiArrayDimension', label=label, size=2, stride=2)
    layout = _message('std_msgs/msg/MultiArrayLayout', dim=[dimension], data_offset=0)
    data = np.array(_MARKS[:2])
    return Template(_message(TOPICS['valve_voltages'].type, layout=layout, data=data))


def pack_float64(value: float) -> bytes:
    """Encode std_msgs/Float64."""
    return LITTLE_ENDIAN + _DOUBLE.pack(value)


def pack_valve_voltages(voltage_1: float, voltage_2: float) -> bytes:
    """Encode the voltages of valve 1 and 2 [V] as Float64MultiArray with a labelled layout."""
    return _voltages().fill(voltage_1, voltage_2)


def pack_string(text: str) -> bytes:
    """Encode std_msgs/String."""
    return bytes(typestore().serialize_cdr(_message(STRING, data=text), STRING))


class PlantMessages:
    """
    The messages of one sampling instant, ready to publish or to write.

    :param pressure_variance: variance of the pressure sensors [Pa^2]
    :param frame_prefix: of the frames in the headers
    :param clock: whether the plant is the clock
    """

    def __init__(
        self, pressure_variance: float, frame_prefix: str = '', clock: bool = False
    ) -> None:
        self._joint_states = template('joint_states', frame_prefix)
        self._pressure = template('chamber_1/pressure', frame_prefix, pressure_variance)
        self._has_clock = clock

    def pack(self, sample: Sample, stamp_ns: int) -> dict[str, bytes]:
        """Return topic -> message of a sample (SI) at a stamp [ns], in the order of publishing."""
        position, velocity = sample.position, sample.velocity
        messages = {
            'joint_states': self._joint_states.at(stamp_ns, position, velocity),
            'position': pack_float64(position),
            'velocity': pack_float64(velocity),
            'chamber_1/pressure': self._pressure.at(stamp_ns, sample.pressure_1),
            'chamber_2/pressure': self._pressure.at(stamp_ns, sample.pressure_2),
        }
        if self._has_clock:
            messages[CLOCK] = LITTLE_ENDIAN + TIME.pack(*divmod(stamp_ns, NANOSECONDS))
        return messages


def fill_rows(
    template: Template, stamps: Integers, columns: Sequence[Floats]
) -> NDArray[np.uint8]:
    """
    Return the messages of n stamps [ns], as `Template` makes them, in a tenth of the time.

    :param columns: their numbers, in the order of the template, shape (n,) each
    :return: shape (n, size of a message)
    """
    rows = np.tile(np.frombuffer(template.buffer, dtype=np.uint8), (stamps.size, 1))
    if template.stamped:
        seconds, nanoseconds = np.divmod(stamps, NANOSECONDS)
        parts = np.stack([seconds, nanoseconds], axis=1).astype('<u4')
        rows[:, ENCAPSULATION : ENCAPSULATION + TIME.size] = parts.view(np.uint8)
    for offset, column in zip(template.offsets, columns, strict=True):
        values = np.ascontiguousarray(column, dtype='<f8')
        rows[:, offset : offset + 8] = values.view(np.uint8).reshape(-1, 8)
    return rows
