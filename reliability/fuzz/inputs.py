"""Inputs by hypothesis: valid ones with something cut, doubled, moved or put in."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import strategies as st

Edit = tuple[str, float, float, bytes]
"""Kind, place and extent as shares of the input, and what is put in."""


def edited(seeds: Sequence[bytes], tokens: Sequence[bytes]) -> st.SearchStrategy[bytes]:
    """Return a strategy for inputs made of seeds by a few edits."""
    share = st.floats(0.0, 1.0, exclude_max=True)
    kinds = st.sampled_from(
        ['insert', 'replace', 'replace line', 'cut', 'double', 'swap lines', 'flip', 'end']
    )
    puts = st.one_of(st.sampled_from(list(tokens)), st.binary(max_size=9), _numbers())
    edits = st.lists(st.tuples(kinds, share, share, puts), min_size=1, max_size=5)
    return st.builds(apply, st.sampled_from(list(seeds)), edits)


def _numbers() -> st.SearchStrategy[bytes]:
    texts = st.one_of(st.floats(), st.integers(-(2**70), 2**70)).map(repr)
    units = st.sampled_from(['', ' m', ' Pa', ' s', ' N', ' m^2', ' -', ' bar gauge'])
    return st.builds(lambda number, unit: f'{number}{unit}'.encode(), texts, units)


def apply(seed: bytes, edits: Sequence[Edit]) -> bytes:
    """Return the input after the edits."""
    for kind, place, extent, put in edits:
        seed = _edit(seed, kind, place, extent, put)
    return seed


def _edit(data: bytes, kind: str, place: float, extent: float, put: bytes) -> bytes:
    start = int(place * len(data))
    end = start + int(extent * min(len(data) - start, 64))
    if kind == 'replace line':
        return _in_line(data, place, put)
    if kind == 'swap lines':
        lines = data.split(b'\n')
        i, j = int(place * len(lines)), int(extent * len(lines))
        lines[i], lines[j] = lines[j], lines[i]
        return b'\n'.join(lines)
    if kind == 'flip' and start < len(data):
        return data[:start] + bytes([data[start] ^ (1 << int(8 * extent))]) + data[start + 1 :]
    middle = {'insert': put + data[start:end], 'replace': put, 'double': 2 * data[start:end],
              'cut': b''}  # fmt: skip
    return data[:start] if kind == 'end' else data[:start] + middle.get(kind, b'') + data[end:]


def _in_line(data: bytes, place: float, put: bytes) -> bytes:
    """Put something in the place of what stands behind the colon of a line."""
    lines = data.split(b'\n')
    at = int(place * len(lines))
    head, colon, _ = lines[at].partition(b': ')
    lines[at] = head + colon + put
    return b'\n'.join(lines)
