"""
Reads the cells of text tables.

Points or commas between thousands are ignored. A table that is large and regular is read by
pyarrow, column by column, any other row by row: the result is the same.
"""

from __future__ import annotations

import io
import itertools
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Union

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.mapping import Layout
from pneu_rig_ros.records.table_form import (
    DECIMAL_COMMA,
    DETECTION_LINES,
    detect,
    read_utf8,
    split,
)
from pneu_rig_ros.records.units import as_number

if TYPE_CHECKING:
    from pyarrow import ChunkedArray

Column = Union[Sequence[str], 'ChunkedArray']
"""The texts of a column."""


def read_texts(data: bytes, start: int, separator: str, width: int) -> list[Column] | None:
    """
    Return the columns of a table, None if it is not regular or pyarrow is not installed.

    :param data: UTF-8
    :param start: of the first row of data [byte]
    :param width: cells of a row
    """
    try:
        import pyarrow
        from pyarrow import csv
    except ImportError:
        return None
    names = [str(index) for index in range(width)]
    kinds = dict.fromkeys(names, pyarrow.string())
    try:
        table = csv.read_csv(
            pyarrow.BufferReader(pyarrow.py_buffer(data)[start:]),
            csv.ReadOptions(column_names=names),
            csv.ParseOptions(delimiter=separator),
            csv.ConvertOptions(column_types=kinds, strings_can_be_null=False),
        )
    except pyarrow.ArrowInvalid:
        return None
    return list(table.columns)


def as_numbers(column: ChunkedArray, decimal: str) -> Floats | None:
    """Return the numbers of a column, shape (n,); None if a cell is not a plain number."""
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


def release_memory() -> None:
    """Return the memory of tables that are gone to the system; pyarrow would keep it."""
    if pyarrow := sys.modules.get('pyarrow'):
        pyarrow.default_memory_pool().release_unused()


HEAD = 2**18
"""Beginning of a file from which its form is detected; a longer one is read by columns [byte]."""


@dataclass(frozen=True)
class Cells:
    """
    The cells of a table.

    :param names: of the columns, () in a table without a header
    :param columns: cells of each column, all of the same length
    :param row_number: returns the number of a row of data in the file, counted from 1
    """

    path: Path
    names: tuple[str, ...]
    columns: Sequence[Column]
    row_number: Callable[[int], int]
    decimal: str

    @property
    def count(self) -> int:
        """Number of rows of data."""
        return len(self.columns[0])

    def text(self, row: int, index: int) -> str:
        """Return a cell."""
        return str(self.columns[index][row])

    def texts(self, index: int) -> Sequence[str]:
        """Return the cells of a column."""
        column = self.columns[index]
        return column if isinstance(column, Sequence) else column.to_pylist()

    def index(self, column: str | int, where: str) -> int:
        """Return the index of a column from its name, or its number counted from 1."""
        width = len(self.columns)
        if isinstance(column, int):
            if column > width:
                raise RigError(f'{where}: column {column}, {self.path} has {width}')
            return column - 1
        if not self.names:
            raise RigError(
                f'{where}: column {column!r}, but {self.path} has no header; '
                f'give a number, 1 to {width}'
            )
        matches = [i for i, name in enumerate(self.names) if name == column.strip()]
        if not matches:
            shown = [name for name in self.names if name]
            raise RigError(f'{where}: column of {self.path}: {unknown(column, shown)}')
        if len(matches) > 1:
            numbers = ', '.join(str(i + 1) for i in matches)
            raise RigError(
                f'{where}: {self.path} has several columns {column!r}; give a number: {numbers}'
            )
        return matches[0]

    def values(self, index: int) -> Floats:
        """Return a column as numbers, shape (n,); RigError with row and column of other text."""
        column = self.columns[index]
        quick = None if isinstance(column, Sequence) else as_numbers(column, self.decimal)
        values = self._numbers(self.texts(index)) if quick is None else quick
        bad = ~np.isfinite(values)
        if bad.any():
            k = int(bad.argmax())
            raise self.complaint(k, index, self._reason(self.text(k, index), k))
        return values

    def _numbers(self, texts: Sequence[str]) -> Floats:
        """Return texts as numbers, NaN where one is none."""
        try:
            return np.array(self._with_point(texts), dtype=np.float64)
        except ValueError:
            cleaned = self._with_point(without_thousands(texts))
            return np.array([as_number(text) for text in cleaned])

    def _with_point(self, texts: Sequence[str]) -> Sequence[str]:
        """Return cells with a point as decimal sign."""
        if self.decimal != ',':
            return texts
        # a single point is then no number: it may be a decimal sign or separate thousands
        return [text.replace('.', '#').replace(',', '.') for text in texts]

    def complaint(self, row: int, index: int, reason: str) -> RigError:
        """Return an error that names row and column of a cell."""
        name = repr(self.names[index]) if self.names else str(index + 1)
        return RigError(f'{self.path}: row {self.row_number(row)}, column {name}: {reason}')

    def _reason(self, text: str, row: int) -> str:
        """Say why a cell is not a number."""
        if not text.strip():
            return 'the cell is empty'
        reason = f'{text.strip()!r} is not a finite number'
        if self.decimal == '.' and DECIMAL_COMMA.fullmatch(text):
            return f"{reason}; decimal comma? Add to the mapping: decimal: ','"
        if row == 0 and self.names and not any(map(str.isdigit, text)):
            return f'{reason}; a line of units? Add to the mapping: skip_after_header: 1'
        return reason


def without_thousands(texts: Sequence[str]) -> Sequence[str]:
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


def read_cells(path: Path | str, layout: Layout) -> Cells:
    """
    Read a text table.

    :raises RigError: when it cannot be read, has no data, or rows of different lengths
    """
    path = Path(path)
    data = read_utf8(path)
    if len(data) > HEAD and (cells := _by_columns(path, data, layout)):
        return cells
    form = detect(path, data, layout)
    rows = [split(text, form.separator) for _, text in form.lines]
    numbers = [number for number, _ in form.lines]
    for number, row in zip(numbers, rows, strict=True):
        if len(row) != form.width:
            raise RigError(
                f'{path}: row {number} has {len(row)} cells, row {numbers[0]} has '
                f'{form.width}{form.hint}'
            )
    columns = list(zip(*rows, strict=True))
    return Cells(path, form.names, columns, numbers.__getitem__, form.decimal)


def _by_columns(path: Path, data: bytes, layout: Layout) -> Cells | None:
    """Return the cells of a large table; None if it is not regular enough for pyarrow."""
    try:
        form = detect(path, data[: data.rfind(b'\n', 0, HEAD) + 1], layout)
    except RigError:
        return None  # the whole file may have what its beginning lacks
    if len(form.lines) <= DETECTION_LINES or form.separator == ' ':
        return None
    first, start = form.lines[0][0], 0
    for _ in range(first - 1):
        start = data.index(b'\n', start) + 1
    if layout.comment and data.find(layout.comment.encode(), start) >= 0:
        return None
    if not data.startswith(form.lines[0][1].encode(), start):
        return None  # other ends of lines
    columns = read_texts(data, start, form.separator, form.width)
    if columns is None:
        return None

    def row_number(row: int) -> int:
        lines = io.BytesIO(read_utf8(path))  # again, rather than keep it: for an error only
        lines.seek(start)
        numbers = (number for number, line in enumerate(lines, start=first) if line.strip())
        return next(itertools.islice(numbers, row, None))

    return Cells(path, form.names, columns, row_number, form.decimal)
