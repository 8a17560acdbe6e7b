"""
MCAP files: their index, their checksums and their messages.

A bag of this project has a checksum over each chunk and over the index, so that a changed bit
anywhere is found. In a file of others without checksums only contradictions are found. A file that
is being recorded, or whose recorder was killed, has no index: it is made from the chunks.
Decompression has a bound: a few kB in a hostile bag could otherwise fill the memory.
"""

import io
import struct
import sys
from bisect import bisect_left
from bz2 import BZ2Decompressor
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from operator import itemgetter
from typing import Any, BinaryIO
from zlib import crc32

from lz4.frame import LZ4FrameDecompressor
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import FOOTER_SIZE, make_reader
from mcap.records import Channel, Chunk, ChunkIndex, Footer, Schema, Statistics
from mcap.summary import Summary

from pneu_rig_ros.errors import RigError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAGIC = b'\x89MCAP0\r\n'

HEAD = struct.Struct('<BQ')
"""Opcode and length of a record."""

MESSAGE = struct.Struct('<HIQQ')
"""Channel, sequence, log time [ns] and publish time [ns], which precede the data of a message."""

_MESSAGE_OPCODE = int(Opcode.MESSAGE)

CHUNK_CRC_OFFSET = 33
"""From the start of a chunk record to its checksum [byte]: after opcode, length, times, size."""

Message = tuple[int, int, bytes]
"""Log time [ns], channel, data."""

LARGEST_CHUNK = 2**27
"""Of a bag's chunk, decompressed [byte]; recorders write some MB."""

_DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    'zstd': zstd.ZstdDecompressor,
    'lz4': LZ4FrameDecompressor,
    'bz2': BZ2Decompressor,
}


def scan_chunks(stream: BinaryIO) -> Summary:
    """
    Return the index made from the complete chunks of a file.

    Content is read of chunks with new channels only: 30 minutes take a fraction of a second.
    """
    summary = Summary()
    counts = scan_records(stream, summary)
    for number, chunk in enumerate(summary.chunk_indexes):
        # A channel is in the chunk of its first message, silent channels are in the first chunk.
        if number == 0 or not summary.channels.keys() >= chunk.message_index_offsets.keys():
            chunk_messages(stream, chunk, summary)
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
    return summary


def scan_records(stream: BinaryIO, summary: Summary) -> Counter[int]:
    """
    Return the number of messages of each channel in the complete records of a file.

    :param summary: receives the chunks, and the channels that are declared outside of them
    """
    counts: Counter[int] = Counter()
    chunks, start, size = summary.chunk_indexes, len(MAGIC), stream.seek(0, io.SEEK_END)
    while start + HEAD.size <= size:
        stream.seek(start)
        opcode, length = HEAD.unpack(stream.read(HEAD.size))
        after = start + HEAD.size + length
        if after > size:
            break
        if opcode == Opcode.CHUNK:
            chunks.append(_chunk_index(stream, start, after))
        elif opcode == Opcode.MESSAGE_INDEX and chunks:
            channel, entries_size = struct.unpack('<HI', stream.read(6))
            counts[channel] += entries_size // 16
            chunk = chunks[-1]
            chunk.message_index_offsets[channel] = start
            chunk.message_index_length = after - chunk.chunk_start_offset - chunk.chunk_length
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            _note(opcode, stream.read(length), summary)
        start = after
    return counts


def _chunk_index(stream: BinaryIO, start: int, after: int) -> ChunkIndex:
    data = ReadDataStream(stream)
    first, last, size, _ = data.read8(), data.read8(), data.read8(), data.read4()
    return ChunkIndex(
        chunk_length=after - start,
        chunk_start_offset=start,
        compression=data.read_prefixed_string(),
        compressed_size=data.read8(),
        message_end_time=last,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=first,
        uncompressed_size=size,
    )


def _content(stream: BinaryIO, chunk: ChunkIndex) -> bytes:
    """Return the decompressed content of a chunk; an error unless it fits checksum and size."""
    stream.seek(chunk.chunk_start_offset + HEAD.size)
    # Within the record's own bytes, so that no length in it can ask for more memory.
    record = Chunk.read(ReadDataStream(io.BytesIO(stream.read(chunk.chunk_length - HEAD.size))))
    content = decompress(record.data, record.compression, chunk.uncompressed_size)
    if record.uncompressed_crc not in (0, crc32(content)):
        raise ValueError(f'the chunk at {chunk.chunk_start_offset} does not fit its checksum')
    return content


def decompress(data: bytes, compression: str, size: int) -> bytes:
    """
    Return decompressed data, of which no more than ``LARGEST_CHUNK`` are decompressed.

    :param size: that they are stated to have [byte]
    :raises RigError: when they have another one, or the compression is unknown
    """
    limit = min(size, LARGEST_CHUNK) + 1
    if compression in _DECOMPRESSORS:
        data = _at_most(_DECOMPRESSORS[compression], data, limit)
    elif compression not in ('', 'none'):
        raise RigError(f'chunk compressed by {compression!r}, allowed: zstd, lz4')
    if len(data) != size:
        raise RigError(f'a chunk does not have the {size} bytes that it claims')
    return data


def _at_most(new: Callable[[], Any], data: bytes, limit: int) -> bytes:
    """Return the decompressed data, or the first `limit` bytes of them; any number of frames."""
    content, decompressor = bytearray(), new()
    while len(content) < limit:
        part = decompressor.decompress(data, max_length=limit - len(content))
        content += part
        data = decompressor.unused_data if decompressor.eof else b''
        if decompressor.eof and data:
            decompressor = new()
        elif decompressor.eof or not part:
            break  # the end, or cut off
    return bytes(content)


def chunk_messages(stream: BinaryIO, chunk: ChunkIndex, summary: Summary) -> list[Message]:
    """
    Return the messages of a chunk, in their order; any error of a parser where it is damaged.

    :param summary: receives the schemas and channels that are declared among them
    """
    content, messages = _content(stream, chunk), []
    at, size = 0, len(content)
    while at < size:
        opcode, length = HEAD.unpack_from(content, at)
        start = at + HEAD.size
        at = start + length
        if at > size:
            raise ValueError('a record goes beyond its chunk')
        if opcode == _MESSAGE_OPCODE:
            channel, _, log_time, _ = MESSAGE.unpack_from(content, start)
            messages.append((log_time, channel, content[start + MESSAGE.size : at]))
        else:
            _note(opcode, content[start:at], summary)
    return messages


def _note(opcode: int, content: bytes, summary: Summary) -> None:
    """Add a schema or a channel to the summary; a channel without its schema cannot be read."""
    stream = ReadDataStream(io.BytesIO(content))
    if opcode == Opcode.SCHEMA:
        schema = Schema.read(stream)
        summary.schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = Channel.read(stream)
        if channel.schema_id in summary.schemas:
            summary.channels[channel.id] = channel


class McapFile:
    """
    An MCAP file that is open for reading; what is appended to it later is not seen.

    :raises RigError: when its index was changed, contradicts itself, or needs too much memory
    :raises Exception: any of the parsers' own for a file that is damaged
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.summary = _read_index(stream)
        assert self.summary.statistics is not None
        self.statistics: Statistics = self.summary.statistics
        self._check_chunks()

    def counts(self) -> Counter[tuple[str, str]]:
        """Return the number of messages by topic and type, also of topics without messages."""
        counts: Counter[tuple[str, str]] = Counter()
        for number, channel in self.summary.channels.items():
            schema = self.summary.schemas.get(channel.schema_id)
            count = self.statistics.channel_message_counts.get(number, 0)
            counts[channel.topic, schema.name if schema else ''] += count
        return counts

    def protected(self) -> bool:
        """Return whether every message has a checksum."""
        for chunk in self.summary.chunk_indexes:
            self._stream.seek(chunk.chunk_start_offset + CHUNK_CRC_OFFSET)
            if self._stream.read(4) == bytes(4):
                return False
        return bool(self.summary.chunk_indexes)

    def messages(self, channels: Collection[int], start_ns: int = 0) -> Iterator[Message]:
        """Yield the messages of some channels from a log time [ns] on, in the order of time."""
        wanted = frozenset(channels)
        chunks = [
            chunk
            for chunk in self.summary.chunk_indexes
            if chunk.message_end_time >= start_ns
            # that index is optional in MCAP
            and (not chunk.message_index_offsets or wanted & chunk.message_index_offsets.keys())
        ]
        pending: list[Message] = []
        for chunk in sorted(chunks, key=lambda chunk: chunk.message_start_time):
            # Chunks may overlap in time: what is older than all that follows can be passed on.
            due = bisect_left(pending, chunk.message_start_time, key=itemgetter(0))
            yield from pending[:due]
            found = chunk_messages(self._stream, chunk, self.summary)
            pending = pending[due:]
            pending += (m for m in found if m[1] in wanted and m[0] >= start_ns)
            pending.sort(key=itemgetter(0))
        yield from pending

    def _check_chunks(self) -> None:
        """Raise RigError for chunks that overlap in the file, or hold too much at a time."""
        chunks, size = self.summary.chunk_indexes, self._stream.seek(0, io.SEEK_END)
        after = 0
        for chunk in sorted(chunks, key=lambda chunk: chunk.chunk_start_offset):
            start, end = chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length
            if start < after or end > size or chunk.compressed_size > chunk.chunk_length:
                raise RigError(f'the index has a chunk at {start} that cannot be there')
            after = end
        # Chunks whose times overlap are in memory together.
        edges = [(c.message_start_time, c.uncompressed_size) for c in chunks]
        edges += [(c.message_end_time + 1, -c.uncompressed_size) for c in chunks]
        together = 0
        for _, change in sorted(edges):
            together += change
            if together > LARGEST_CHUNK:
                raise RigError(
                    f'{together} bytes in chunks of the same time, allowed are {LARGEST_CHUNK}'
                )

    def check_decompression(self) -> None:
        """Raise RigError for a compressed chunk that does not have the size that it claims."""
        for chunk in self.summary.chunk_indexes:
            if chunk.compression:
                _content(self._stream, chunk)


def _read_index(stream: BinaryIO) -> Summary:
    """Return the index of an MCAP file, made from its chunks if it has none."""
    size = stream.seek(0, io.SEEK_END)
    end = stream.seek(max(0, size - FOOTER_SIZE - len(MAGIC)))
    data = stream.read()
    if data[FOOTER_SIZE:] != MAGIC or data[: HEAD.size] != HEAD.pack(Opcode.FOOTER, 20):
        raise ValueError('no MCAP footer at its end')
    footer = Footer.read(ReadDataStream(io.BytesIO(data[HEAD.size :])))
    if 0 < footer.summary_start <= end and footer.summary_crc:
        stream.seek(footer.summary_start)
        # The checksum covers the summary and the footer up to the checksum itself.
        if crc32(stream.read(end + FOOTER_SIZE - 4 - footer.summary_start)) != footer.summary_crc:
            raise RigError('the index was changed, its checksum does not fit')
    stream.seek(0)
    summary = make_reader(stream).get_summary()
    if summary and summary.chunk_indexes and summary.channels and summary.statistics:
        return summary
    return scan_chunks(stream)
