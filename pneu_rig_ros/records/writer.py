"""
Writes rosbag2 directories with MCAP storage from the records of `mcap`: raw CDR in, raw CDR out.

A killed recorder loses the chunk that it was filling, so a chunk is closed and handed to the
operating system every `FLUSH_PERIOD`, into a file that is complete from then on (`GrowingFile`).
The index is made from the chunks in the file when the bag is closed: it covers exactly what was
written even after an error.

`mcap.writer.Writer` writes the same file, but takes twice the processor time, keeps 1 kB in memory
of each chunk, and counts chunks in its index that the disk had no room for.
"""

from __future__ import annotations

import struct
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

import numpy as np
import yaml
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, MessageIndex, Metadata, MetadataIndex, Schema
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Flags
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.atomic_write import writing
from pneu_rig_ros.records.cdr_encoding import typestore
from pneu_rig_ros.records.description import (
    TYPE_HASH,
    format_metadata,
    offered_qos,
    write_metadata,
)
from pneu_rig_ros.records.growing_file import (
    GrowingFile,
    deferred_interrupts,
    encode,
    index_bytes,
)
from pneu_rig_ros.records.mcap_file import MAGIC, MESSAGE, scan_chunks
from pneu_rig_ros.records.recording import Stamps

FLUSH_PERIOD = 0.4
"""Longest age of a message that is only in memory [s], as long as messages keep coming."""

CHUNK_SIZE = 2**20
"""Size at which a chunk is closed [byte]."""

_HEAD = struct.Struct('<BQHI')
"""Opcode and length of a record, channel, sequence of a message or size of an index [byte]."""

_MESSAGE = struct.Struct(f'{_HEAD.format}QQ')
"""What precedes the data of a message in a file: also log time and publish time [ns]."""


class TopicRows(NamedTuple):
    """The messages of one topic, shape (n, size), and which of them there are, shape (n,)."""

    topic: str
    type: str
    messages: NDArray[np.uint8]
    present: Flags


class Definition(NamedTuple):
    """A message type: its text as in a .msg file, encoding of the text, hash (REP 2011) or ''."""

    text: bytes
    encoding: str
    hash: str

    @classmethod
    def of(cls, topic: str, type_name: str) -> Definition:
        """Return that of a type of ROS 2 Jazzy; RigError with the topic for any other."""
        types = typestore()
        if type_name not in types.fielddefs:
            raise RigError(f'{topic}: message type {type_name!r} is not one of ROS 2 Jazzy')
        text, _ = types.generate_msgdef(type_name, ros_version=2)
        return cls(text.encode(), SchemaEncoding.ROS2, types.hash_rihs01(type_name))


class BagWriter:
    """
    A bag being written. Use as a context manager or call ``close``.

    :ivar path: the bag's directory, which is created with its parents
    :raises RigError: when the path exists, cannot be created or has a name that is not printable,
        which no metadata could hold
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._schemas: dict[str, Schema] = {}
        self._channels: dict[str, Channel] = {}
        self._content = bytearray()
        self._entries: dict[int, list[tuple[int, int]]] = defaultdict(list)
        self._flushed = time.monotonic()
        self._storage = self.path / f'{self.path.name}.mcap'
        with writing(f'the bag {self.path}'):
            if not self.path.name.isprintable():
                raise RigError(f'{self.path}: the name of a bag must be printable')
            if self.path.exists():
                raise RigError(f'{self.path} exists; name a bag that does not, or remove it')
            self.path.mkdir(parents=True)
            self._file = GrowingFile(self._storage)
            self._file.append(MAGIC + encode(Header(Profile.ROS2, 'pneu_rig_ros')))

    def add_topic(self, topic: str, type_name: str, definition: Definition | None = None) -> int:
        """
        Return the number of a topic, which the bag lists even if no message comes.

        :param definition: of the type; that of ROS 2 Jazzy if omitted
        """
        if topic in self._channels:
            return self._channels[topic].id
        definition = definition or Definition.of(topic, type_name)
        schema = self._schemas.get(type_name)
        if schema is None:
            number = len(self._schemas) + 1
            schema = Schema(number, definition.text, definition.encoding, type_name)
            self._schemas[type_name] = schema
            self._content += encode(schema)
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding=MessageEncoding.CDR,
            metadata={
                'offered_qos_profiles': yaml.safe_dump([offered_qos(topic)]).strip(),
                TYPE_HASH: definition.hash,
            },
            schema_id=schema.id,
        )
        self._channels[topic] = channel
        self._content += encode(channel)
        return channel.id

    def write(self, topic: str, type_name: str, log_time_ns: int, cdr: bytes) -> None:
        """
        Append one message of a topic by its absolute name.

        :param type_name: e.g. 'sensor_msgs/msg/JointState'
        :param cdr: encapsulation header included
        :param log_time_ns: when it arrived [ns]
        :raises RigError: when the disk is full or the type unknown
        """
        channel = self.add_topic(topic, type_name)
        start = len(self._content)
        # Packed here: a quarter of the time that mcap.records.Message takes.
        size = MESSAGE.size + len(cdr)
        head = _MESSAGE.pack(Opcode.MESSAGE, size, channel, 0, log_time_ns, log_time_ns)
        entries = self._entries[channel]
        try:
            self._content += head + cdr
            entries.append((log_time_ns, start))
        except KeyboardInterrupt:
            if not entries or entries[-1][1] != start:
                del self._content[start:]  # of a message without its entry in the index
            raise
        if len(self._content) > CHUNK_SIZE or time.monotonic() - self._flushed > FLUSH_PERIOD:
            self.flush()

    def write_rows(self, rows: Sequence[TopicRows], log_times: Stamps) -> None:
        """Append the messages of many instants [ns] as a chunk; topics are named without '/'."""
        self.flush()
        rows = [row for row in rows if row.present.any()]
        if not rows:
            return
        channels = [self.add_topic(f'/{row.topic}', row.type) for row in rows]
        content, index = chunk_of(rows, channels, log_times, len(self._content))
        there = log_times[np.logical_or.reduce([row.present for row in rows])]
        with deferred_interrupts():
            schemas, self._content = bytes(self._content), bytearray()
            self._append(schemas + content, int(there[0]), int(there[-1]), index)

    def flush(self) -> None:
        """Close the current chunk and hand it to the operating system: it survives a SIGKILL."""
        self._flushed = time.monotonic()
        with deferred_interrupts():
            entries = self._entries.items()
            filled = [MessageIndex(channel, found) for channel, found in entries if found]
            if not filled:
                return
            content = bytes(self._content)
            self._content, self._entries = bytearray(), defaultdict(list)
            times = [time_ns for index in filled for time_ns, _ in index.records]
            self._append(content, min(times), max(times), encode(*filled))

    def _append(self, content: bytes, first_ns: int, last_ns: int, index: bytes) -> None:
        """Write a chunk and the records of its index."""
        chunk = Chunk(
            compression='',
            data=content,
            message_end_time=last_ns,
            message_start_time=first_ns,
            uncompressed_crc=crc32(content),
            uncompressed_size=len(content),
        )
        with writing(f'the bag {self.path}'):
            self._file.append(encode(chunk) + index)

    def close(self, metadata: Mapping[str, str]) -> None:
        """Write index and metadata.yaml with this custom data; the bag is complete."""
        try:
            self.flush()
        finally:
            with writing(f'the bag {self.path}'), deferred_interrupts():
                self._write_index(metadata)

    def _write_index(self, custom_data: Mapping[str, str]) -> None:
        """Write index and metadata.yaml for the messages that are in the file."""
        try:
            with self._storage.open('rb') as stream:
                summary = scan_chunks(stream)
            # those in the file, and topics without a message, which may be in no chunk
            summary.schemas = {schema.id: schema for schema in self._schemas.values()}
            summary.channels = {channel.id: channel for channel in self._channels.values()}
            text = format_metadata(self._storage.name, summary, custom_data)
            # rosbag2 finds the text in the file too, should metadata.yaml be lost
            record = encode(Metadata('rosbag2', {'serialized_metadata': text}))
            start, end = self._file.size, self._file.size + len(record)
            summary.metadata_indexes = [MetadataIndex(start, len(record), 'rosbag2')]
            self._file.append(record, index_bytes(summary, end))
        finally:
            self.abort()
        write_metadata(self.path, text)

    def abort(self) -> None:
        """Stop without index, as a crash would; `pneu_rig_ros.records.repair` reads the rest."""
        self._file.close()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None and not self._file.closed:
            self.close({})
        self.abort()


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


def _records(channel: int, log_times: Stamps, messages: NDArray[np.uint8]) -> NDArray[np.uint8]:
    head = _HEAD.pack(Opcode.MESSAGE, MESSAGE.size + messages.shape[1], channel, 0)
    heads = np.tile(np.frombuffer(head, dtype=np.uint8), (log_times.size, 1))
    # the log time is that of publishing, too
    times = np.stack([log_times, log_times], axis=1).astype('<u8').view(np.uint8)
    return np.hstack([heads, times, messages])


def _index(channel: int, log_times: Stamps, offsets: Stamps) -> bytes:
    entries = np.stack([log_times, offsets], axis=1).astype('<u8').tobytes()
    return _HEAD.pack(Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries)) + entries
