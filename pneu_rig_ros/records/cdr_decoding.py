"""
Decodes the rig's messages from raw CDR, one by one or many of one topic at once.

Most messages of a topic differ in nothing but their stamp and their numbers. Where these are is
seen in the first message; all that are like it in every other byte are read as columns of an
array.
"""

import math
import struct
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr_encoding import (
    COUNT,
    ENCAPSULATION,
    LITTLE_ENDIAN,
    NANOSECONDS,
    TIME,
)
from pneu_rig_ros.records.topics import PISTON

_Value = TypeVar('_Value')
_MOST_PADDING = 3
NUMBER = 8
"""Bytes of a float."""


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

    def skip_string(self) -> None:
        """Go beyond a text."""
        end = self.count() + self._at
        if not self._at < end <= self.size or self._cdr[end - 1]:
            raise RigError(f'message of {self.size} bytes: a text in it does not end')
        self._at = end

    def string(self) -> str:
        """Return a text."""
        start = self._at + -self._at % 4 + COUNT.size
        self.skip_string()
        return str(self._cdr[start : self._at - 1], 'utf-8')

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


Decoder = Callable[[Reader], Any]
"""One of those above."""


class Layout(NamedTuple):
    """
    Where a message has what a decoder returns.

    :param stamp: offset, None without one
    :param values: offset of each value, None for one that the message lacks
    :param fixed: whether a byte is neither of a stamp nor of a number, shape (size,)
    """

    stamp: int | None
    values: list[int | None]
    fixed: NDArray[np.bool_]


def decode_all(
    decoder: Decoder, messages: Sequence[bytes]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """
    Return the stamps [ns], shape (n,), 0 without one, and the values of n messages, shape (n, k).

    :raises RigError: for a message that cannot be decoded, with its number
    """
    if not messages:
        return np.empty(0, dtype=np.int64), np.empty((0, 0))
    layout = layout_of(decoder, messages[0])
    alike = np.array([len(message) == layout.fixed.size for message in messages])
    joined = b''.join(message for message, same in zip(messages, alike, strict=True) if same)
    content = np.frombuffer(joined, dtype=np.uint8).reshape(-1, layout.fixed.size)
    stamps, right = _stamps(content, layout.stamp)
    right &= (content[:, layout.fixed] == content[0, layout.fixed]).all(axis=1)
    columns = [_column(content, at, '<f8') for at in layout.values]
    alike[alike] = right
    all_stamps = np.zeros(len(messages), dtype=np.int64)
    all_values = np.zeros((len(messages), len(columns)))
    all_stamps[alike] = stamps[right]
    all_values[alike] = np.column_stack(columns)[right]
    for index in np.flatnonzero(~alike).tolist():
        _, (all_stamps[index], *all_values[index]) = _decoded(decoder, messages[index], index + 1)
    return all_stamps, all_values


def layout_of(decoder: Decoder, message: bytes) -> Layout:
    """Return where a message has its stamp and values; RigError where it cannot be decoded."""
    reader, _ = _decoded(decoder, message, 1)
    fixed, marked = np.ones(len(message), dtype=np.bool_), bytearray(message)
    if reader.stamp_at is not None:
        fixed[reader.stamp_at : reader.stamp_at + TIME.size] = False
    for at in reader.numbers_at:
        fixed[at : at + NUMBER] = False
        # a number that says where it is: the decoder then says which it takes
        struct.pack_into('<d', marked, at, float(at))
    _, (_, *marks) = _decoded(decoder, bytes(marked), 1)
    return Layout(reader.stamp_at, [None if math.isnan(m) else int(m) for m in marks], fixed)


class _Locating(Reader):
    """A reader that notes the offsets of the stamp and of all floats."""

    def __init__(self, cdr: bytes) -> None:
        super().__init__(cdr)
        self.stamp_at: int | None = None
        self.numbers_at: list[int] = []

    def stamp(self) -> int:
        self.stamp_at = self._at
        return super().stamp()

    def doubles(self, count: int) -> tuple[float, ...]:
        values = super().doubles(count)
        self.numbers_at += range(self._at - NUMBER * count, self._at, NUMBER)
        return values


def _decoded(decoder: Decoder, message: bytes, number: int) -> tuple[_Locating, tuple[Any, ...]]:
    """Return the reader of one message, with its stamp [ns], 0 without one, and its values."""
    try:
        reader = _Locating(message)
        value = decoder(reader)
    except RigError as error:
        raise RigError(f'message {number}: {error}') from error
    values = value if isinstance(value, tuple) else (value,)
    return reader, values if reader.stamp_at is not None else (0, *values)


def _stamps(
    content: NDArray[np.uint8], at: int | None
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the stamps [ns] of messages, and whether each is one, shape (n,)."""
    if at is None:
        return np.zeros(len(content), dtype=np.int64), np.ones(len(content), dtype=np.bool_)
    seconds = _column(content, at, '<i4').astype(np.int64)
    nanoseconds = _column(content, at + 4, '<u4').astype(np.int64)
    return seconds * NANOSECONDS + nanoseconds, nanoseconds < NANOSECONDS


def _column(content: NDArray[np.uint8], at: int | None, kind: str) -> NDArray[Any]:
    """Return the values at an offset of all messages, NaN without one, shape (n,)."""
    if at is None:
        return np.full(len(content), np.nan)
    size = np.dtype(kind).itemsize
    return content[:, at : at + size].copy().view(kind)[:, 0]
