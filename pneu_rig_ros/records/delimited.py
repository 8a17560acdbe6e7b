"""
Reads text tables - CSV and its relatives - cell by cell, and knows the row of each in the file.

Encoding (UTF-8, UTF-16, with or without a byte order mark, else Windows-1252), separator, decimal
sign and header are detected if the mapping omits them.
"""

from __future__ import annotations

import codecs
import csv
import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.mapping import Layout

DETECTION_LINES = 50
"""Lines of data from which the separator is detected."""

_MARKS = (
    (codecs.BOM_UTF8, 'utf-8-sig'),
    (codecs.BOM_UTF16_LE, 'utf-16'),
    (codecs.BOM_UTF16_BE, 'utf-16'),
)
_DECIMAL_COMMA = re.compile(r'\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*')
_CANDIDATES = ('\t', ';', ',', ' ')


class Line(NamedTuple):
    """A line and its number in the file, counted from 1."""

    number: int
    text: str


@dataclass(frozen=True)
class Cells:
    """
    The cells of a table.

    :param path: of the file
    :param names: of the columns, () in a table without a header
    :param rows: cells of each row of data, all of the same length
    :param numbers: of the rows in the file, counted from 1
    :param separator: between cells
    :param decimal: sign
    """

    path: Path
    names: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    numbers: Sequence[int]
    separator: str
    decimal: str

    def index(self, column: str | int, where: str) -> int:
        """Return the index of a column from its name, or its number counted from 1."""
        if isinstance(column, int):
            if column > len(self.rows[0]):
                raise RigError(f'{where}: column {column}, {self.path} has {len(self.rows[0])}')
            return column - 1
        if not self.names:
            raise RigError(
                f'{where}: column {column!r}, but {self.path} has no header; '
                f'give a number, 1 to {len(self.rows[0])}'
            )
        found = [i for i, name in enumerate(self.names) if name == column.strip()]
        if not found:
            shown = [name for name in self.names if name]
            raise RigError(f'{where}: column of {self.path}: {unknown(column, shown)}')
        if len(found) > 1:
            numbers = ', '.join(str(i + 1) for i in found)
            raise RigError(
                f'{where}: {self.path} has several columns {column!r}; give a number: {numbers}'
            )
        return found[0]

    def texts(self, index: int) -> list[str]:
        """Return the cells of a column."""
        return [row[index] for row in self.rows]

    def values(self, index: int) -> NDArray[np.float64]:
        """Return a column as numbers, shape (n,); RigError with row and column of other text."""
        texts = self.texts(index)
        if self.decimal == ',':
            texts = [text.replace('.', '#').replace(',', '.') for text in texts]
        try:
            values = np.array(texts, dtype=np.float64)
        except ValueError:
            values = np.array([_number(text) for text in texts])
        bad = ~np.isfinite(values)
        if bad.any():
            k = int(bad.argmax())
            raise self.complaint(k, index, self._reason(self.rows[k][index], k))
        return values

    def complaint(self, row: int, index: int, reason: str) -> RigError:
        """Return an error that names row and column of a cell."""
        name = repr(self.names[index]) if self.names else str(index + 1)
        return RigError(f'{self.path}: row {self.numbers[row]}, column {name}: {reason}')

    def _reason(self, text: str, row: int) -> str:
        if not text.strip():
            return 'the cell is empty'
        reason = f'{text.strip()!r} is not a finite number'
        if self.decimal == '.' and _DECIMAL_COMMA.fullmatch(text):
            return f"{reason}; decimal comma? Add to the mapping: decimal: ','"
        if row == 0 and self.names and not any(map(str.isdigit, text)):
            return f'{reason}; a line of units? Add to the mapping: skip_after_header: 1'
        return reason


def read_cells(path: Path | str, layout: Layout) -> Cells:
    """
    Read a text table.

    :raises RigError: when it cannot be read, has no data, or rows of different lengths
    """
    path = Path(path)
    lines, comments = _lines(path, layout)
    if not lines:
        raise RigError(f'{path}: no line of data')
    separator = layout.separator or _separator(lines, layout)
    first = _split(lines[0].text, separator)
    head: list[str] = []
    if layout.header or (layout.header is None and not _numeric(first)):
        head, lines = first, lines[1:]
    lines = lines[layout.skip_after_header :]
    if not lines:
        raise RigError(f'{path}: no line of data after the header')
    rows = _rows(path, lines, separator)
    if not head and layout.header is None:
        head = _comment_head(comments, separator, len(rows[0]))
    if head and len(head) != len(rows[0]):
        raise RigError(
            f'{path}: row {lines[0].number} has {len(rows[0])} cells, the header has '
            f'{len(head)}{_hint(separator)}'
        )
    decimal = layout.decimal or _decimal(rows[0], separator)
    numbers = [line.number for line in lines]
    return Cells(path, tuple(name.strip() for name in head), rows, numbers, separator, decimal)


def _lines(path: Path, layout: Layout) -> tuple[list[Line], list[str]]:
    """Return the lines that are not blank, and the comments before the first of them."""
    lines: list[Line] = []
    comments: list[str] = []
    numbered = enumerate(_text(path).splitlines(), start=1)
    for number, text in itertools.islice(numbered, layout.skip_rows, None):
        if layout.comment and text.lstrip().startswith(layout.comment):
            if not lines:
                comments.append(text.lstrip().removeprefix(layout.comment))
        elif text.strip():
            lines.append(Line(number, text))
    return lines, comments


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RigError(f'{path}: cannot be read: {error.strerror}') from None
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), 'utf-8')
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        text = data.decode('cp1252', errors='replace')
    if '\0' in text:
        raise RigError(f'{path}: is not a text file; export it as CSV')
    return text


def _separator(lines: Sequence[Line], layout: Layout) -> str:
    """Return the separator that cuts all of the last looked-at lines into equally many cells."""
    sample = [line.text for line in lines[1 : DETECTION_LINES + 1] or lines]
    for candidate in _CANDIDATES:
        if candidate == ',' == layout.decimal:
            continue
        counts = {len(_split(text, candidate)) for text in sample}
        if len(counts) == 1 and counts.pop() > 1:
            return candidate
    # A single column, or rows of different lengths, which are reported later.
    return max(_CANDIDATES[:3], key=lambda sign: sum(text.count(sign) for text in sample))


def _decimal(row: Sequence[str], separator: str) -> str:
    comma = separator != ',' and any(_DECIMAL_COMMA.fullmatch(cell) for cell in row)
    return ',' if comma else '.'


def _split(text: str, separator: str) -> list[str]:
    if separator == ' ':
        return text.split()
    try:
        return next(csv.reader([text], delimiter=separator))
    except csv.Error as error:
        raise RigError(f'{error}, in a row that begins with {text[:40]!r}') from None


def _rows(path: Path, lines: Sequence[Line], separator: str) -> list[list[str]]:
    rows = [_split(line.text, separator) for line in lines]
    width = len(rows[0])
    for line, row in zip(lines, rows, strict=True):
        if len(row) != width:
            raise RigError(
                f'{path}: row {line.number} has {len(row)} cells, '
                f'row {lines[0].number} has {width}{_hint(separator)}'
            )
    return rows


def _hint(separator: str) -> str:
    named = {'\t': 'tab', ' ': 'blank'}.get(separator, separator)
    return f'; separator taken: {named!r}; the mapping can say another'


def _comment_head(comments: Sequence[str], separator: str, width: int) -> list[str]:
    """Return the names in the last comment before the data, if it has one for each column."""
    for sign in (separator, *_CANDIDATES) if comments else ():
        names = _split(comments[-1].strip(), sign)
        if len(names) == width:
            return names
    return []


def _numeric(cells: Sequence[str]) -> bool:
    """Return whether a row looks like data: any cell is a number."""
    return any(not math.isnan(_number(cell.replace(',', '.'))) for cell in cells)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
