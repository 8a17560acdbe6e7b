"""
Decodes the rig's messages from raw CDR, one by one or many of one topic at once.

Most messages of a topic differ in nothing but their stamp and their numbers: all that are like the
first one in every other byte are read as columns of an array.
"""

import itertools
import math
import struct
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Flags, Floats, Integers
from pneu_rig_ros.errors import RigError, prefixed
from pneu_rig_ros.records.cdr_encoding import (
    COUNT,
    ENCAPSULATION,
    LITTLE_ENDIAN,
    NANOSECONDS,
    TIME,
)
from pneu_rig_ros.records.topics import FLOAT64, JOINT, PISTON, PRESSURE, VOLTAGES

_Value = TypeVar('_Value')
_MOST_PADDING = 3


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


class Reader:
    """Walks through little-endian CDR; alignment counts from the end of the encapsulation."""

    def __init__(self, cdr: bytes) -> None:
        if len(cdr) < ENCAPSULATION or bytes(cdr[:2]) != LITTLE_ENDIAN[:2]:
            raise RigError(f'message of {len(cdr)} bytes: not little-endian CDR')
        self._cdr = cdr
        self.size = len(cdr)
        self._at = ENCAPSULATION

    def count(self) -> int:
        """Return the next number of elements."""
        self._at += -self._at % 4  # the encapsulation is 4 bytes long: no need to subtract it
        (value,) = COUNT.unpack_from(self._cdr, self._at)
        self._at += 4
        return int(value)

    def stamp(self) -> int:
        """Return a stamp [ns]."""
        seconds, nanoseconds = TIME.unpack_from(self._cdr, self._at)
        self._at += 8
        if nanoseconds >= NANOSECONDS:
            raise RigError(f'stamp with {nanoseconds} ns in a second, allowed are below 1e9')
        return int(seconds) * NANOSECONDS + int(nanoseconds)

    def text(self) -> bytes:
        """Return a text, in UTF-8."""
        size = self.count()
        start, self._at = self._at, self._at + size
        if not size or self._at > self.size or self._cdr[self._at - 1]:
            raise RigError(f'message of {self.size} bytes: a text in it does not end')
        return self._cdr[start : self._at - 1]

    def doubles(self, count: int) -> tuple[float, ...]:
        """Return some floats."""
        # An empty sequence is not followed by padding for the elements that it does not have.
        if count:
            self._at += -(self._at - ENCAPSULATION) % 8
        values = struct.unpack_from(f'<{count}d', self._cdr, self._at)
        self._at += 8 * count
        return values

    def end(self) -> None:
        """Raise RigError unless all but the padding was read: it would be another type."""
        if not 0 <= (left := self.size - self._at) <= _MOST_PADDING:
            raise RigError(f'message of {self.size} bytes: {left} bytes too many')


def _decoder(read: Callable[[Reader], _Value]) -> Callable[[bytes | Reader], _Value]:
    """Return a decoder of CDR or of a `Reader` of it; it raises RigError for another type."""

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
        reader.text()
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
    reader.text()
    names = [str(reader.text(), 'utf-8') for _ in range(reader.count())]
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
    reader.text()
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
    text = str(reader.text(), 'utf-8')
    reader.end()
    return text


Decoder = Callable[[bytes | Reader], Any]
"""One of those above."""

DECODERS: dict[str, Decoder] = {
    FLOAT64: unpack_float64,
    VOLTAGES: unpack_valve_voltages,
    JOINT: unpack_joint_state,
    PRESSURE: unpack_fluid_pressure,
}
"""Message type -> decoder of the numbers in it."""


def decode_all(decoder: Decoder, messages: Sequence[bytes]) -> tuple[Integers, Floats]:
    """
    Return the stamps [ns], shape (n,), 0 without one, and the values of n messages, shape (n, k).

    :raises RigError: for a message that cannot be decoded, with its number
    """
    if not messages:
        return np.empty(0, dtype=np.int64), np.empty((0, 0))
    count = len(_decoded(decoder, messages[0], 1)) - 1
    stamps, values = np.zeros(len(messages), dtype=np.int64), np.zeros((len(messages), count))
    size = len(messages[0])
    alike = np.array([len(message) == size for message in messages])
    joined = b''.join(itertools.compress(messages, alike))
    rows = _Rows(np.frombuffer(joined, dtype=np.uint8).reshape(-1, size))
    stamps[alike], *numbers = _decoded(decoder, rows, 1)
    for column, number in zip(values.T, numbers, strict=True):
        column[alike] = number
    alike[alike] = rows.like_the_first()
    for index in np.flatnonzero(~alike).tolist():
        stamps[index], *values[index] = _decoded(decoder, messages[index], index + 1)
    return stamps, values


class _Rows(Reader):
    """
    Walks through many messages of one size at once: stamps and floats are those of all of them.

    :param rows: their bytes, shape (n, size); what is no stamp and no float is read in the first
    """

    def __init__(self, rows: NDArray[np.uint8]) -> None:
        super().__init__(rows[0].tobytes())
        self._rows = rows
        self._fixed = np.ones(self.size, dtype=np.bool_)
        self._valid = np.ones(len(rows), dtype=np.bool_)

    def stamp(self) -> Any:
        super().stamp()
        seconds, nanoseconds = self._column('<i4', 8), self._column('<u4', 4)
        self._valid &= nanoseconds < NANOSECONDS
        return seconds.astype(np.int64) * NANOSECONDS + nanoseconds

    def doubles(self, count: int) -> tuple[Any, ...]:
        super().doubles(count)
        return tuple(self._column('<f8', 8 * left) for left in range(count, 0, -1))

    def _column(self, kind: str, back: int) -> NDArray[Any]:
        """Return the values that lie some bytes before the present place, shape (n,)."""
        part = slice(self._at - back, self._at - back + np.dtype(kind).itemsize)
        self._fixed[part] = False
        return self._rows[:, part].copy().view(kind)[:, 0]

    def like_the_first(self) -> Flags:
        """Return which differ from the first in nothing but stamp and floats, shape (n,)."""
        fixed = self._rows[:, self._fixed]
        alike: Flags = self._valid & (fixed == fixed[0]).all(axis=1)
        return alike


def _decoded(decoder: Decoder, message: bytes | Reader, number: int) -> tuple[Any, ...]:
    """Return the stamp [ns] of a message, 0 without one, and its values."""
    with prefixed(f'message {number}'):
        value = decoder(message)
    values = value if isinstance(value, tuple) else (value,)
    return values if hasattr(value, 'stamp_ns') else (0, *values)
