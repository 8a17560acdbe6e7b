"""
The rig's messages as raw CDR, the bytes that travel on the wire and lie in the bag.

Each message is serialised once as a template; a tick then only patches its numbers. That is four
times cheaper than typed messages, and the live nodes and the offline simulation write the same
bytes because they use the same templates. No ROS is needed here.
"""

import math
import struct
from collections.abc import Callable
from functools import cache, wraps
from typing import Any, NamedTuple, TypeVar

import numpy as np
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.topics import BASE, JOINT, PISTON, STRING, TOPICS, TUBE

_Value = TypeVar('_Value')
NANOSECONDS = 1_000_000_000
"""In a second."""
_TIME = struct.Struct('<iI')
_DOUBLE = struct.Struct('<d')
_COUNT = struct.Struct('<I')
_LITTLE_ENDIAN = b'\x00\x01\x00\x00'
_ENCAPSULATION = len(_LITTLE_ENDIAN)
_MOST_PADDING = 3
# Placeholders for the numbers in a new template. Their bytes occur nowhere else in a message, so
# a search for them finds the offsets at which the numbers are patched.
_MARKS = (1.2345678e-101, 2.3456789e-102, 3.4567891e-103)

_JOINT_FIELDS = {
    'joint_states': ('position', 'velocity'),
    'predicted/joint_states': ('position', 'velocity', 'effort'),
    'residual/joint_states': ('position', 'velocity'),
}
"""Topic of JointStates -> what its numbers are; an effort on all others."""


class JointReading(NamedTuple):
    """A JointState's stamp [ns] and its first joint's values (SI), NaN where absent."""

    stamp_ns: int
    position: float
    velocity: float
    effort: float


class PressureReading(NamedTuple):
    """Content of a FluidPressure: stamp [ns], absolute pressure [Pa], variance [Pa^2]."""

    stamp_ns: int
    pressure: float
    variance: float


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
    """
    A serialised message whose stamp (if any) and marked doubles are patched in place.

    :param message: with the first of ``_MARKS`` in the place of its numbers
    """

    def __init__(self, message: Any) -> None:
        self.stamped = hasattr(message, 'header')
        self.buffer = bytearray(typestore().serialize_cdr(message, message.__msgtype__))
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
        _TIME.pack_into(self.buffer, _ENCAPSULATION, *divmod(stamp_ns, NANOSECONDS))
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
    return _LITTLE_ENDIAN + _DOUBLE.pack(value)


def pack_valve_voltages(voltage_1: float, voltage_2: float) -> bytes:
    """Encode the voltages of valve 1 and 2 [V] as Float64MultiArray with a labelled layout."""
    return _voltages().fill(voltage_1, voltage_2)


def pack_clock(stamp_ns: int) -> bytes:
    """Encode a stamp [ns] as rosgraph_msgs/Clock."""
    return _LITTLE_ENDIAN + _TIME.pack(*divmod(stamp_ns, NANOSECONDS))


def pack_string(text: str) -> bytes:
    """Encode std_msgs/String."""
    return bytes(typestore().serialize_cdr(_message(STRING, data=text), STRING))


class Reader:
    """Walks through little-endian CDR; alignment counts from the end of the encapsulation."""

    def __init__(self, cdr: bytes) -> None:
        if len(cdr) < _ENCAPSULATION or bytes(cdr[:2]) != _LITTLE_ENDIAN[:2]:
            raise RigError(f'message of {len(cdr)} bytes: not little-endian CDR')
        self._cdr = cdr
        self.size = len(cdr)
        self._at = _ENCAPSULATION

    def count(self) -> int:
        """Return the next number of elements."""
        self._at += -self._at % 4  # the encapsulation is 4 bytes long: no need to subtract it
        (value,) = _COUNT.unpack_from(self._cdr, self._at)
        self._at += 4
        return int(value)

    def stamp(self) -> int:
        """Return a stamp [ns]."""
        seconds, nanoseconds = _TIME.unpack_from(self._cdr, self._at)
        self._at += 8
        if nanoseconds >= NANOSECONDS:
            raise RigError(f'stamp with {nanoseconds} ns in a second, allowed are below 1e9')
        return int(seconds) * NANOSECONDS + int(nanoseconds)

    def skip_string(self) -> None:
        """Go beyond a text."""
        end = self.count() + self._at
        if not self._at < end <= self.size or self._cdr[end - 1]:
            raise RigError(f'message of {self.size} bytes: a text in it does not end')
        self._at = end

    def string(self) -> str:
        """Return a text."""
        start = self._at + -self._at % 4 + _COUNT.size
        self.skip_string()
        return str(self._cdr[start : self._at - 1], 'utf-8')

    def doubles(self, count: int) -> tuple[float, ...]:
        """Return some floats."""
        # An empty sequence is not followed by padding for the elements that it does not have.
        if count:
            self._at += -(self._at - _ENCAPSULATION) % 8
        values = struct.unpack_from(f'<{count}d', self._cdr, self._at)
        self._at += 8 * count
        return values

    def end(self) -> None:
        """Raise RigError unless all but the padding was read: it would be another type."""
        if not 0 <= (left := self.size - self._at) <= _MOST_PADDING:
            raise RigError(f'message of {self.size} bytes: {left} bytes too many')


def _decoder(read: Callable[[Reader], _Value]) -> Callable[[bytes | Reader], _Value]:
    """
    Return a decoder, of CDR or of a reader that has it, from a function that takes the reader.

    It raises RigError when the message is cut short or has a text that is not UTF-8.
    """

    @wraps(read)
    def decode(message: bytes | Reader) -> _Value:
        reader = message if isinstance(message, Reader) else Reader(message)
        try:
            return read(reader)
        except struct.error as error:
            raise RigError(f'{read.__name__}: {reader.size} bytes are too few: {error}') from error
        except UnicodeDecodeError as error:
            raise RigError(f'{read.__name__}: not UTF-8: {error}') from error

    return decode


@_decoder
def unpack_float64(reader: Reader) -> float:
    """Decode std_msgs/Float64."""
    (value,) = reader.doubles(1)
    reader.end()
    return value


@_decoder
def unpack_valve_voltages(reader: Reader) -> tuple[float, float]:
    """Decode u1, u2 [V] of a Float64MultiArray with any layout. RigError unless two values."""
    for _ in range(reader.count()):
        reader.skip_string()
        reader.count()
        reader.count()
    reader.count()
    values = reader.doubles(reader.count())
    reader.end()
    if len(values) != 2:
        raise RigError(f'valve_voltages: {len(values)} values, allowed 2 (u1, u2 [V])')
    return values[0], values[1]


def _joints(reader: Reader) -> tuple[int, list[str], list[tuple[float, ...]]]:
    """Return stamp [ns], names, and positions, velocities and efforts of a JointState."""
    stamp_ns = reader.stamp()
    reader.skip_string()
    names = [reader.string() for _ in range(reader.count())]
    fields = [reader.doubles(reader.count()) for _ in range(3)]
    reader.end()
    return stamp_ns, names, fields


@_decoder
def unpack_joint_state(reader: Reader) -> JointReading:
    """Decode stamp and first joint of a JointState."""
    stamp_ns, _, fields = _joints(reader)
    return JointReading(stamp_ns, *(field[0] if field else math.nan for field in fields))


@_decoder
def unpack_joint_command(reader: Reader) -> JointReading:
    """Decode stamp and joint `piston` of a JointState of any joints. RigError without it."""
    stamp_ns, names, fields = _joints(reader)
    if PISTON not in names:
        raise RigError(f'no joint {PISTON!r} among {names[:3]}')
    if any(len(field) not in (0, len(names)) for field in fields):
        raise RigError(f'values of {[*map(len, fields)]} joints for {len(names)} names')
    index = names.index(PISTON)
    return JointReading(stamp_ns, *(field[index] if field else math.nan for field in fields))


@_decoder
def unpack_fluid_pressure(reader: Reader) -> PressureReading:
    """Decode a FluidPressure."""
    stamp_ns = reader.stamp()
    reader.skip_string()
    pressure, variance = reader.doubles(2)
    reader.end()
    return PressureReading(stamp_ns, pressure, variance)


@_decoder
def unpack_stamp(reader: Reader) -> int:
    """Decode the stamp [ns] of any message that begins with a Header or a Time."""
    return reader.stamp()


@_decoder
def unpack_string(reader: Reader) -> str:
    """Decode std_msgs/String."""
    text = reader.string()
    reader.end()
    return text
