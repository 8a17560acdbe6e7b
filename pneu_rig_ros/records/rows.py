"""
Many messages at once: rows of bytes that differ in their stamps and numbers alone.

A message of the rig has a fixed size, so that those of n samples are an array of bytes. They are
those that the encoders of `records.cdr` make one by one, in a tenth of the time.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.records.cdr import NANOSECONDS, Template
from pneu_rig_ros.records.mcap_chunks import MESSAGE
from pneu_rig_ros.records.recording import Stamps

Bytes = NDArray[np.uint8]

_STAMP = slice(4, 12)
"""Bytes of the stamp in a message that has one, after the encapsulation."""
_HEAD = struct.Struct('<BQHI')
"""Opcode and length of a record, channel, sequence of a message or size of an index [byte]."""


def fill_rows(template: Template, stamps: Stamps, columns: Sequence[Floats]) -> Bytes:
    """
    Return the messages of n stamps [ns], shape (n, size of a message).

    :param columns: their numbers, in the order of the template, shape (n,) each
    """
    rows = np.tile(np.frombuffer(template.buffer, dtype=np.uint8), (stamps.size, 1))
    if template.stamped:
        seconds, nanoseconds = np.divmod(stamps, NANOSECONDS)
        parts = np.stack([seconds, nanoseconds], axis=1).astype('<u4')
        rows[:, _STAMP] = parts.view(np.uint8)
    for offset, column in zip(template.offsets, columns, strict=True):
        values = np.ascontiguousarray(column, dtype='<f8')
        rows[:, offset : offset + 8] = values.view(np.uint8).reshape(-1, 8)
    return rows


class TopicRows(NamedTuple):
    """The messages of one topic, shape (n, size), and which of them there are, shape (n,)."""

    topic: str
    type: str
    messages: Bytes
    present: NDArray[np.bool_]


def chunk_of(
    rows: Sequence[TopicRows], channels: Sequence[int], log_times: Stamps, start: int
) -> tuple[bytes, bytes]:
    """
    Return the message records of n instants, topic by topic at each, and their index records.

    :param channels: number of each topic's channel
    :param log_times: of the instants [ns], shape (n,)
    :param start: offset of the first record in its chunk [byte]
    """
    records = [
        _records(channel, log_times, row.messages)
        for row, channel in zip(rows, channels, strict=True)
    ]
    sizes = np.array([record.shape[1] for record in records])
    present = np.stack([row.present for row in rows], axis=1)
    together = np.hstack(records)
    if not present.all():
        together = together[np.repeat(present, sizes, axis=1)]
    ends = np.cumsum(present * sizes).reshape(present.shape)
    index = b''.join(
        _index(channel, log_times[there], start + end[there] - size)
        for channel, there, end, size in zip(channels, present.T, ends.T, sizes, strict=True)
        if there.any()
    )
    return together.tobytes(), index


def _records(channel: int, log_times: Stamps, messages: Bytes) -> Bytes:
    head = _HEAD.pack(Opcode.MESSAGE, MESSAGE.size + messages.shape[1], channel, 0)
    heads = np.tile(np.frombuffer(head, dtype=np.uint8), (log_times.size, 1))
    # the log time is that of publishing, too
    times = np.stack([log_times, log_times], axis=1).astype('<u8').view(np.uint8)
    return np.hstack([heads, times, messages])


def _index(channel: int, log_times: Stamps, offsets: Stamps) -> bytes:
    entries = np.stack([log_times, offsets], axis=1).astype('<u8').tobytes()
    return _HEAD.pack(Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries)) + entries
