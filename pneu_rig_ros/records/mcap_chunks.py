"""
The chunks of MCAP files: their content, and the index that is made from them.

A file that is being recorded, or whose recorder was killed, has no other index. Decompression has
a bound: a few kB in a hostile bag could otherwise fill the memory.
"""

import io
import struct
import sys
from bz2 import BZ2Decompressor
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any, BinaryIO
from zlib import crc32

from lz4.frame import LZ4FrameDecompressor
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    Schema,
    Statistics,
)
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

Message = tuple[int, int, bytes]
"""Log time [ns], channel, data."""

LARGEST_CHUNK = 2**27
"""Of a bag's chunk, decompressed [byte]; recorders write some MB."""

_DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    'zstd': zstd.ZstdDecompressor,
    'lz4': LZ4FrameDecompressor,
    'bz2': BZ2Decompressor,
}


def encode(*records: McapRecord) -> bytes:
    """Return records as they are in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


def scan_chunks(stream: BinaryIO) -> Summary:
    """
    Return the index made from the complete chunks of a file.

    Only record heads are read, and the content of chunks with messages of new channels: 30 minutes
    of the rig take a fraction of a second.
    """
    summary = Summary()
    counts = scan_records(stream, summary)
    for number, chunk in enumerate(summary.chunk_indexes):
        # A channel is in the chunk of its first message, silent channels are in the first chunk.
        if number == 0 or not summary.channels.keys() >= chunk.message_index_offsets.keys():
            chunk_messages(chunk_content(stream, chunk), summary)
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


def chunk_content(stream: BinaryIO, chunk: ChunkIndex) -> bytes:
    """
    Return the decompressed content of a chunk.

    :raises ValueError: when it does not fit its checksum
    :raises RigError: when it does not have the size that the index says
    """
    stream.seek(chunk.chunk_start_offset + HEAD.size)
    # Within the record's own bytes, so that no length in it can ask for more memory.
    record = Chunk.read(ReadDataStream(io.BytesIO(stream.read(chunk.chunk_length - HEAD.size))))
    content = decompress(record.data, record.compression, chunk.uncompressed_size)
    if record.uncompressed_crc not in (0, crc32(content)):
        raise ValueError(f'the chunk at {chunk.chunk_start_offset} does not fit its checksum')
    return content


def decompress(data: bytes, compression: str, size: int) -> bytes:
    """
    Return decompressed data.

    :param compression: 'zstd', 'lz4', 'bz2', or '' for none
    :param size: that the data are to have, at most `LARGEST_CHUNK` [byte]
    :raises RigError: when they have another
    """
    if compression in ('', 'none'):
        content = data
    elif compression not in _DECOMPRESSORS:
        raise RigError(f'chunk compressed by {compression!r}, allowed: zstd, lz4')
    else:
        content = _at_most(_DECOMPRESSORS[compression], data, min(size, LARGEST_CHUNK) + 1)
    if len(content) != size:
        raise RigError(f'a chunk does not have the {size} bytes that it claims')
    return content


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


def chunk_messages(content: bytes, summary: Summary) -> list[Message]:
    """
    Return the messages in the content of a chunk, in their order.

    :param summary: receives the schemas and channels that are declared among them
    """
    messages = []
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
    checksum = crc32(content + encode(Footer(start, 0, 0))[:-4])
    return data_end + content + encode(Footer(start, 0, checksum)) + MAGIC
