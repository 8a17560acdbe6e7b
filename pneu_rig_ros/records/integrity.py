"""
Finds damage in a bag before its messages are read, and refuses what would fill the memory.

A bag of this project has a checksum over each chunk, over the index of its MCAP file and over its
metadata.yaml, so that a changed bit anywhere is found. In a bag of others without checksums only
contradictions are found; `unprotected_messages` distinguishes the two.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any, BinaryIO
from zlib import crc32

from mcap.records import ChunkIndex

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.decompression import LARGEST_CHUNK, chunk_content
from pneu_rig_ros.records.mcap_index import CHUNK_CRC_OFFSET, read_footer, read_index, scan_chunks
from pneu_rig_ros.records.rosbag2_metadata import read_metadata


def check_bag(directory: Path) -> None:
    """
    Check metadata.yaml, and the index of each MCAP file that it names.

    :raises RigError: when they were changed, contradict each other, or need too much memory
    """
    information = read_metadata(directory)
    indexed: Counter[str] = Counter()
    files = _files(directory, information)
    for file in files:
        indexed += check_file(file)
    listed = Counter(
        {
            topic['topic_metadata']['name']: topic['message_count']
            for topic in information.get('topics_with_message_count', [])
        }
    )
    if files and information and +listed != indexed:
        ((topic, count),) = list(((listed - indexed) or (indexed - listed)).items())[:1]
        raise RigError(
            f'{directory}: metadata.yaml says {listed[topic]} messages on '
            f'{topic}, the index {indexed[topic]} ({count} apart)'
        )


def check_file(path: Path) -> Counter[str]:
    """
    Check the index of an MCAP file; return the number of messages of each topic.

    :raises RigError: when it was changed, contradicts itself, or needs too much memory
    """
    with path.open('rb') as stream:
        if not _index_intact(stream):
            raise RigError(f'{path}: the index was changed, its checksum does not fit')
        index = read_index(stream)
        _check_chunks(index.chunk_indexes, path)
        for chunk in index.chunk_indexes:
            if chunk.compression:
                chunk_content(stream, chunk)
    counts: Counter[str] = Counter()
    if index.statistics is not None:
        for channel, count in index.statistics.channel_message_counts.items():
            counts[index.channels[channel].topic] += count
    return +counts


def unprotected_messages(directory: Path) -> bool:
    """Return whether messages of a bag lack a checksum."""
    files = _files(directory, read_metadata(directory))
    return not files or not all(map(_all_checksums, files))


def _files(directory: Path, information: dict[str, Any]) -> list[Path]:
    """Return the MCAP files of a bag: those that its metadata name, else those in it."""
    if not information:
        return sorted(directory.glob('*.mcap'))
    names = [Path(str(name)).name for name in information.get('relative_file_paths', [])]
    files = [directory / name for name in names if name.endswith('.mcap')]
    return [file for file in files if file.exists()]  # others are reported when the bag is opened


def _all_checksums(path: Path) -> bool:
    with path.open('rb') as stream:
        chunks = scan_chunks(stream)[0].chunk_indexes  # also of a file that is growing
        for chunk in chunks:
            stream.seek(chunk.chunk_start_offset + CHUNK_CRC_OFFSET)
            if stream.read(4) == bytes(4):
                return False
    return bool(chunks)


def _index_intact(stream: BinaryIO) -> bool:
    """Return whether the index fits its checksum, or has none."""
    end, footer = read_footer(stream)
    if not 0 < footer.summary_start <= end or not footer.summary_crc:
        return True
    stream.seek(footer.summary_start)
    # The checksum covers the summary and the footer up to the checksum itself.
    return crc32(stream.read(end + 25 - footer.summary_start)) == footer.summary_crc


def _check_chunks(chunks: list[ChunkIndex], path: Path) -> None:
    """Raise RigError for chunks that overlap in the file, or hold too much at a time."""
    size = path.stat().st_size
    after = 0
    for chunk in sorted(chunks, key=lambda chunk: chunk.chunk_start_offset):
        start, end = chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length
        if start < after or end > size or chunk.compressed_size > chunk.chunk_length:
            raise RigError(f'{path}: the index has a chunk at {start} that cannot be there')
        after = end
    # Chunks whose times overlap are open together.
    edges = [(c.message_start_time, c.uncompressed_size) for c in chunks]
    edges += [(c.message_end_time + 1, -c.uncompressed_size) for c in chunks]
    together = 0
    for _, change in sorted(edges):
        together += change
        if together > LARGEST_CHUNK:
            raise RigError(
                f'{path}: {together} bytes in chunks of the same time, allowed are {LARGEST_CHUNK}'
            )
