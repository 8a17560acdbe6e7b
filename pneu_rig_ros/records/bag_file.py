"""
An MCAP file that is whole at every moment while it grows.

After each piece stands what closes an MCAP file without an index, and the next piece is written
over that, in one call. So a file that is still being recorded, or whose recorder was killed, is
read by whatever reads MCAP; its index is made of the file itself when it is complete.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from rosbags.rosbag2.storage_mcap import (
    ChunkInfo,
    McapReader,
    Statistics,
    decompress,
    read_bytes,
    read_exact,
)

MAGIC = b'\x89MCAP0\r\n'
DATA_END = struct.pack('<BQI', 0x0F, 4, 0)
ENDING = DATA_END + struct.pack('<BQQQI', 0x02, 20, 0, 0, 0) + MAGIC
"""End of data, footer that knows of no summary, magic."""

CHUNK, MESSAGE_INDEX, SCHEMA, CHANNEL = 0x06, 0x07, 0x03, 0x04

_HEAD = struct.Struct('<BQ')
"""Opcode and length of a record."""

_TIMES = struct.Struct('<QQQI')
"""First and last log time [ns], size [byte] and checksum of a chunk's content."""


class BagFile:
    """
    The file that the storage of rosbags writes to; what it writes waits for `commit`.

    :param path: a file that holds no ending yet
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR)
        self._size = os.fstat(self._descriptor).st_size
        os.pwrite(self._descriptor, ENDING, self._size)
        self._pending = bytearray()

    def write(self, data: bytes | memoryview) -> int:
        """Append, at the next commit."""
        self._pending += data
        return len(data)

    def tell(self) -> int:
        """Return where the next byte will be."""
        return self._size + len(self._pending)

    def replace(self, place: int, data: bytes) -> None:
        """Write over what waits, from an offset in the file [byte] on."""
        start = place - self._size
        self._pending[start : start + len(data)] = data

    def commit(self) -> None:
        """
        Hand over to the operating system what waits: it survives the end of this process.

        :raises OSError: e.g. when the disk is full; the file is then as it was before
        """
        if self._pending:
            self._append(ENDING)

    def drop(self) -> None:
        """Forget what waits."""
        self._pending.clear()

    def close(self) -> None:
        """Append what waits, which closes the file by itself, and close the file."""
        try:
            if self._pending:
                self._append(b'')
        finally:
            os.close(self._descriptor)

    def _append(self, ending: bytes) -> None:
        piece = bytes(self._pending)
        self._pending.clear()
        try:
            self._put(piece + ending)
        except OSError:
            # The blocks of the old ending are there still, so that this needs no room.
            os.ftruncate(self._descriptor, self._size + len(ENDING))
            os.pwrite(self._descriptor, ENDING, self._size)
            raise
        self._size += len(piece)

    def _put(self, data: bytes) -> None:
        done = 0
        while done < len(data):
            done += os.pwrite(self._descriptor, data[done:], self._size + done)


class UnindexedReader(McapReader):
    """Reads a file without an index by the heads of its chunks, also while it grows."""

    def meta_scan(self) -> None:
        """Make the index."""
        assert self.bio
        self.chunks[:] = chunks(self.bio, self.data_start, self.data_end)
        known: set[int] = set()
        for index, chunk in enumerate(self.chunks):
            # A channel is written into the chunk of its first message, silent ones into the first.
            if index == 0 or not known.issuperset(chunk.channel_count):
                self._read_channels(self.bio, chunk)
                known.update(channel.id for channel in self.connections)
        self.statistics = totals(self.chunks)

    def _read_channels(self, bio: BinaryIO, chunk: ChunkInfo) -> None:
        """Enter the schemas and channels of a chunk as if they stood in the summary."""
        bio.seek(chunk.chunk_start_offset + _HEAD.size + _TIMES.size)
        compression = read_bytes(bio).decode()
        data = read_exact(bio, *struct.unpack('<Q', read_exact(bio, 8)))
        content = decompress(data, compression, chunk.uncompressed_size, 0)
        found = bytearray()
        for opcode, start, end in _records(BytesIO(content), 0, len(content)):
            if opcode in (SCHEMA, CHANNEL):
                found += content[start:end]
        file, position = self.bio, self.data_end
        self.bio, self.data_end = BytesIO(bytes(found) + ENDING), 0
        try:
            self.read_index()
        finally:
            self.bio, self.data_end = file, position


def chunks(bio: BinaryIO, start: int, end: int) -> Iterator[ChunkInfo]:
    """
    Yield the whole chunks between two offsets of a file [byte].

    Only heads are read: 30 minutes of the rig take a fraction of a second.
    """
    chunk: ChunkInfo | None = None
    for opcode, begin, after in _records(bio, start, end):
        if opcode == MESSAGE_INDEX and chunk is not None:
            channel, size = struct.unpack('<HI', read_exact(bio, 6))
            chunk.message_index_offsets[channel] = begin
            chunk.channel_count[channel] = size // 16
            indexed = after - chunk.chunk_start_offset - chunk.chunk_length
            chunk = chunk._replace(message_index_length=indexed)
            continue
        if chunk is not None:
            yield chunk
        chunk = _chunk(bio, begin, after) if opcode == CHUNK else None
    if chunk is not None:
        yield chunk


def _chunk(bio: BinaryIO, begin: int, after: int) -> ChunkInfo:
    first, last, size, _ = _TIMES.unpack(read_exact(bio, _TIMES.size))
    compression = read_bytes(bio).decode()
    (compressed,) = struct.unpack('<Q', read_exact(bio, 8))
    return ChunkInfo(first, last, begin, after - begin, {}, 0, compression, compressed, size, {})


def _records(bio: BinaryIO, start: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of each whole record, the file being at its content."""
    while start + _HEAD.size <= end:
        bio.seek(start)
        opcode, length = _HEAD.unpack(read_exact(bio, _HEAD.size))
        after = start + _HEAD.size + length
        if after > end:  # written since the end was looked up
            return
        yield opcode, start, after
        start = after


def totals(found: list[ChunkInfo]) -> Statistics:
    """Return the statistics of chunks."""
    counts: dict[int, int] = {}
    for chunk in found:
        for channel, count in chunk.channel_count.items():
            counts[channel] = counts.get(channel, 0) + count
    filled = [chunk for chunk in found if chunk.channel_count]
    return Statistics(
        message_count=sum(counts.values()),
        schema_count=0,
        channel_count=len(counts),
        attachement_count=0,
        metadata_count=0,
        chunk_count=len(found),
        start_time=min((chunk.message_start_time for chunk in filled), default=0),
        end_time=max((chunk.message_end_time for chunk in filled), default=0),
        channel_message_counts=counts,
    )


def index_record(chunk: ChunkInfo) -> BytesIO:
    """Return the content of the record by which the summary knows a chunk."""
    offsets = b''.join(struct.pack('<HQ', *item) for item in chunk.message_index_offsets.items())
    compression = chunk.compression.encode()
    record = BytesIO()
    record.write(struct.pack('<QQQQI', *chunk[:4], len(offsets)) + offsets)
    record.write(struct.pack('<QI', chunk.message_index_length, len(compression)) + compression)
    record.write(struct.pack('<QQ', chunk.compressed_size, chunk.uncompressed_size))
    return record
