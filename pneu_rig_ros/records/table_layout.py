"""
The layout of a text table, detected as far as the mapping omits it, and the numbers in its cells.

The layout is encoding (UTF-8, UTF-16, with or without a byte order mark, else Windows-1252),
header, separator and decimal sign. Points or commas between thousands are ignored.
"""

from __future__ import annotations

import codecs
import csv
import itertools
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Union

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.mapping import Layout
from pneu_rig_ros.records.units import as_number

if TYPE_CHECKING:
    from pyarrow import ChunkedArray

DETECTION_LINES = 50
"""Lines of data from which the separator is detected."""

DECIMAL_COMMA = re.compile(r'\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*')
_ONE_SIGN = re.compile(r'\s*[-+]?(?=[.,]?\d)\d*(?P<sign>[.,])\d*([eE][-+]?\d+)?\s*')
# Before three digits it may separate thousands: no number in groups begins with 0, but for 0.000.
_MAY_BE_GROUPED = re.compile(r'\s*[-+]?(?=0*[^\D0]|0+[.,]000)\d+[.,]\d{3}\s*')
_TWO_SIGNS = re.compile(r'\s*[-+]?[\d.]*\d(?P<comma>,)\d*\s*|\s*[-+]?[\d,]*\d\.\d*\s*')
_REPEATED = re.compile(r'([.,])\d*\1')
_CANDIDATES = ('\t', ';', ',', ' ')

Line = tuple[int, str]
"""A line of the file that is not blank, and its number counted from 1."""

Column = Union[Sequence[str], 'ChunkedArray']
"""The texts of a column."""


class DetectedLayout(NamedTuple):
    """What the beginning of a table shows: its first lines of data, and how to read all."""

    lines: list[Line]
    separator: str
    names: tuple[str, ...]
    width: int
    decimal: str
    hint: str


def read_utf8(path: Path) -> bytes:
    """Return the content of a text file, in UTF-8 without a byte order mark."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RigError(f'{path}: cannot be read: {error.strerror}') from None
    if data.isascii():
        content = data  # without a copy: tables are large
    else:
        is_utf_16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        try:
            content = data.decode('utf-16' if is_utf_16 else 'utf-8-sig').encode()
        except UnicodeDecodeError:
            content = data.decode('cp1252', errors='replace').encode()
    if b'\0' in content:
        raise RigError(f'{path}: is not a text file; export it as CSV')
    return content


def detect(path: Path, data: bytes, layout: Layout) -> DetectedLayout:
    """Return the layout of a table, or of its beginning."""
    lines, comments = _lines(data, layout)
    if not lines:
        raise RigError(f'{path}: no line of data')
    separator = layout.separator or _separator(lines, layout)
    first = split(lines[0][1], separator)
    head: list[str] = []
    # Without a number in it, the first row is a header.
    is_data = any(not math.isnan(as_number(cell.replace(',', '.'))) for cell in first)
    if layout.header or (layout.header is None and not is_data):
        head, lines = first, lines[1:]
    lines = lines[layout.skip_after_header :]
    if not lines:
        raise RigError(f'{path}: no line of data after the header')
    row = split(lines[0][1], separator)
    shown = {'\t': 'tab', ' ': 'blank'}.get(separator, separator)
    hint = f'; separator taken: {shown!r}; the mapping can say another'
    if not head and layout.header is None and comments:
        # The last comment before the data may name the columns.
        splits = (split(comments[-1].strip(), sign) for sign in (separator, *_CANDIDATES))
        head = next((names for names in splits if len(names) == len(row)), [])
    if head and len(head) != len(row):
        raise RigError(
            f'{path}: row {lines[0][0]} has {len(row)} cells, the header has {len(head)}{hint}'
        )
    decimal = layout.decimal or ('.' if separator == ',' else _decimal(lines, separator))
    names = tuple(name.strip() for name in head)
    return DetectedLayout(lines, separator, names, len(row), decimal, hint)


def _lines(data: bytes, layout: Layout) -> tuple[list[Line], list[str]]:
    """Return the lines that are not blank, and the comments before the first of them."""
    lines: list[Line] = []
    comments: list[str] = []
    numbered = enumerate(data.decode().splitlines(), start=1)
    for number, text in itertools.islice(numbered, layout.skip_rows, None):
        if layout.comment and text.lstrip().startswith(layout.comment):
            if not lines:
                comments.append(text.lstrip().removeprefix(layout.comment))
        elif text.strip():
            lines.append((number, text))
    return lines, comments


def _separator(lines: Sequence[Line], layout: Layout) -> str:
    """Return the separator that cuts all of the first lines of data into equally many cells."""
    sample = [text for _, text in lines[1 : DETECTION_LINES + 1] or lines]
    for candidate in _CANDIDATES:
        if candidate == ',' == layout.decimal:
            continue
        counts = {len(split(text, candidate)) for text in sample}
        if len(counts) == 1 and counts.pop() > 1:
            return candidate
    # A single column, or rows of different lengths, which are reported later.
    return max(_CANDIDATES[:3], key=lambda sign: sum(text.count(sign) for text in sample))


def _decimal(lines: Sequence[Line], separator: str) -> str:
    """
    Return the decimal sign of the first lines of data.

    Before three digits it may as well separate thousands. Such a cell counts only where no other
    shows the sign, and not in a column with a number that has the sign more than once.
    """
    rows = [split(text, separator) for _, text in lines[:DETECTION_LINES]]
    certain: set[str] = set()
    possible: set[str] = set()
    for column in zip(*rows, strict=False):
        repeated = any(map(_REPEATED.search, column))
        for cell in column:
            if '.' in cell and ',' in cell and (number := _TWO_SIGNS.fullmatch(cell)):
                certain.add(number['comma'] or '.')
            elif not repeated and (number := _ONE_SIGN.fullmatch(cell)):
                (possible if _MAY_BE_GROUPED.fullmatch(cell) else certain).add(number['sign'])
    return ',' if (certain or possible) == {','} else '.'


def split(text: str, separator: str) -> list[str]:
    """Return the cells of a line."""
    if separator == ' ':
        return text.split()
    try:
        return next(csv.reader([text], delimiter=separator))
    except csv.Error as error:
        raise RigError(f'{error}, in a row that begins with {text[:40]!r}') from None


def _without_thousands(texts: Sequence[str]) -> Sequence[str]:
    """
    Return the cells of a column without the sign that separates thousands, if it has one.

    That is a point or comma that a number has more than once, or before the other sign, if it
    stands before three digits in every cell: in 1.075.000 and in 1.075,5.
    """
    several = next((text for text in texts if sum(map(text.count, '.,')) > 1), '')
    if not several:
        return texts
    sign = next(character for character in several if character in '.,')
    other = ',' if sign == '.' else '.'
    grouped = re.compile(rf'\s*[-+]?\d{{1,3}}(\{sign}\d{{3}})*(\{other}\d*)?\s*')
    if not all(map(grouped.fullmatch, texts)):
        return texts
    return [text.replace(sign, '') for text in texts]


def read_texts(data: bytes, start: int, separator: str, width: int) -> list[Column] | None:
    """Return the columns of a table from a byte on; None if irregular or without pyarrow."""
    try:
        import pyarrow
        from pyarrow import csv as arrow
    except ImportError:
        return None
    names = [str(index) for index in range(width)]
    kinds = dict.fromkeys(names, pyarrow.string())
    try:
        table = arrow.read_csv(
            pyarrow.BufferReader(pyarrow.py_buffer(data)[start:]),
            arrow.ReadOptions(column_names=names),
            arrow.ParseOptions(delimiter=separator),
            arrow.ConvertOptions(column_types=kinds, strings_can_be_null=False),
        )
    except pyarrow.ArrowInvalid:
        return None
    return list(table.columns)


def as_texts(column: Column) -> Sequence[str]:
    """Return the cells of a column."""
    return column if isinstance(column, Sequence) else column.to_pylist()


def as_numbers(column: Column, decimal: str) -> Floats:
    """Return the numbers in the cells of a column, shape (n,), NaN where there is none."""
    if not isinstance(column, Sequence) and (numbers := _cast(column, decimal)) is not None:
        return numbers
    texts = as_texts(column)
    try:
        return np.array(_with_point(texts, decimal), dtype=np.float64)
    except ValueError:
        cleaned = _with_point(_without_thousands(texts), decimal)
        return np.array([as_number(text) for text in cleaned])


def _with_point(texts: Sequence[str], decimal: str) -> Sequence[str]:
    """Return cells with a point as decimal sign; another point then makes no number."""
    if decimal == '.':
        return texts
    return [text.replace('.', '#').replace(',', '.') for text in texts]


def _cast(column: ChunkedArray, decimal: str) -> Floats | None:
    """Return the numbers of a column, None unless every cell is a plain number."""
    import pyarrow
    from pyarrow import compute

    texts = compute.utf8_trim_whitespace(column)
    if decimal == ',':
        texts = compute.replace_substring(texts, '.', '#')
        texts = compute.replace_substring(texts, ',', '.')
    try:
        return np.asarray(compute.cast(texts, pyarrow.float64()), dtype=np.float64)
    except pyarrow.ArrowInvalid:
        return None
