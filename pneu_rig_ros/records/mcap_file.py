"""
MCAP files: their index, their checksums and their messages.

A bag of this project has a checksum over each chunk and over the index, so that a changed bit
anywhere is found. In a file of others without checksums only contradictions are found.
"""

import io
from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Iterator
from operator import itemgetter
from pathlib import Path
from typing import BinaryIO
from zlib import crc32

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import FOOTER_SIZE, make_reader
from mcap.records import Footer, Statistics
from mcap.summary import Summary

from pneu_rig_ros.errors import RigError, prefixed
from pneu_rig_ros.records.mcap_chunks import (
    HEAD,
    LARGEST_CHUNK,
    MAGIC,
    Message,
    chunk_content,
    chunk_messages,
    scan_chunks,
)

CHUNK_CRC_OFFSET = 33
"""From the start of a chunk record to its checksum [byte]: after opcode, length, times, size."""


class McapFile:
    """
    An MCAP file that is open for reading; what is appended to it later is not seen.

    :raises RigError: when its index was changed, contradicts itself, or needs too much memory
    :raises Exception: any of the parsers' own for a file that is damaged
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stream = path.open('rb')
        try:
            with prefixed(path):
                self.summary = read_index(self._stream)
                self._check_chunks()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._stream.close()

    @property
    def statistics(self) -> Statistics:
        """Numbers of messages, first and last log time [ns]."""
        assert self.summary.statistics is not None
        return self.summary.statistics

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
        chunks = []
        for chunk in self.summary.chunk_indexes:
            inside = chunk.message_index_offsets.keys()  # optional in MCAP
            if chunk.message_end_time >= start_ns and (wanted & inside or not inside):
                chunks.append(chunk)
        pending: list[Message] = []
        for chunk in sorted(chunks, key=lambda chunk: chunk.message_start_time):
            # Chunks may overlap in time: what is older than all that follows can be passed on.
            due = bisect_left(pending, chunk.message_start_time, key=itemgetter(0))
            yield from pending[:due]
            found = chunk_messages(chunk_content(self._stream, chunk), self.summary)
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
                chunk_content(self._stream, chunk)


def read_index(stream: BinaryIO) -> Summary:
    """
    Return the index of an MCAP file, made from its chunks if it has none.

    :raises ValueError: when the file does not end with a footer
    :raises RigError: when the index was changed
    """
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
