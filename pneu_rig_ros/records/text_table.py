"""
Reads the signals of text tables - CSV and its relatives - whose columns a mapping names.

A table that is large and regular is read by pyarrow, column by column, any other row by row: the
result is the same. An error names row and column in the file.
"""

import io
import itertools
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.grid import Columns
from pneu_rig_ros.records.mapping import DATETIME, Layout, Source, TableMapping, in_si
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS
from pneu_rig_ros.records.table_layout import (
    DECIMAL_COMMA,
    DETECTION_LINES,
    Column,
    as_numbers,
    as_texts,
    detect,
    read_texts,
    read_utf8,
    split,
)
from pneu_rig_ros.records.units import parse_unit

LIKELY_GAUGE = 5e4
"""An absolute pressure below this is probably a gauge pressure [Pa]."""

HEAD = 2**18
"""Beginning of a file that shows its layout; a longer one is read by columns [byte]."""


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

    def text(self, row: int, index: int) -> str:
        """Return a cell."""
        return str(self.columns[index][row])

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
        values = as_numbers(self.columns[index], self.decimal)
        bad = ~np.isfinite(values)
        if bad.any():
            k = int(bad.argmax())
            raise self.complaint(k, index, self._reason(self.text(k, index), k))
        return values

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


def read_cells(path: Path | str, layout: Layout) -> Cells:
    """Read a text table; RigError when it has no data or rows of different lengths."""
    path = Path(path)
    data = read_utf8(path)
    if len(data) > HEAD and (cells := _by_columns(path, data, layout)):
        return cells
    detected = detect(path, data, layout)
    rows = [split(text, detected.separator) for _, text in detected.lines]
    numbers = [number for number, _ in detected.lines]
    for number, row in zip(numbers, rows, strict=True):
        if len(row) != detected.width:
            raise RigError(
                f'{path}: row {number} has {len(row)} cells, row {numbers[0]} has '
                f'{detected.width}{detected.hint}'
            )
    columns = list(zip(*rows, strict=True))
    return Cells(path, detected.names, columns, numbers.__getitem__, detected.decimal)


def _by_columns(path: Path, data: bytes, layout: Layout) -> Cells | None:
    """Return the cells of a large table; None if it is not regular enough for pyarrow."""
    try:
        detected = detect(path, data[: data.rfind(b'\n', 0, HEAD) + 1], layout)
    except RigError:
        return None  # the whole file may have what its beginning lacks
    if len(detected.lines) <= DETECTION_LINES or detected.separator == ' ':
        return None
    first, start = detected.lines[0][0], 0
    for _ in range(first - 1):
        start = data.index(b'\n', start) + 1
    if layout.comment and data.find(layout.comment.encode(), start) >= 0:
        return None
    if not data.startswith(detected.lines[0][1].encode(), start):
        return None  # other ends of lines
    columns = read_texts(data, start, detected.separator, detected.width)
    if columns is None:
        return None

    def row_number(row: int) -> int:
        lines = io.BytesIO(read_utf8(path))  # again, rather than keep it: for an error only
        lines.seek(start)
        numbers = (number for number, line in enumerate(lines, start=first) if line.strip())
        return next(itertools.islice(numbers, row, None))

    return Cells(path, detected.names, columns, row_number, detected.decimal)


def read_columns(path: Path, mapping: TableMapping, zero: float) -> Columns:
    """
    Read the mapped columns of a text table.

    :param zero: pressure of the surroundings [Pa], for gauge pressures
    :raises RigError: with row and column of an error in the file
    """
    if mapping.of_bag:
        raise RigError(f'{mapping.origin}: maps topics of a bag, but {path} is a text table')
    cells = read_cells(path, mapping.layout)
    time, epoch_ns = _time(cells, mapping)
    signals, any_gauge, notes = {}, False, []
    for name, source in mapping.signals.items():
        where = f'{mapping.origin}: {name}'
        signals[name], gauge = _column(cells, name, source, where, zero)
        for number, other in enumerate(source.added, start=2):
            signals[name] += _column(cells, name, other, f'{where}[{number}]', zero)[0]
        any_gauge |= gauge
        lowest = signals[name].min()
        if name in PRESSURES and lowest < LIKELY_GAUGE:
            notes.append(f'{name} goes down to {lowest:.4g} Pa absolute: is it gauge?')
    del cells
    if pyarrow := sys.modules.get('pyarrow'):
        pyarrow.default_memory_pool().release_unused()  # it would keep the memory of the table
    return Columns(time, signals, epoch_ns, any_gauge, tuple(notes))


def _column(
    cells: Cells, name: str, source: Source, where: str, zero: float
) -> tuple[Floats, bool]:
    """Return a column in the SI unit of a signal, and whether it was a gauge pressure."""
    assert source.column is not None
    index = cells.index(source.column, where)
    text = source.unit or _unit_in_header(cells, index, where, SIGNALS[name])
    values, gauge = in_si(cells.values(index), name, source, text, where, zero)
    if name in PRESSURES and (values <= 0).any():
        k = int((values <= 0).argmax())
        hint = 'is it gauge? (gauge: true)' if not gauge else 'is the unit right?'
        raise cells.complaint(k, index, f'an absolute pressure of {values[k]:.6g} Pa; {hint}')
    return values, gauge


def _unit_in_header(cells: Cells, index: int, where: str, example: str) -> str:
    """Return the unit that a column's name ends with in brackets, such as 'p1 [bar]'."""
    name = cells.names[index] if cells.names else ''
    for opening, closing in ('[]', '()'):
        if name.endswith(closing) and opening in name:
            return name[name.rindex(opening) + 1 : -1]
    raise RigError(f'{where}: missing unit, such as unit: {example}')


def _time(cells: Cells, mapping: TableMapping) -> tuple[Floats, int]:
    """Return the time [s], shape (n,), and what it counts from [ns]."""
    if mapping.time is None:
        assert mapping.interval is not None
        return mapping.interval * np.arange(len(cells.columns[0]), dtype=np.float64), 0
    source, where = mapping.time, f'{mapping.origin}: time'
    assert source.column is not None
    index = cells.index(source.column, where)
    if source.unit == DATETIME:
        time, epoch_ns = _dates(cells, index)
    else:
        unit = parse_unit(source.unit or _unit_in_header(cells, index, where, 's'), 's', where)
        # Rounded as the factor of a unit such as ms is no binary fraction.
        with np.errstate(over='ignore'):  # the grid reports times that are too large
            time, epoch_ns = np.round(cells.values(index) * unit.factor, 12), 0
    steps = np.diff(time)
    if (steps <= 0).any():
        k = int((steps <= 0).argmax()) + 1
        before, after = (cells.text(i, index).strip() for i in (k - 1, k))
        raise cells.complaint(k, index, f'time {after} comes after {before}; it must increase')
    return time, epoch_ns


def _dates(cells: Cells, index: int) -> tuple[Floats, int]:
    """Return the time since the first date [s], shape (n,), and that date [ns since 1970]."""
    texts = [
        text.strip().replace(',', '.').removesuffix('Z') for text in as_texts(cells.columns[index])
    ]
    try:
        stamps = np.array(texts, dtype='datetime64[ns]')
    except ValueError:
        stamps = np.array([_date(text) for text in texts])
    if np.isnat(stamps).any():
        k = int(np.isnat(stamps).argmax())
        reason = f'{cells.text(k, index)!r} is not a date and time like 2026-01-31T12:00:00.125'
        raise cells.complaint(k, index, reason)
    nanoseconds = stamps.astype(np.int64)
    return (nanoseconds - nanoseconds[0]) * 1e-9, int(nanoseconds[0])


def _date(text: str) -> np.datetime64:
    try:
        return np.datetime64(text, 'ns')
    except ValueError:
        return np.datetime64('NaT', 'ns')
