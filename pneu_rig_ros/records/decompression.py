"""Decompression with a bound: a few kB in a hostile bag could otherwise fill the memory."""

from __future__ import annotations

import sys
from bz2 import BZ2Decompressor
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from lz4.frame import LZ4FrameDecompressor
from rosbags.rosbag1.reader import Header, read_bytes, read_uint32

from pneu_rig_ros.errors import RigError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

LARGEST_CHUNK = 2**27
"""Of a bag's chunk, decompressed [byte]; recorders write some MB."""

_DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    'zstd': zstd.ZstdDecompressor,
    'lz4': LZ4FrameDecompressor,
    'bz2': BZ2Decompressor,
}


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


def check_ros1_chunks(path: Path, offsets: Iterable[int]) -> None:
    """
    Decompress the chunks of a ROS 1 bag once, within the bound.

    :param offsets: of the chunk records in the file [byte]
    :raises RigError: when a chunk does not have the size that it claims
    """
    with path.open('rb') as stream:
        for offset in offsets:
            stream.seek(offset)
            header = Header.read(stream)
            data = read_bytes(stream, read_uint32(stream))
            decompress(data, header.get_string('compression'), header.get_uint32('size'))
