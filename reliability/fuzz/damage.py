"""What bags suffer, one after the other: cut off anywhere, changed bits, bombs, wrong contents."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from functools import cache

from backports import zstd

from reliability.fuzz import seeds

BOMB = 2**31
"""What a few kB of a bomb would become [byte]."""


def cut(data: bytes, stride: int = 1) -> Iterator[bytes]:
    """Yield the first bytes of a file, of every length."""
    for size in range(0, len(data), stride):
        yield data[:size]


def flipped(data: bytes, stride: int = 1) -> Iterator[bytes]:
    """Yield a file with one bit changed, of each byte another one."""
    for place in range(0, len(data), stride):
        changed = bytearray(data)
        changed[place] ^= 1 << ((place * 5) % 8)
        yield bytes(changed)


def swollen(data: bytes) -> Iterator[bytes]:
    """Yield a file in which one length or offset of a record is huge."""
    for place in _record_starts(data):
        for size in (2**20, 2**31, 2**40, 2**63 - 1, 2**64 - 1):
            for at in (place + 1, place + 9, place + 17, place + 25, place + 41):
                if at + 8 <= len(data):
                    changed = bytearray(data)
                    struct.pack_into('<Q', changed, at, size)
                    yield bytes(changed)


def bombs() -> Iterator[bytes]:
    """Yield bags whose chunks become very much larger than their files."""
    # One frame as large as it says; repeated blocks of the same byte take 4 bytes for 128 kB.
    yield from (_bomb(size, declared) for size in (2**28, BOMB) for declared in (1000, size))


def _bomb(size: int, declared: int) -> bytes:
    """Return a compressed bag whose first chunk decompresses to `size`, but says `declared`."""
    data = seeds.compressed_bag()
    start = next(place for place in _record_starts(data) if data[place] == 0x06)
    content = _zeros(size)
    record = data[start + 9 : start + 9 + 16] + struct.pack('<QI', declared, 0)
    record += struct.pack('<I', 4) + b'zstd' + struct.pack('<Q', len(content)) + content
    made = data[:start] + struct.pack('<BQ', 0x06, len(record)) + record
    # No index: the chunk is found by reading the file through, and opened at once.
    return made + struct.pack('<BQIBQQQI', 0x0F, 4, 0, 0x02, 20, 0, 0, 0) + b'\x89MCAP0\r\n'


@cache
def _zeros(size: int) -> bytes:
    """Return zeros compressed by zstd, made without having them all."""
    compressor, block = zstd.ZstdCompressor(), bytes(2**20)
    parts = [compressor.compress(block) for _ in range(size // len(block))]
    return b''.join([*parts, compressor.flush()])


def _record_starts(data: bytes) -> Iterator[int]:
    place = 8
    while place + 9 <= len(data) - 8:
        yield place
        place += 9 + struct.unpack_from('<Q', data, place + 1)[0]


def all_of(name: str, stride: int = 1) -> Iterator[bytes]:
    """
    Yield the damaged inputs of a reader, none for one that reads no bags.

    :param stride: of the offsets; 1 for every one
    """
    if name in ('bag', 'foreign bag'):
        yield from bombs()
    if name == 'bag':
        yield from cut(seeds.protected_bag(), 41 * stride)
        yield from flipped(seeds.unprotected_bag(), 41 * stride)
        yield from swollen(seeds.unprotected_bag())
    elif name == 'sealed bag':
        yield from cut(seeds.protected_bag(), 41 * stride)
        yield from flipped(seeds.protected_bag(), 11 * stride)
    elif name == 'cut bag':
        yield from cut(seeds.protected_bag(), stride)
    elif name == 'metadata':
        yield from cut(seeds.bag_metadata(), stride)
        yield from flipped(seeds.bag_metadata(), stride)
    elif name == 'foreign bag':
        for data in (seeds.foreign_bag(), seeds.compressed_bag()):
            yield from cut(data, 5 * stride)
            yield from flipped(data, 7 * stride)
            yield from swollen(data)
