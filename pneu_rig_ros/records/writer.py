"""
Writes rosbag2 directories with MCAP storage through `mcap`: raw CDR in, raw CDR out.

A killed recorder loses the chunk that it was filling, so a chunk is closed and handed to the
operating system every `FLUSH_PERIOD`, into a file that is readable from then on (`growing_file`).
The index is made from the chunks in the file when the bag is closed: it covers exactly what was
written even after an error, and the memory of a recorder does not grow with its bag.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Literal, cast

import yaml
from mcap.records import Channel, MetadataIndex, Schema
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr import typestore
from pneu_rig_ros.records.growing_file import GrowingFile
from pneu_rig_ros.records.mcap_index import index_bytes, scan_chunks
from pneu_rig_ros.records.rosbag2_metadata import (
    TYPE_HASH,
    format_metadata,
    offered_qos,
    write_metadata,
)

FLUSH_PERIOD = 0.4
"""Longest age of a message that is only in memory [s], as long as messages keep coming."""

CHUNK_SIZE = 2**20
"""Largest chunk [byte]."""

RECORD_HEAD = 31
"""What MCAP puts before the data of a message [byte]."""

CHUNKS_PER_WRITER = 256
"""After them a new `mcap` writer takes over, as one remembers each chunk that it has written."""


class BagWriter:
    """
    A bag being written. Use as a context manager or call ``close``.

    :param path: directory to create; its parents are created as needed
    :raises RigError: when the path exists or cannot be created
    """

    path: Path
    """The bag's directory."""
    message_count: int
    """Messages written so far."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.message_count = 0
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._channel_ids: dict[str, int] = {}
        self._chunks, self._unflushed, self._flushed = 0, 0, time.monotonic()
        self._storage = self.path / f'{self.path.name}.mcap'
        with self._one_line_errors():
            if self.path.exists():
                raise RigError(f'{self.path} exists; name a bag that does not, or remove it')
            self.path.mkdir(parents=True)
            self._file = GrowingFile(self._storage)
            self._writer = self._new_writer()
            self._writer.start(Profile.ROS2)
            self._file.flush()

    def _new_writer(self) -> Writer:
        """Return an `mcap` writer that has the topics under the same numbers."""
        writer = Writer(
            cast('IO[Any]', self._file),
            chunk_size=sys.maxsize,  # `flush` closes the chunks
            compression=CompressionType.NONE,
        )
        for schema in self._schemas.values():
            writer.register_schema(schema.name, schema.encoding, schema.data)
        for c in self._channels.values():
            writer.register_channel(c.topic, c.message_encoding, c.schema_id, c.metadata)
        return writer

    def add_topic(self, topic: str, type_name: str) -> None:
        """Announce a topic, so that the bag lists it even if no message comes."""
        if topic in self._channel_ids:
            return
        if type_name not in typestore().fielddefs:
            raise RigError(f'{topic}: message type {type_name!r} is not one of ROS 2 Jazzy')
        schema_id = self._schema_id(type_name)
        metadata = {
            'offered_qos_profiles': yaml.safe_dump([offered_qos(topic)]).strip(),
            TYPE_HASH: typestore().hash_rihs01(type_name),
        }
        number = self._writer.register_channel(topic, MessageEncoding.CDR, schema_id, metadata)
        self._channel_ids[topic] = number
        self._channels[number] = Channel(
            id=number,
            topic=topic,
            message_encoding=MessageEncoding.CDR,
            metadata=metadata,
            schema_id=schema_id,
        )

    def _schema_id(self, type_name: str) -> int:
        for schema in self._schemas.values():
            if schema.name == type_name:
                return schema.id
        definition = typestore().generate_msgdef(type_name, ros_version=2)[0].encode()
        number: int = self._writer.register_schema(type_name, SchemaEncoding.ROS2, definition)
        self._schemas[number] = Schema(
            id=number, data=definition, encoding=SchemaEncoding.ROS2, name=type_name
        )
        return number

    def write(self, topic: str, type_name: str, log_time_ns: int, cdr: bytes) -> None:
        """
        Append one message.

        :param topic: absolute name, e.g. '/joint_states'
        :param type_name: e.g. 'sensor_msgs/msg/JointState'
        :param log_time_ns: when it arrived [ns]
        :param cdr: the serialised message, encapsulation header included
        :raises RigError: when the disk is full or the type unknown
        """
        channel = self._channel_ids.get(topic)
        if channel is None:
            self.add_topic(topic, type_name)
            channel = self._channel_ids[topic]
        self._writer.add_message(channel, log_time_ns, cdr, log_time_ns)
        self.message_count += 1
        self._unflushed += RECORD_HEAD + len(cdr)
        if self._unflushed > CHUNK_SIZE or time.monotonic() - self._flushed > FLUSH_PERIOD:
            self.flush()

    def flush(self) -> None:
        """Close the current chunk and hand it to the operating system: it survives a SIGKILL."""
        self._flushed = time.monotonic()
        if not self._unflushed:
            return
        self._unflushed = 0
        with self._one_line_errors():
            self._writer.flush()
        self._chunks += 1
        if self._chunks % CHUNKS_PER_WRITER == 0:
            self._writer = self._new_writer()

    def close(self, metadata: Mapping[str, str]) -> None:
        """
        Write index and metadata.yaml; the bag is complete.

        :param metadata: custom data, see `pneu_rig_ros.records.description`
        """
        try:
            self.flush()
        finally:
            with self._one_line_errors():
                self._write_index(metadata)

    def _write_index(self, custom_data: Mapping[str, str]) -> None:
        """Write index and metadata.yaml for the messages that are in the file."""
        try:
            with self._storage.open('rb') as stream:
                summary, start = scan_chunks(stream)
            summary.schemas, summary.channels = self._schemas, self._channels
            text = format_metadata(self._storage.name, summary, custom_data)
            # rosbag2 finds the text in the file too, should metadata.yaml be lost
            self._writer.add_metadata('rosbag2', {'serialized_metadata': text})
            end = self._file.tell()
            summary.metadata_indexes = [MetadataIndex(start, end - start, 'rosbag2')]
            self._file.flush(index_bytes(summary, end))
        finally:
            self.abort()
        write_metadata(self.path, text)

    def abort(self) -> None:
        """Stop without index, as a crash would; `pneu_rig_ros.records.repair` reads the rest."""
        self._file.close()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> Literal[False]:
        if not self._file.closed:
            if kind is None:
                self.close({})
            else:
                self.abort()
        return False

    @contextlib.contextmanager
    def _one_line_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            cause = error.strerror or error
            raise RigError(f'cannot write the bag {self.path}: {cause}') from error
