"""Writes the signals of a bag as CSV or Parquet, one column a signal, its unit in the name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.conditions import format_conditions
from pneu_rig_ros.records.reader import read_recording
from pneu_rig_ros.records.recording import SIGNALS
from pneu_rig_ros.records.whole_files import atomic_write


class Column(NamedTuple):
    """One signal: name with unit, as 'velocity_m_per_s', SI unit, values (NaN if missing)."""

    title: str
    unit: str
    values: NDArray[Any]


class Signals(NamedTuple):
    """All signals of a bag on its grid, and the metadata of the bag with its conditions."""

    columns: Sequence[Column]
    metadata: Mapping[str, str]


def read_signals(bag: Path | str) -> Signals:
    """
    Read everything that a bag has on its sampling grid.

    A bag of a part of a rig gives the signals that it has.

    :raises RigError: when it is not a bag, or is cut off
    """
    recording = read_recording(bag)
    columns = [Column('stamp_ns', 'ns', recording.stamps), Column('time_s', 's', recording.time)]
    for name, unit in SIGNALS.items():
        if name in recording:
            title = f'{name}_{unit.replace("/", "_per_")}'
            columns.append(Column(title, unit, recording[name]))
    conditions = format_conditions(recording.conditions)
    return Signals(columns, {**recording.metadata, 'conditions': conditions})


def write_csv(signals: Signals, path: Path) -> Path:
    """Write a CSV file with a header; a missing value is an empty cell."""

    def texts(column: Column) -> list[str]:
        digits = {'stamp_ns': 'd', 'time_s': '.9f'}.get(column.title, '.10g')
        return ['' if value != value else f'{value:{digits}}' for value in column.values.tolist()]

    def write(file: Path) -> None:
        rows = zip(*map(texts, signals.columns), strict=True)
        with file.open('w', encoding='utf-8', newline='') as stream:
            stream.write(','.join(column.title for column in signals.columns) + '\n')
            stream.writelines(','.join(row) + '\n' for row in rows)

    return atomic_write(path, write)


def write_parquet(signals: Signals, path: Path) -> Path:
    """Write a Parquet file: units in the metadata of fields, those of the bag in the schema."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise RigError('Parquet needs the package pyarrow: pip install pyarrow') from error
    arrays = [pyarrow.array(column.values, from_pandas=True) for column in signals.columns]
    fields = [
        pyarrow.field(column.title, array.type, metadata={'unit': column.unit})
        for column, array in zip(signals.columns, arrays, strict=True)
    ]
    table = pyarrow.table(arrays, pyarrow.schema(fields, metadata=dict(signals.metadata)))
    return atomic_write(path, lambda file: parquet.write_table(table, file, compression='zstd'))
