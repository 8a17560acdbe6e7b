"""
Decodes many messages of one topic at once.

Most of them differ in nothing but their stamp and their numbers. Where these are is seen in the
first message; all that are like it in every other byte are read as columns of an array.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr import NANOSECONDS, Reader

Decoder = Callable[[Reader], Any]
"""One of those in `records.cdr`."""

NUMBER, STAMP = 8, 8
"""Bytes of a float and of a stamp."""


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
        fixed[reader.stamp_at : reader.stamp_at + STAMP] = False
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
