"""Hypothesis strategies that damage valid input: edits, single bits, cuts, lengths, bombs."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from functools import cache

from backports import zstd
from hypothesis import strategies as st

from .seeds import compressed_bag

Inputs = st.SearchStrategy[bytes]
Edit = tuple[str, float, float, bytes]
"""Kind, place and extent as shares of the input, and what is inserted."""

BOMB_SIZES = (2**28, 2**31)
"""To which a chunk of some kB decompresses [byte]."""
SHARE = st.floats(0.0, 1.0, exclude_max=True)


def edited(seeds: Sequence[bytes], tokens: Sequence[bytes]) -> Inputs:
    """Return a strategy for inputs made of seeds by a few edits."""
    kinds = st.sampled_from(
        ['insert', 'replace', 'replace line', 'cut', 'double', 'swap lines', 'flip', 'end']
    )
    texts = st.one_of(st.floats(), st.integers(-(2**70), 2**70)).map(repr)
    units = st.sampled_from(['', ' m', ' Pa', ' s', ' N', ' m^2', ' -', ' bar gauge'])
    numbers = st.builds(lambda number, unit: f'{number}{unit}'.encode(), texts, units)
    inserted = st.one_of(st.sampled_from(list(tokens)), st.binary(max_size=9), numbers)
    edits = st.lists(st.tuples(kinds, SHARE, SHARE, inserted), min_size=1, max_size=5)
    return st.builds(_apply, st.sampled_from(list(seeds)), edits)


def _apply(seed: bytes, edits: Sequence[Edit]) -> bytes:
    for edit in edits:
        seed = _edit(seed, *edit)
    return seed


def _edit(data: bytes, kind: str, place: float, extent: float, inserted: bytes) -> bytes:
    start = int(place * len(data))
    end = start + int(extent * min(len(data) - start, 64))
    lines = data.split(b'\n')
    at, other = int(place * len(lines)), int(extent * len(lines))
    if kind == 'replace line':
        head, colon, _ = lines[at].partition(b': ')
        lines[at] = head + colon + inserted
        return b'\n'.join(lines)
    if kind == 'swap lines':
        lines[at], lines[other] = lines[other], lines[at]
        return b'\n'.join(lines)
    if kind == 'flip' and data:
        return _flip(data, place, int(8 * extent))
    middle = {
        'insert': inserted + data[start:end],
        'replace': inserted,
        'double': 2 * data[start:end],
    }.get(kind, b'')
    return data[:start] if kind == 'end' else data[:start] + middle + data[end:]


def _flip(data: bytes, place: float, bit: int) -> bytes:
    at = int(place * len(data))
    return data[:at] + bytes([data[at] ^ (1 << bit)]) + data[at + 1 :]


def flipped(seeds: Sequence[bytes]) -> Inputs:
    """Return a strategy for seeds with one bit changed."""
    return st.builds(_flip, st.sampled_from(list(seeds)), SHARE, st.integers(0, 7))


def cut(seeds: Sequence[bytes]) -> Inputs:
    """Return a strategy for the first bytes of seeds."""
    return st.builds(
        lambda seed, share: seed[: int(share * len(seed))], st.sampled_from(list(seeds)), SHARE
    )


def swollen(bags: Sequence[bytes]) -> Inputs:
    """Return a strategy for MCAP files in which a length or an offset of a record is huge."""
    sizes = st.sampled_from([2**20, 2**31, 2**40, 2**63 - 1, 2**64 - 1])

    def swell(bag: bytes, share: float, field: int, size: int) -> bytes:
        starts = list(_record_starts(bag))
        at = starts[int(share * len(starts))] + field
        return bag[:at] + struct.pack('<Q', size) + bag[at + 8 :]

    fields = st.sampled_from([1, 9, 17, 25, 41])
    return st.builds(swell, st.sampled_from(list(bags)), SHARE, fields, sizes)


def bombs() -> Inputs:
    """Return a strategy for bags of some kB whose first chunk becomes very much larger."""
    return st.builds(_bomb, st.sampled_from(BOMB_SIZES), st.sampled_from([1000, *BOMB_SIZES]))


def _bomb(size: int, declared: int) -> bytes:
    """Return a compressed bag whose first chunk decompresses to `size`, but says `declared`."""
    data = compressed_bag()
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


def _record_starts(bag: bytes) -> Iterator[int]:
    place = 8
    while place + 9 <= len(bag) - 8:
        yield place
        place += 9 + struct.unpack_from('<Q', bag, place + 1)[0]
