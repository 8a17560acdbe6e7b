"""
Reads the signals of text tables - CSV and its relatives - whose columns a mapping names.

Encoding (UTF-8, UTF-16, with or without a byte order mark, else Windows-1252), separator, decimal
sign and header are detected if the mapping omits them, and points or commas between thousands are
ignored. An error names row and column in the file.
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

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.grid import Columns
from pneu_rig_ros.records.mapping import DATETIME, Layout, Source, TableMapping, in_si, unit_of
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS, Floats
from pneu_rig_ros.records.units import parse_unit, scaled

LIKELY_GAUGE = 5e4
"""An absolute pressure below this is probably a gauge pressure [Pa]."""

DETECTION_LINES = 50
"""Lines of data from which the separator is detected."""

_MARKS = (
    (codecs.BOM_UTF8, 'utf-8-sig'),
    (codecs.BOM_UTF16_LE, 'utf-16'),
    (codecs.BOM_UTF16_BE, 'utf-16'),
)
_DECIMAL_COMMA = re.compile(r'\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*')
_CANDIDATES = ('\t', ';', ',', ' ')

Line = tuple[int, str]
"""A line of the file that is not blank, and its number counted from 1."""


@dataclass(frozen=True)
class Cells:
    """
    The cells of a table.

    :param path: of the file
    :param names: of the columns, () in a table without a header
    :param rows: cells of each row of data, all of the same length
    :param numbers: of the rows in the file, counted from 1
    :param decimal: sign
    """

    path: Path
    names: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    numbers: Sequence[int]
    decimal: str

    def index(self, column: str | int, where: str) -> int:
        """Return the index of a column from its name, or its number counted from 1."""
        width = len(self.rows[0])
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
        texts = [row[index] for row in self.rows]
        try:
            values = np.array(self._with_point(texts), dtype=np.float64)
        except ValueError:
            cleaned = self._with_point(without_thousands(texts))
            values = np.array([_number(text) for text in cleaned])
        bad = ~np.isfinite(values)
        if bad.any():
            k = int(bad.argmax())
            raise self.complaint(k, index, self._reason(self.rows[k][index], k))
        return values

    def _with_point(self, texts: list[str]) -> list[str]:
        """Return cells with a point as decimal sign."""
        if self.decimal != ',':
            return texts
        # a single point is then no number: it may be a decimal sign or separate thousands
        return [text.replace('.', '#').replace(',', '.') for text in texts]

    def complaint(self, row: int, index: int, reason: str) -> RigError:
        """Return an error that names row and column of a cell."""
        name = repr(self.names[index]) if self.names else str(index + 1)
        return RigError(f'{self.path}: row {self.numbers[row]}, column {name}: {reason}')

    def _reason(self, text: str, row: int) -> str:
        """Say why a cell is not a number."""
        if not text.strip():
            return 'the cell is empty'
        reason = f'{text.strip()!r} is not a finite number'
        if self.decimal == '.' and _DECIMAL_COMMA.fullmatch(text):
            return f"{reason}; decimal comma? Add to the mapping: decimal: ','"
        if row == 0 and self.names and not any(map(str.isdigit, text)):
            return f'{reason}; a line of units? Add to the mapping: skip_after_header: 1'
        return reason


def without_thousands(texts: list[str]) -> list[str]:
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
        signals[name], gauge = _signal(cells, name, source, f'{mapping.origin}: {name}', zero)
        any_gauge |= gauge
        lowest = signals[name].min()
        if name in PRESSURES and lowest < LIKELY_GAUGE:
            notes.append(f'{name} goes down to {lowest:.4g} Pa absolute: is it gauge?')
    return Columns(time, signals, epoch_ns, any_gauge, tuple(notes))


def _signal(
    cells: Cells, name: str, source: Source, where: str, zero: float
) -> tuple[Floats, bool]:
    """Return a signal in SI units, shape (n,), and whether it was a gauge pressure."""
    assert source.column is not None
    index = cells.index(source.column, where)
    text = source.unit or _unit_in_header(cells, index, where, SIGNALS[name])
    unit = unit_of(source, text, name, where)
    values, gauge = in_si(cells.values(index), name, source, unit, where, zero)
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
        return mapping.interval * np.arange(len(cells.rows), dtype=np.float64), 0
    source, where = mapping.time, f'{mapping.origin}: time'
    assert source.column is not None
    index = cells.index(source.column, where)
    if source.unit == DATETIME:
        time, epoch_ns = _dates(cells, index)
    else:
        unit = parse_unit(source.unit or _unit_in_header(cells, index, where, 's'), 's', where)
        # Rounded as the factor of a unit such as ms is no binary fraction.
        with np.errstate(over='ignore'):  # the grid reports times that are too large
            time, epoch_ns = np.round(scaled(cells.values(index), unit), 12), 0
    steps = np.diff(time)
    if (steps <= 0).any():
        k = int((steps <= 0).argmax()) + 1
        before, after = (cells.rows[i][index].strip() for i in (k - 1, k))
        raise cells.complaint(k, index, f'time {after} comes after {before}; it must increase')
    return time, epoch_ns


def _dates(cells: Cells, index: int) -> tuple[Floats, int]:
    """Return the time since the first date [s], shape (n,), and that date [ns since 1970]."""
    stamps = np.array([_date(row[index]) for row in cells.rows])
    if np.isnat(stamps).any():
        k = int(np.isnat(stamps).argmax())
        reason = f'{cells.rows[k][index]!r} is not a date and time like 2026-01-31T12:00:00.125'
        raise cells.complaint(k, index, reason)
    nanoseconds = stamps.astype(np.int64)
    return (nanoseconds - nanoseconds[0]) * 1e-9, int(nanoseconds[0])


def _date(text: str) -> np.datetime64:
    try:
        return np.datetime64(text.strip().replace(',', '.').removesuffix('Z'), 'ns')
    except ValueError:
        return np.datetime64('NaT', 'ns')


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
    first = _split(lines[0][1], separator)
    head: list[str] = []
    # Without a number in it, the first row is a header.
    is_data = any(not math.isnan(_number(cell.replace(',', '.'))) for cell in first)
    if layout.header or (layout.header is None and not is_data):
        head, lines = first, lines[1:]
    lines = lines[layout.skip_after_header :]
    if not lines:
        raise RigError(f'{path}: no line of data after the header')
    rows = [_split(text, separator) for _, text in lines]
    width, start = len(rows[0]), lines[0][0]
    shown = {'\t': 'tab', ' ': 'blank'}.get(separator, separator)
    hint = f'; separator taken: {shown!r}; the mapping can say another'
    for (number, _), row in zip(lines, rows, strict=True):
        if len(row) != width:
            raise RigError(
                f'{path}: row {number} has {len(row)} cells, row {start} has {width}{hint}'
            )
    if not head and layout.header is None and comments:
        # The last comment before the data may name the columns.
        splits = (_split(comments[-1].strip(), sign) for sign in (separator, *_CANDIDATES))
        head = next((names for names in splits if len(names) == width), [])
    if head and len(head) != width:
        raise RigError(f'{path}: row {start} has {width} cells, the header has {len(head)}{hint}')
    comma = separator != ',' and any(_DECIMAL_COMMA.fullmatch(cell) for cell in rows[0])
    decimal = layout.decimal or (',' if comma else '.')
    names = tuple(name.strip() for name in head)
    return Cells(path, names, rows, [number for number, _ in lines], decimal)


def _lines(path: Path, layout: Layout) -> tuple[list[Line], list[str]]:
    """Return the lines that are not blank, and the comments before the first of them."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RigError(f'{path}: cannot be read: {error.strerror}') from None
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), 'utf-8')
    try:
        content = data.decode(encoding)
    except UnicodeDecodeError:
        content = data.decode('cp1252', errors='replace')
    if '\0' in content:
        raise RigError(f'{path}: is not a text file; export it as CSV')
    lines: list[Line] = []
    comments: list[str] = []
    numbered = enumerate(content.splitlines(), start=1)
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
        counts = {len(_split(text, candidate)) for text in sample}
        if len(counts) == 1 and counts.pop() > 1:
            return candidate
    # A single column, or rows of different lengths, which are reported later.
    return max(_CANDIDATES[:3], key=lambda sign: sum(text.count(sign) for text in sample))


def _split(text: str, separator: str) -> list[str]:
    if separator == ' ':
        return text.split()
    try:
        return next(csv.reader([text], delimiter=separator))
    except csv.Error as error:
        raise RigError(f'{error}, in a row that begins with {text[:40]!r}') from None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
