"""
Writes measured signals as a bag, in the form in which the recorder writes one, and bags as tables.

Position and both pressures make a bag that every command reads; fewer signals make one of a part
of a rig. A measured force goes on a topic `force`, in the form of `friction`. A table has one
column a signal, its unit in the name.
"""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Flags
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.atomic_write import atomic_write, writing
from pneu_rig_ros.records.cdr_encoding import NANOSECONDS, fill_rows, pack_string, template
from pneu_rig_ros.records.conditions import (
    FILE_NAME,
    apply_conditions,
    check_plausible,
    format_conditions,
    with_zero,
)
from pneu_rig_ros.records.description import bag_metadata, describe, git_revision, package_version
from pneu_rig_ros.records.recording import SIGNALS, Recording, Stamps
from pneu_rig_ros.records.topics import STRING
from pneu_rig_ros.records.writer import BagWriter, TopicRows
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.urdf import robot_description

Progress = Callable[[int], None]
"""Callback with the number of samples written."""

BLOCK = 3000
"""Samples whose messages are made and written together: a chunk of about 1 MB."""

LEAST_INTERVAL, MOST_INTERVAL = 100_000, 1_000_000_000
"""Between two samples [ns]."""

END_OF_STAMPS = 2**31
"""First second since 1970 that the stamp of a message cannot hold."""

SOURCES = {
    'joint_states': ('position',),
    'position': ('joint_states',),
    'velocity': ('joint_states', 'position'),
    'chamber_1/pressure': ('pressure_1',),
    'chamber_2/pressure': ('pressure_2',),
    'valve_voltages': ('u', 'voltage_1', 'voltage_2'),
}
"""Topic -> signals and topics whose missing samples it shares."""

NUMBERS = {
    'u': ('u',),
    'valve_voltages': ('voltage_1', 'voltage_2'),
    'joint_states': ('position', 'velocity'),
    'position': ('position',),
    'velocity': ('velocity',),
    'chamber_1/pressure': ('pressure_1',),
    'chamber_2/pressure': ('pressure_2',),
    'force': ('force',),
    'friction': ('friction',),
}
"""
Topic -> signals in its messages, in the order in which the topics of a sample are written:
commands before the sample that finds them in force.
"""


def write_bag(
    recording: Recording,
    out: Path | str,
    conditions: Mapping[str, float] = {},
    configuration: RigConfiguration | None = None,
    progress: Progress = lambda _: None,
) -> None:
    """
    Write a recording as a bag.

    The bag is written atomically. Missing samples stay missing. Without `voltage_1`
    and `voltage_2` the valve voltages follow from `u` by Eq. 1, if it was recorded.

    :param out: the bag's directory, must not exist
    :param conditions: written to ``conditions.yaml`` in the bag, with those of the recording and
        the atmospheric pressure that gauge pressures were converted with
    :param configuration: the rig, if known; written to the bag under these conditions
    :param progress: called with the number of samples written
    :raises RigError: when the bag exists or cannot be written, or a voltage lacks the other
    """
    out, source = Path(out), recording.metadata.get('source', recording.name)
    if out.exists():
        raise RigError(f'{out} exists; name a bag that does not, or remove it')
    known = with_zero({**recording.conditions, **conditions}, recording.atmospheric_pressure)
    if configuration is not None:
        configuration = apply_conditions(configuration, known)
        check_plausible(source, recording.signals, configuration)
    if not LEAST_INTERVAL <= recording.interval_ns <= MOST_INTERVAL:
        raise RigError(
            f'{source}: a sample every {recording.interval_ns * 1e-6:g} ms, allowed '
            'are 0.1 to 1000 ms; is the time in another unit?'
        )
    if int(recording.stamps[-1]) >= END_OF_STAMPS * NANOSECONDS:
        raise RigError(f'{source}: stamps after January 2038, which a message cannot hold')
    with writing(f'the bag {out}'):
        out.parent.mkdir(parents=True, exist_ok=True)
        # On the same file system, so that the bag can be moved in one step.
        with tempfile.TemporaryDirectory(prefix=f'.{out.name}.', dir=out.parent) as folder:
            bag = Path(folder, out.name)  # under its final name, which is in the metadata
            _write(bag, recording, configuration, progress)
            if known:
                (bag / FILE_NAME).write_text(format_conditions(known), encoding='utf-8')
            bag.replace(out)


def _write(
    path: Path, recording: Recording, configuration: RigConfiguration | None, progress: Progress
) -> None:
    metadata = {
        'source': recording.metadata.get('source', recording.name),
        'package_version': package_version(),
        'git_revision': git_revision(),
    }
    with BagWriter(path) as writer:
        if configuration is not None:
            sampled = replace(configuration, interval_ns=recording.interval_ns)
            description = describe(sampled)
            metadata |= bag_metadata(description)
            # A real rig has neither; those in the description belong to its model.
            del metadata['friction_model'], metadata['seed']
            robot = robot_description(sampled)
            for name, text in {'rig_description': description, 'robot_description': robot}.items():
                writer.write(f'/{name}', STRING, recording.start_ns, pack_string(text))
        for number, (stamps, rows) in enumerate(_blocks(recording)):
            progress(number * BLOCK)
            writer.write_rows(rows, stamps)
        writer.close(metadata)
    progress(recording.size)


def _blocks(recording: Recording) -> Iterator[tuple[Stamps, list[TopicRows]]]:
    """Yield stamps [ns] and messages of every few thousand samples."""
    if ('voltage_1' in recording) != ('voltage_2' in recording):
        given = 'voltage_1' if 'voltage_1' in recording else 'voltage_2'
        raise RigError(f'{given} without the other valve; map voltage_1 and voltage_2, or u')
    signals = dict(recording.signals)
    if 'position' in recording:
        signals['velocity'] = recording.velocity
    if recording.driven:
        signals |= {'voltage_1': recording.voltage_1, 'voltage_2': recording.voltage_2}
    templates = {
        topic: template(topic)
        for topic, names in NUMBERS.items()
        if all(name in signals for name in names)
    }
    present = {topic: _present(recording, topic) for topic in templates}
    stamps = recording.stamps
    for first in range(0, recording.size, BLOCK):
        part = slice(first, first + BLOCK)
        rows = [
            TopicRows(
                topic,
                message.type,
                fill_rows(message, stamps[part], [signals[name][part] for name in NUMBERS[topic]]),
                present[topic][part],
            )
            for topic, message in templates.items()
        ]
        yield stamps[part], rows


def _present(recording: Recording, topic: str) -> Flags:
    """Return which samples are not missing on a topic, shape (n,)."""
    present = np.ones(recording.size, dtype=np.bool_)
    if topic == 'friction':
        present = np.isfinite(recording.friction)
    for source in (topic, *SOURCES.get(topic, ())):
        if len(missing := recording.missing.get(source, ())):
            present &= ~np.isin(recording.stamps, missing)
    return present


class Column(NamedTuple):
    """One signal: its name, SI unit and values (NaN if missing)."""

    name: str
    unit: str
    values: NDArray[Any]

    @property
    def title(self) -> str:
        """Name with unit, as 'velocity_m_per_s'."""
        return f'{self.name}_{self.unit.replace("/", "_per_")}'


def read_signals(bag: Path | str) -> tuple[list[Column], dict[str, str]]:
    """
    Read everything that a bag has on its sampling grid.

    A bag of a part of a rig gives the signals that it has.

    :return: the signals, and the metadata of the bag with its conditions
    :raises RigError: when it is not a bag, or is cut off
    """
    recording = read_recording(bag)
    columns = [Column('stamp', 'ns', recording.stamps), *columns_of(recording, SIGNALS)]
    conditions = format_conditions(recording.conditions)
    return columns, {**recording.metadata, 'conditions': conditions}


def columns_of(recording: Recording, names: Iterable[str]) -> list[Column]:
    """Return the time, and of some signals those that a recording has."""
    there = (name for name in names if name in recording)
    signals = (Column(name, SIGNALS[name], recording[name]) for name in there)
    return [Column('time', 's', recording.time), *signals]


def write_csv(columns: Sequence[Column], path: Path) -> Path:
    """Write a CSV file with a header; a missing value is an empty cell."""

    def texts(column: Column) -> list[str]:
        digits = {'stamp_ns': 'd', 'time_s': '.9f'}.get(column.title, '.10g')
        return ['' if value != value else f'{value:{digits}}' for value in column.values.tolist()]

    def write(file: Path) -> None:
        rows = zip(*map(texts, columns), strict=True)
        with file.open('w', encoding='utf-8', newline='') as stream:
            stream.write(','.join(column.title for column in columns) + '\n')
            stream.writelines(','.join(row) + '\n' for row in rows)

    return atomic_write(path, write)


def write_parquet(columns: Sequence[Column], metadata: Mapping[str, str], path: Path) -> Path:
    """Write a Parquet file: units in the metadata of fields, those of the bag in the schema."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise RigError('Parquet needs the package pyarrow: pip install pyarrow') from error
    arrays = [pyarrow.array(column.values, from_pandas=True) for column in columns]
    fields = [
        pyarrow.field(column.title, array.type, metadata={'unit': column.unit})
        for column, array in zip(columns, arrays, strict=True)
    ]
    table = pyarrow.table(arrays, pyarrow.schema(fields, metadata=dict(metadata)))
    return atomic_write(path, lambda file: parquet.write_table(table, file, compression='zstd'))
