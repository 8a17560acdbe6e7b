"""
Keeps a damaged bag from passing for a whole one, and a hostile one from filling the memory.

A bag of this project has a checksum over each chunk, over the index of its MCAP file and over its
metadata.yaml, so that a changed bit anywhere is found. In a bag of others that lacks them only
what contradicts itself is found; :func:`unprotected_messages` tells.
"""

from __future__ import annotations

import re
import struct
from bz2 import BZ2Decompressor
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, BinaryIO
from zlib import crc32

from backports import zstd
from lz4.frame import LZ4FrameDecompressor
from rosbags.rosbag1 import reader as rosbag1
from rosbags.rosbag2 import Reader, storage_mcap
from rosbags.rosbag2.storage_mcap import ChunkInfo, McapReader

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig.yaml_file import check_yaml

LARGEST_CHUNK = 2**27
"""Of a bag's chunk, decompressed [byte]; recorders write some MB."""
LARGEST_METADATA = 10_000_000
"""Of metadata.yaml [byte]."""

NEEDS_CONVERSION = ('file', 'message')
"""Ways to compress a whole bag that say nothing of the size that comes out."""

CHECKSUM_PLACE = 33
"""From the start of a chunk to its checksum [byte]: after opcode, length, two times and a size."""

_FOOTER = struct.Struct('<BQQQI8s')
_SEAL = '# crc32 {:08x}\n'
_SEALED = re.compile(rb'(?P<text>.*\n)# crc32 (?P<crc>[0-9a-f]{8})\n', re.DOTALL)


def seal_metadata(path: Path) -> None:
    """Append to a metadata.yaml a comment with its checksum."""
    text = path.read_bytes()
    sealed = path.with_suffix('.yaml.sealed')
    sealed.write_bytes(text + _SEAL.format(crc32(text)).encode())
    sealed.replace(path)


def seal_index(path: Path) -> None:
    """Write the checksum of an MCAP file's index into its footer."""
    with path.open('r+b') as file:
        place, checksum, _ = _index_checksums(file)
        file.seek(place)
        file.write(struct.pack('<I', checksum))


def check_metadata(directory: Path) -> None:
    """
    Look at the metadata.yaml of a bag before it is opened.

    :raises RigError: when it was changed, or asks for what cannot be bounded
    """
    path = directory / 'metadata.yaml'
    if not path.is_file():
        return  # told when the bag is opened
    with path.open('rb') as file:
        data = file.read(LARGEST_METADATA + 1)
    if len(data) > LARGEST_METADATA:
        raise RigError(f'{path}: larger than {LARGEST_METADATA} bytes')
    sealed = _SEALED.fullmatch(data)
    if sealed and crc32(sealed['text']) != int(sealed['crc'], 16):
        raise RigError(f'{path}: changed since it was written, its checksum does not fit; where '
                       'that was on purpose, delete its last line')  # fmt: skip
    try:
        check_yaml(data.decode(), longest=LARGEST_METADATA)
    except ValueError as error:
        raise RigError(f'{path}: {error}') from None
    mode = re.search(rb'^\s*[\'"]?compression_mode[\'"]?:\s*[\'"]?(\w+)', data, re.MULTILINE)
    if mode and mode[1].decode().lower() in NEEDS_CONVERSION:
        raise RigError(f'{directory}: compressed {mode[1].decode()} by {mode[1].decode()}; '
                       'uncompressed or compressed chunks are read: ros2 bag convert')  # fmt: skip


def check_storage(reader: Reader) -> None:
    """
    Look at the index of an open bag before its messages are read.

    :raises RigError: when it was changed, contradicts itself, or needs too much memory
    """
    files = [storage for storage in _storages(reader) if isinstance(storage, McapReader)]
    for storage in files:
        assert storage.bio is not None
        where = Path(str(storage.path))
        _, checksum, written = _index_checksums(storage.bio)
        if written not in (0, checksum):
            raise RigError(f'{where}: the index was changed, its checksum does not fit')
        _check_chunks(storage.chunks, where)
    told = Counter({c.topic: c.msgcount for c in reader.connections})
    found: Counter[str] = Counter()
    for storage in files:
        found.update({c.topic: c.msgcount for c in storage.connections})
    if files and +told != +found:
        ((topic, count),) = list(((told - found) or (found - told)).items())[:1]
        raise RigError(f'{Path(str(reader.path))}: metadata.yaml says {told[topic]} messages on '
                       f'{topic}, the index {found[topic]} ({count} apart)')  # fmt: skip


def unprotected_messages(reader: Reader) -> bool:
    """Return whether the messages of an open bag lack a checksum."""
    return any(
        not isinstance(storage, McapReader) or not all(_checksums(storage))
        for storage in _storages(reader)
    )


def _storages(reader: Reader) -> list[Any]:
    return list(getattr(reader.storage, 'storages', [reader.storage]))


def _checksums(storage: McapReader) -> Iterable[int]:
    """Yield the checksums of the chunks, 0 for none."""
    assert storage.bio is not None
    for chunk in storage.chunks:
        storage.bio.seek(chunk.chunk_start_offset + CHECKSUM_PLACE)
        yield struct.unpack('<I', storage.bio.read(4))[0]


def _index_checksums(file: BinaryIO) -> tuple[int, int, int]:
    """Return where the checksum of the index is, what it must be, and what it is (0: none)."""
    end = file.seek(0, 2) - _FOOTER.size
    file.seek(end)
    footer = file.read(_FOOTER.size)
    _, _, start, _, written, _ = _FOOTER.unpack(footer)
    if not 0 < start <= end:
        return end + 25, 0, 0
    file.seek(start)
    return end + 25, crc32(file.read(end + 25 - start)), written


def _check_chunks(chunks: list[ChunkInfo], where: Path) -> None:
    """Raise RigError for chunks that overlap in the file, or hold too much at a time."""
    size = where.stat().st_size
    after = 0
    for chunk in sorted(chunks, key=lambda chunk: chunk.chunk_start_offset):
        start, end = chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length
        if start < after or end > size or chunk.compressed_size > chunk.chunk_length:
            raise RigError(f'{where}: the index has a chunk at {start} that cannot be there')
        after = end
    # Chunks whose times overlap are open together.
    edges = [(c.message_start_time, c.uncompressed_size) for c in chunks]
    edges += [(c.message_end_time + 1, -c.uncompressed_size) for c in chunks]
    together = 0
    for _, change in sorted(edges):
        together += change
        if together > LARGEST_CHUNK:
            raise RigError(f'{where}: {together} bytes in chunks of the same time, allowed are '
                           f'{LARGEST_CHUNK}')  # fmt: skip


def _bounded(new: Callable[[], Any]) -> Callable[..., bytes]:
    """Return a decompressor that stops where a chunk ends by its own account."""

    def decompress(data: bytes, size: int = LARGEST_CHUNK) -> bytes:
        limit = min(size, LARGEST_CHUNK) + 1
        decompressor, parts, length = new(), [], 0
        while length < limit:
            part = decompressor.decompress(data, max_length=limit - length)
            parts.append(part)
            length += len(part)
            if decompressor.eof or not part:
                break
            data = b''
        return b''.join(parts)

    return decompress


def _bound_decompression() -> None:
    """Put limits where rosbags has none: a few kB in a bag could otherwise fill the memory."""
    lz4 = _bounded(LZ4FrameDecompressor)
    storage_mcap.DECOMPRESSORS.update({'lz4': lz4, 'zstd': _bounded(zstd.ZstdDecompressor)})
    rosbag1.decompressors.update({'bz2': _bounded(BZ2Decompressor), 'lz4': lz4})


_bound_decompression()
