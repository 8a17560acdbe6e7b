"""
Reads the signals of text tables - CSV and its relatives - whose columns a mapping names.

An error names row and column in the file; `records.cells` reads the cells.
"""

from pathlib import Path

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cells import Cells, read_cells, release_memory
from pneu_rig_ros.records.grid import Columns
from pneu_rig_ros.records.mapping import DATETIME, Source, TableMapping, in_si, unit_of
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS
from pneu_rig_ros.records.units import parse_unit, scaled

LIKELY_GAUGE = 5e4
"""An absolute pressure below this is probably a gauge pressure [Pa]."""


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
    del cells
    release_memory()
    return Columns(time, signals, epoch_ns, any_gauge, tuple(notes))


def _signal(
    cells: Cells, name: str, source: Source, where: str, zero: float
) -> tuple[Floats, bool]:
    """Return a signal in SI units, shape (n,), and whether it was a gauge pressure."""
    values, gauge = _column(cells, name, source, where, zero)
    for number, other in enumerate(source.added, start=2):
        values = values + _column(cells, name, other, f'{where}[{number}]', zero)[0]
    return values, gauge


def _column(
    cells: Cells, name: str, source: Source, where: str, zero: float
) -> tuple[Floats, bool]:
    """Return a column in the SI unit of a signal, and whether it was a gauge pressure."""
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
        return mapping.interval * np.arange(cells.count, dtype=np.float64), 0
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
        before, after = (cells.text(i, index).strip() for i in (k - 1, k))
        raise cells.complaint(k, index, f'time {after} comes after {before}; it must increase')
    return time, epoch_ns


def _dates(cells: Cells, index: int) -> tuple[Floats, int]:
    """Return the time since the first date [s], shape (n,), and that date [ns since 1970]."""
    texts = [text.strip().replace(',', '.').removesuffix('Z') for text in cells.texts(index)]
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
