"""
The index (summary section) of an MCAP file: read, or made from the chunks where there is none.

A file that is being recorded, or whose recorder was killed, has no index yet.
"""

from __future__ import annotations

import io
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO, cast
from zlib import crc32

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, ChunkIndex, DataEnd, Footer, McapRecord, Schema, Statistics
from mcap.summary import Summary

from pneu_rig_ros.records.decompression import chunk_content
from pneu_rig_ros.records.growing_file import MAGIC, encode

CHUNK_CRC_OFFSET = 33
"""From the start of a chunk record to its checksum [byte]: after opcode, length, times, size."""

_HEAD = struct.Struct('<BQ')
"""Opcode and length of a record."""

FOOTER_SIZE = 29
"""Of the record at the end of the file [byte]."""

_CHUNK = struct.Struct('<QQQII')
"""First and last log time [ns], size [byte] and checksum of the content, length of a name."""


def read_footer(stream: BinaryIO) -> tuple[int, Footer]:
    """Return offset and content of the footer; ValueError if the file does not end with one."""
    size = stream.seek(0, io.SEEK_END)
    start = max(0, size - FOOTER_SIZE - len(MAGIC))
    stream.seek(start)
    data = stream.read()
    if data[FOOTER_SIZE:] != MAGIC or data[: _HEAD.size] != _HEAD.pack(Opcode.FOOTER, 20):
        raise ValueError('no MCAP footer at its end')
    return start, Footer.read(ReadDataStream(io.BytesIO(data[_HEAD.size :])))


def read_index(stream: BinaryIO) -> Summary:
    """Return the index of an MCAP file, made from its chunks if it has none."""
    stream.seek(0)
    summary = make_reader(stream).get_summary()
    if summary is not None and summary.chunk_indexes:
        return summary
    return scan_chunks(stream)[0]


def scan_chunks(stream: BinaryIO) -> tuple[Summary, int]:
    """
    Return the index made from the complete chunks of a file, and the offset of their end.

    Only record heads are read, and the content of chunks with messages of new channels: 30 minutes
    of the rig take a fraction of a second.
    """
    summary, counts, end = Summary(), Counter[int](), len(MAGIC)
    for opcode, start, after in _records(stream, len(MAGIC), stream.seek(0, io.SEEK_END)):
        if opcode == Opcode.CHUNK:
            summary.chunk_indexes.append(_chunk_index(stream, start, after))
        elif opcode == Opcode.MESSAGE_INDEX and summary.chunk_indexes:
            channel, size = struct.unpack('<HI', stream.read(6))
            chunk = summary.chunk_indexes[-1]
            chunk.message_index_offsets[channel] = start
            chunk.message_index_length = after - chunk.chunk_start_offset - chunk.chunk_length
            counts[channel] += size // 16
        elif opcode == Opcode.DATA_END:
            break
        end = after
    for number, chunk in enumerate(summary.chunk_indexes):
        # A channel is in the chunk of its first message, silent channels are in the first chunk.
        if number == 0 or not summary.channels.keys() >= chunk.message_index_offsets.keys():
            _add_channels(summary, stream, chunk)
    filled = [chunk for chunk in summary.chunk_indexes if chunk.message_index_offsets]
    summary.statistics = Statistics(
        attachment_count=0,
        channel_count=len(summary.channels),
        channel_message_counts=dict(counts),
        chunk_count=len(summary.chunk_indexes),
        message_count=counts.total(),
        message_start_time=min((chunk.message_start_time for chunk in filled), default=0),
        message_end_time=max((chunk.message_end_time for chunk in filled), default=0),
        metadata_count=0,
        schema_count=len(summary.schemas),
    )
    return summary, end


def _records(stream: BinaryIO, start: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of each complete record, with the stream at its content."""
    while start + _HEAD.size <= end:
        stream.seek(start)
        opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
        after = start + _HEAD.size + length
        if after > end:
            return
        yield opcode, start, after
        start = after


def _chunk_index(stream: BinaryIO, start: int, after: int) -> ChunkIndex:
    first, last, size, _, name_length = _CHUNK.unpack(stream.read(_CHUNK.size))
    compression = stream.read(name_length).decode()
    (compressed,) = struct.unpack('<Q', stream.read(8))
    return ChunkIndex(
        chunk_length=after - start,
        chunk_start_offset=start,
        compression=compression,
        compressed_size=compressed,
        message_end_time=last,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=first,
        uncompressed_size=size,
    )


def _add_channels(summary: Summary, stream: BinaryIO, chunk: ChunkIndex) -> None:
    content = io.BytesIO(chunk_content(stream, chunk))
    for opcode, _, _ in _records(content, 0, len(content.getbuffer())):
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(content))
            summary.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(ReadDataStream(content))
            summary.channels[channel.id] = channel


def index_bytes(summary: Summary, end: int) -> bytes:
    """Return what follows the data section of a file that ends at an offset: its index."""
    assert summary.statistics is not None
    statistics = replace(
        summary.statistics,
        channel_count=len(summary.channels),
        metadata_count=len(summary.metadata_indexes),
        schema_count=len(summary.schemas),
    )
    records: list[McapRecord] = [*summary.schemas.values(), *summary.channels.values()]
    records += [statistics, *summary.chunk_indexes, *summary.metadata_indexes]
    data_end, content = encode(DataEnd(0)), encode(*records)
    start = end + len(data_end)
    # The checksum covers the summary and the footer up to the checksum itself.
    head = struct.pack('<BQQQ', Opcode.FOOTER, 20, start, 0)
    return data_end + content + encode(Footer(start, 0, crc32(content + head))) + MAGIC


class IndexedFile:
    """
    A file without an index as a path for `rosbags.rosbag2.Reader`, which then finds an index.

    :param path: an MCAP file, which may be growing: what is appended later is not seen
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.suffix, self.stem = path.suffix, path.stem

    def __str__(self) -> str:
        return str(self._path)

    def exists(self) -> bool:
        """Return whether the file exists."""
        return self._path.exists()

    def is_dir(self) -> bool:
        """Return False."""
        return False

    def open(self, _: str = 'rb') -> BinaryIO:
        """Open the file for reading; where it has no index, one is appended in memory."""
        file = self._path.open('rb')
        try:
            if read_footer(file)[1].summary_start:
                file.seek(0)
                return file
            summary, end = scan_chunks(file)
        except BaseException:
            file.close()
            raise
        view = _Appended(file, end, index_bytes(summary, end))
        return cast('BinaryIO', io.BufferedReader(view))


class _Appended(io.RawIOBase):
    """The first `size` bytes of a file, followed by a tail in memory."""

    def __init__(self, file: BinaryIO, size: int, tail: bytes) -> None:
        self._file, self._size, self._tail = file, size, tail
        self._position = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        base = (0, self._position, self._size + len(self._tail))[whence]
        self._position = base + offset
        return self._position

    def readinto(self, buffer: Any) -> int:
        target, start = memoryview(buffer), self._position
        if start < self._size:
            self._file.seek(start)
            data = self._file.read(min(len(target), self._size - start))
        else:
            data = self._tail[start - self._size :][: len(target)]
        target[: len(data)] = data
        self._position += len(data)
        return len(data)

    def close(self) -> None:
        self._file.close()
        super().close()
