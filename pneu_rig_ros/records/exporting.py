"""Writes the signals of a bag as CSV or Parquet, one column a signal, its unit in the name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.conditions import format_conditions
from pneu_rig_ros.records.reader import read_recording
from pneu_rig_ros.records.recording import SIGNALS, Recording


class Column(NamedTuple):
    """
    One signal.

    :param name: of the signal
    :param unit: SI
    :param values: shape (n,); NaN for a missing value
    """

    name: str
    unit: str
    values: NDArray[Any]

    @property
    def title(self) -> str:
        """Name and unit, such as 'velocity_m_per_s'."""
        return f'{self.name}_{self.unit.replace("/", "_per_")}'


class Signals(NamedTuple):
    """
    All signals of a bag on its grid.

    :param columns: stamp [ns] and time since the first sample [s] first
    :param metadata: of the bag, with its conditions
    """

    columns: Sequence[Column]
    metadata: Mapping[str, str]


def read_signals(bag: Path | str) -> Signals:
    """
    Read everything that a bag has on its sampling grid.

    A bag of a part of a rig gives the signals that it has.

    :raises RigError: when it is no bag, or is cut off
    """
    recording = read_recording(bag)
    conditions = format_conditions(recording.conditions)
    metadata = {**recording.metadata, 'conditions': conditions}
    return Signals(_columns(recording), metadata)


def _columns(recording: Recording) -> list[Column]:
    first = [Column('stamp', 'ns', recording.stamps), Column('time', 's', recording.time)]
    return first + [
        Column(name, SIGNALS[name], recording[name]) for name in SIGNALS if name in recording
    ]


def write_csv(signals: Signals, path: Path) -> Path:
    """Write a CSV file with a header; a missing value is an empty cell."""
    return atomic_write(path, lambda file: _write_csv(signals.columns, file))


def write_parquet(signals: Signals, path: Path) -> Path:
    """Write a Parquet file: units in the metadata of fields, those of the bag in the schema."""
    return atomic_write(path, lambda file: _write_parquet(signals, file))


def _write_csv(columns: Sequence[Column], path: Path) -> None:
    texts = [_texts(column) for column in columns]
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(','.join(column.title for column in columns) + '\n')
        file.writelines(','.join(row) + '\n' for row in zip(*texts, strict=True))


def _texts(column: Column) -> list[str]:
    if column.values.dtype == np.int64:
        return [str(value) for value in column.values.tolist()]
    digits = '.9f' if column.name == 'time' else '.10g'
    return ['' if value != value else f'{value:{digits}}' for value in column.values.tolist()]


def _write_parquet(signals: Signals, path: Path) -> None:
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
    schema = pyarrow.schema(fields, metadata=dict(signals.metadata))
    parquet.write_table(pyarrow.table(arrays, schema=schema), path, compression='zstd')
