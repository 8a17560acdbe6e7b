"""
Writes rosbag2 directories with MCAP storage, through `rosbags`, raw CDR in, raw CDR out.

What a killed recorder loses is the chunk it was filling. Left alone, rosbags closes a chunk at
1 MiB, i.e. every 2 s; here a chunk is also closed and handed to the operating system after
``FLUSH_PERIOD``, in a file that can be read from then on, see `bag_file`.

Messages are appended to rosbags' pending chunk directly: ``Writer.write`` keeps statistics for
each message, which costs five times as much. Here index and statistics are made of the file's
chunks when the bag is complete, so that the memory of a recorder does not grow with its bag.
"""

from __future__ import annotations

import contextlib
import struct
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, cast
from zlib import crc32

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter, PendingChunk
from rosbags.typesys import Stores, get_typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.bag_file import MAGIC, BagFile, chunks, index_record, totals
from pneu_rig_ros.records.integrity import CHECKSUM_PLACE, seal_index, seal_metadata
from pneu_rig_ros.records.topics import DEPTH, topic_named

FLUSH_PERIOD = 0.4
"""Longest age of a message that is only in memory [s], as long as messages keep coming."""

CHUNK_SIZE = 2**20
"""Largest chunk [byte]."""

_MESSAGE = struct.Struct('<BQHIQQ')
"""Opcode, length, channel, sequence, log time [ns], publish time [ns] of an MCAP message."""

_FIXED_SIZE = 22
"""Bytes of a message record between its length and its data."""


_FOREVER = QosTime(9_223_372_036, 854_775_807)


def offered(topic: str) -> Qos:
    """Return the quality of service that `ros2 bag play` gives a topic, as the live one has."""
    known = topic_named(topic)
    latched = known is not None and known.latched
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else DEPTH,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=_FOREVER,
        lifespan=_FOREVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOREVER,
        avoid_ros_namespace_conventions=False,
    )


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
        self._typestore = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Connection] = {}
        with self._explained():
            if self.path.exists():
                raise RigError(f'{self.path} exists; name a bag that does not, or remove it')
            self._writer = Writer(self.path, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
        storage = self._writer.storage
        assert isinstance(storage, McapWriter)
        self._storage = storage
        storage.bio.close()
        self._file = BagFile(storage.path)
        storage.bio = cast('Any', self._file)
        self._flushed = time.monotonic()

    def add_topic(self, topic: str, type_name: str) -> None:
        """Announce a topic, so that the bag lists it even if no message comes."""
        if topic in self._connections:
            return
        if type_name not in self._typestore.fielddefs:
            raise RigError(f'{topic}: message type {type_name!r} is not one of ROS 2 Jazzy')
        self._connections[topic] = self._writer.add_connection(
            topic, type_name, typestore=self._typestore, offered_qos_profiles=[offered(topic)]
        )

    def write(self, topic: str, type_name: str, log_time_ns: int, cdr: bytes) -> None:
        """
        Append one message.

        :param topic: absolute name, e.g. '/joint_states'
        :param type_name: e.g. 'sensor_msgs/msg/JointState'
        :param log_time_ns: when it arrived [ns]
        :param cdr: the serialised message, encapsulation header included
        :raises RigError: when the disk is full or the type unknown
        """
        connection = self._connections.get(topic)
        if connection is None:
            self.add_topic(topic, type_name)
            connection = self._connections[topic]
        chunk = self._storage.chunk
        channel = connection.id
        chunk.msgs[channel].append((log_time_ns, chunk.bio.tell()))
        length = _FIXED_SIZE + len(cdr)
        head = _MESSAGE.pack(0x05, length, channel, 0, log_time_ns, log_time_ns)
        chunk.bio.write(head + cdr)  # in one, so that an interrupt leaves no half of it
        self.message_count += 1
        if time.monotonic() - self._flushed > FLUSH_PERIOD or chunk.bio.tell() > CHUNK_SIZE:
            self.flush()

    def flush(self) -> None:
        """Close the current chunk and hand it to the operating system: it survives a SIGKILL."""
        self._flushed = time.monotonic()
        chunk, start = self._storage.chunk, self._file.tell()
        try:
            with self._explained():
                if chunk.msgs:
                    self._close_chunk(chunk, start)
                self._file.commit()
        except KeyboardInterrupt:
            # The chunk is in the file or not at all, and then it is written by the next call.
            self._file.drop()
            if self._file.tell() == start:
                self._storage.chunk = chunk
            raise

    def _close_chunk(self, chunk: PendingChunk, start: int) -> None:
        for entries in chunk.msgs.values():
            if entries and entries[-1][1] >= chunk.bio.tell():
                entries.pop()  # of a message before which there was an interrupt
        times = [time_ns for entries in chunk.msgs.values() for time_ns, _ in entries]
        if not times:
            return
        chunk.message_start_time, chunk.message_end_time = min(times), max(times)
        checksum = crc32(chunk.bio.getbuffer())
        self._storage.close_chunk()  # rosbags leaves its place for a checksum empty
        self._file.replace(start + CHECKSUM_PLACE, struct.pack('<I', checksum))
        self._storage.chunks.clear()

    def close(self, metadata: Mapping[str, str]) -> None:
        """
        Write index and metadata.yaml; the bag is complete.

        :param metadata: custom data, see `pneu_rig_ros.records.description`
        """
        for key, value in metadata.items():
            self._writer.set_custom_data(key, value)
        try:
            self.flush()
        finally:
            # What could not be written is not counted; what could be gets its index.
            with self._explained():
                self._take_stock()
                self._writer.close()
                seal_index(self._storage.path)
                seal_metadata(self.path / 'metadata.yaml')

    def _take_stock(self) -> None:
        """Give rosbags the chunks and statistics that belong into the index."""
        storage, writer = self._storage, self._writer
        storage.chunk = PendingChunk(0, 0, BytesIO(), defaultdict(list))
        with storage.path.open('rb') as stream:
            found = list(chunks(stream, len(MAGIC), self._file.tell()))
        counted = totals(found)
        storage.chunks = [index_record(chunk) for chunk in found]
        # An empty bag would start at 2^63 - 1 ns otherwise, which no reader likes.
        writer.min_timestamp = storage.message_start_time = counted.start_time
        writer.max_timestamp = storage.message_end_time = counted.end_time
        for channel in writer.counts:
            count = counted.channel_message_counts.get(channel, 0)
            writer.counts[channel] = storage.channel_stats[channel] = count

    def abort(self) -> None:
        """Stop without index, as a crash would; `pneu_rig_ros.records.repair` reads the rest."""
        self._file.drop()
        self._writer.abort()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> Literal[False]:
        if self._writer.storage is not None:
            if kind is None:
                self.close({})
            else:
                self.abort()
        return False

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn what the file system says into one line."""
        try:
            yield
        except (OSError, WriterError) as error:
            raise self._explain(error) from error

    def _explain(self, error: OSError | WriterError) -> RigError:
        cause = error.strerror if isinstance(error, OSError) else None
        return RigError(f'cannot write the bag {self.path}: {cause or error}')
