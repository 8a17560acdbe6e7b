"""
Measured signals of any rig, or of a part of one, as columns in SI units over time.

A record holds every signal of the project's own rig; a table holds what there is. It comes from a
text file or a bag, and a mapping that says where the signals are::

    table = read_table('export.csv', 'map.yaml')
    table['pressure_1']            # absolute [Pa]
    uniform(table).interval        # [s]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.conditions import BAG_FILES
from pneu_rig_ros.records.delimited import Cells, read_cells
from pneu_rig_ros.records.description import configuration_in
from pneu_rig_ros.records.grid import Grid, to_grid
from pneu_rig_ros.records.mapping import (
    DATETIME,
    PRESSURES,
    SIGNALS,
    Source,
    TableMapping,
    read_mapping,
)
from pneu_rig_ros.records.record import Floats
from pneu_rig_ros.records.units import STANDARD_ATMOSPHERE, Unit, convert, parse_unit, scaled
from pneu_rig_ros.rig import RigConfiguration

LIKELY_GAUGE = 5e4
"""An absolute pressure below this is probably a gauge pressure [Pa]."""


@dataclass(frozen=True)
class Table:
    """
    Signals over time, SI units, absolute pressures.

    :param source: file or bag they come from
    :param time: [s], shape (n,), strictly increasing
    :param signals: name -> values, each of shape (n,), finite
    :param epoch_ns: what the time counts from [ns since 1970], 0 where it is not known
    :param atmospheric_pressure: zero of the gauge pressures that were converted [Pa], None if
        there were none
    :param notes: what a person should know of the reading
    :param metadata: custom data of the bag, {} of a text table
    :raises RigError: for different lengths, no sample, or times that do not increase
    """

    source: str
    time: Floats
    signals: Mapping[str, Floats]
    epoch_ns: int = 0
    atmospheric_pressure: float | None = None
    notes: tuple[str, ...] = field(default=())
    metadata: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the lengths and the order of time."""
        for name, values in self.signals.items():
            if values.shape != self.time.shape:
                raise RigError(f'{self.source}: {name} has shape {values.shape}, '
                               f'time has {self.time.shape}')  # fmt: skip
            if not np.isfinite(values).all():
                k = int((~np.isfinite(values)).argmax())
                raise RigError(
                    f'{self.source}: {name} is {values[k]} at sample {k}, must be finite'
                )
        if self.time.size < 2:
            raise RigError(f'{self.source}: {self.time.size} samples, at least 2 are needed')
        if not (np.diff(self.time) > 0).all():
            raise RigError(f'{self.source}: times must increase from sample to sample')

    def __getitem__(self, name: str) -> Floats:
        """Return a signal; RigError if the table does not have it."""
        if name not in self.signals:
            raise RigError(f'{self.source}: {unknown(name, self.signals)}')
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        """Return whether the table has a signal."""
        return name in self.signals

    @property
    def configuration(self) -> RigConfiguration | None:
        """The rig, None if the bag does not say, or it is none."""
        return configuration_in(self.metadata)

    @property
    def interval(self) -> float:
        """Median sampling interval [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def grid(self) -> Grid:
        """The uniform sampling grid under the table, see `pneu_rig_ros.records.grid`."""
        return to_grid(self.time, self.signals, self.epoch_ns)


def read_table(
    path: Path | str,
    mapping: Path | str | Mapping[str, Any] | TableMapping | None = None,
    atmospheric_pressure: float | None = None,
) -> Table:
    """
    Read a text table or a bag.

    :param path: a text file, or a bag's directory
    :param mapping: where the signals are: a YAML file, or what it would hold. A bag of this
        project needs none
    :param atmospheric_pressure: zero of gauge pressures [Pa]; that of the mapping if it has one,
        else 1e5 Pa
    :raises RigError: in one line with row and column for what is wrong in the file
    """
    path = Path(path)
    if is_bag(path):
        from pneu_rig_ros.records.bag_table import read_bag_table

        read = read_mapping(mapping) if mapping is not None else None
        return read_bag_table(path, read, _zero(read, atmospheric_pressure))
    if mapping is None:
        raise RigError(f'{path}: a mapping (--map) must say which column is what, and its unit')
    read = read_mapping(mapping)
    if read.of_bag:
        raise RigError(f'{read.origin}: maps topics of a bag, but {path} is a text table')
    cells = read_cells(path, read.layout)
    time, epoch_ns = _time(cells, read)
    zero = _zero(read, atmospheric_pressure)
    signals, gauge = {}, False
    for name, source in read.signals.items():
        signals[name], counted = _signal(cells, name, source, read.origin, zero)
        gauge |= counted
    notes = _plausibility(signals)
    return Table(str(path), time, signals, epoch_ns, zero if gauge else None, tuple(notes))


def is_bag(path: Path) -> bool:
    """Return whether a path is that of a bag, or of a file in one, and not of a text table."""
    return path.is_dir() or path.suffix in (*BAG_FILES, '.bag')


def uniform(table: Table) -> Table:
    """
    Return the table on its uniform grid, with a note of what that took.

    Where samples are missing the signals are interpolated linearly, voltages held.
    """
    grid = table.grid
    time, signals = grid.filled()
    notes = (*table.notes, *([grid.note] if grid.note else []))
    epoch = 0 if table.epoch_ns == 0 else grid.start_ns
    return replace(table, time=time, signals=signals, epoch_ns=epoch, notes=notes)


def in_si(
    values: Floats, signal: str, source: Source, unit: Unit, where: str, zero: float
) -> tuple[Floats, bool]:
    """
    Return values of a source in SI units, absolute pressures, and whether they were gauge.

    :param unit: of the values before scaling
    :param zero: pressure of the surroundings [Pa]
    """
    si_unit = SIGNALS[signal]
    converted = scaled(values, unit)
    if source.scale is not None and not isinstance(source.scale, str):
        converted = converted * source.scale
    gauge = unit.gauge if source.gauge is None else source.gauge
    if unit.gauge is not None and source.gauge not in (None, unit.gauge):
        raise RigError(f'{where}: the unit says {"gauge" if unit.gauge else "absolute"}, '
                       f'gauge: {str(source.gauge).lower()} says the opposite')  # fmt: skip
    if source.offset is not None:
        converted = converted + convert(source.offset, si_unit, f'{where}.offset')
    return (converted + zero, True) if gauge else (converted, False)


def unit_of(source: Source, text: str, signal: str, where: str) -> Unit:
    """
    Return the unit of a source's values; a scale such as '50 N/V' is worked into the factor.

    :param text: the unit as written
    """
    if not isinstance(source.scale, str):
        return parse_unit(text, SIGNALS[signal], where)
    number, _, scale_unit = source.scale.strip().partition(' ')
    factor = convert(f'{number} -', '-', f'{where}.scale')
    product = parse_unit(f'({scale_unit or "1"})*({text})', SIGNALS[signal], f'{where}.scale')
    return product._replace(factor=product.factor * factor)


def _zero(mapping: TableMapping | None, given: float | None) -> float:
    own = mapping.atmospheric_pressure if mapping else None
    return next((value for value in (own, given) if value is not None), STANDARD_ATMOSPHERE)


def _signal(
    cells: Cells, name: str, source: Source, origin: str, zero: float
) -> tuple[Floats, bool]:
    assert source.column is not None
    where = f'{origin}: {name}'
    index = cells.index(source.column, where)
    unit = unit_of(source, source.unit or _unit_in_header(cells, index, where), name, where)
    values, gauge = in_si(cells.values(index), name, source, unit, where, zero)
    if name in PRESSURES and (values <= 0).any():
        k = int((values <= 0).argmax())
        hint = 'is it gauge? (gauge: true)' if not gauge else 'is the unit right?'
        raise cells.complaint(k, index, f'an absolute pressure of {values[k]:.6g} Pa; {hint}')
    return values, gauge


def _unit_in_header(cells: Cells, index: int, where: str) -> str:
    """Return the unit that a column's name ends with in brackets, such as 'p1 [bar]'."""
    name = cells.names[index] if cells.names else ''
    for opening, closing in ('[]', '()'):
        if name.endswith(closing) and opening in name:
            return name[name.rindex(opening) + 1 : -1]
    signal = where.split(': ')[-1]
    raise RigError(f'{where}: missing unit, such as unit: {SIGNALS.get(signal, "s")}')


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
        written = source.unit or _unit_in_header(cells, index, where)
        unit = parse_unit(written, 's', where)
        # Rounded as the factor of a unit such as ms is no binary fraction.
        with np.errstate(over='ignore'):  # times that are too large are told by the grid
            time, epoch_ns = np.round(scaled(cells.values(index), unit), 12), 0
    steps = np.diff(time)
    if (steps <= 0).any():
        k = int((steps <= 0).argmax()) + 1
        before, after = (cells.rows[i][index].strip() for i in (k - 1, k))
        raise cells.complaint(k, index, f'time {after} comes after {before}; it must increase')
    return time, epoch_ns


def _dates(cells: Cells, index: int) -> tuple[Floats, int]:
    stamps = np.array([_date(text) for text in cells.texts(index)])
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


def _plausibility(signals: Mapping[str, Floats]) -> list[str]:
    return [
        f'{name} goes down to {signals[name].min():.4g} Pa absolute: is it gauge?'
        for name in PRESSURES
        if name in signals and signals[name].min() < LIKELY_GAUGE
    ]
