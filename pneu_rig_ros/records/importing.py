"""
Writes a table of measured signals as a bag, in the form in which the recorder writes one.

What the table has is written: position and both pressures make a record that every command reads;
less is a part of a rig, which `pneu_rig_ros.records.table` reads. A measured force goes on a topic
`force`, in the form of `friction`.
"""

from __future__ import annotations

import itertools
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.conditions import (
    FILE_NAME,
    apply_conditions,
    format_conditions,
    with_zero,
)
from pneu_rig_ros.records.description import (
    bag_metadata,
    describe,
    git_revision,
    package_version,
)
from pneu_rig_ros.records.grid import Grid
from pneu_rig_ros.records.plausible import check_plausible
from pneu_rig_ros.records.record import Floats
from pneu_rig_ros.records.table import Table
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.records.wire import (
    FrictionMessage,
    PlantMessages,
    pack_float64,
    pack_string,
    pack_valve_voltages,
)
from pneu_rig_ros.records.writer import BagWriter
from pneu_rig_ros.rig import RigConfiguration, Sample
from pneu_rig_ros.rig.urdf import robot_description
from pneu_rig_ros.rig.valve_drive import valve_voltages

Progress = Callable[[int], None]
"""Told the number of samples written now and then."""

REPORT_EVERY = 512
"""Samples between two calls of the progress function."""

LEAST_INTERVAL, MOST_INTERVAL = 100_000, 1_000_000_000
"""Between two samples [ns]."""

VELOCITY_CUTOFF = 32.0
"""Low-pass of a velocity made from positions [Hz], as the rig's own."""

NEEDED_BY = {
    'position': ('joint_states', 'position', 'velocity'),
    'pressure_1': ('chamber_1/pressure',),
    'pressure_2': ('chamber_2/pressure',),
}
"""Signal -> topics that are written if the table has it."""

FORCE = 'force'
"""Topic and signal of a measured force; a JointState whose effort it is."""

COMPLETE = ('position', 'pressure_1', 'pressure_2')
"""Signals without which a bag is that of a part of a rig."""


def write_bag(
    table: Table,
    out: Path | str,
    conditions: Mapping[str, float] | None = None,
    configuration: RigConfiguration | None = None,
    progress: Progress | None = None,
) -> Grid:
    """
    Write a table as a bag.

    The bag appears as a whole or not at all. Without `voltage_1` and `voltage_2` the valve
    voltages follow from `u` by Eq. 1, if there is one.

    :param table: the signals
    :param out: the bag's directory, must not exist
    :param conditions: go into ``conditions.yaml`` in the bag; with the surroundings that gauge
        pressures were counted from
    :param configuration: the rig, if it is known: goes into the bag under these conditions
    :param progress: called with the number of samples written
    :return: the sampling grid on which the samples lie
    :raises RigError: when the bag exists or cannot be written, or a voltage lacks the other
    """
    out = Path(out)
    if out.exists():
        raise RigError(f'{out} exists; name a bag that does not, or remove it')
    told = with_zero(conditions or {}, table.atmospheric_pressure)
    if configuration is not None:
        configuration = apply_conditions(configuration, told)
        check_plausible(table.source, table.signals, configuration)
    grid = table.grid
    if not LEAST_INTERVAL <= grid.interval_ns <= MOST_INTERVAL:
        raise RigError(f'{table.source}: a sample every {grid.interval_ns * 1e-6:g} ms, allowed '
                       'are 0.1 to 1000 ms; is the time in another unit?')  # fmt: skip
    folder = _folder_beside(out)
    try:
        # Under its final name, which rosbags writes into the metadata.
        _write(folder / out.name, table, grid, configuration, progress or (lambda _: None))
        if told:
            (folder / out.name / FILE_NAME).write_text(format_conditions(told), encoding='utf-8')
        (folder / out.name).replace(out)
    except OSError as error:
        raise RigError(f'cannot write the bag {out}: {error.strerror}') from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return grid


def _folder_beside(out: Path) -> Path:
    """Return a folder on the same file system, so that the bag can be moved in one step."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f'.{out.name}.', dir=out.parent))
    except OSError as error:
        raise RigError(f'cannot write the bag {out}: {error.strerror}') from error


def _write(
    path: Path, table: Table, grid: Grid, configuration: RigConfiguration | None,
    progress: Progress,
) -> None:  # fmt: skip
    metadata = {
        'source': table.source,
        'package_version': package_version(),
        'git_revision': git_revision(),
    }
    with BagWriter(path) as writer:
        if configuration is not None:
            sampled = replace(configuration, interval_ns=grid.interval_ns)
            description = describe(sampled)
            metadata |= bag_metadata(description)
            # A real rig has neither; those of the description are of the model it is told by.
            del metadata['friction_model'], metadata['seed']
            _put(writer, 'rig_description', grid.start_ns, pack_string(description))
            robot = pack_string(robot_description(sampled))
            _put(writer, 'robot_description', grid.start_ns, robot)
        for count, (topic, stamp_ns, cdr) in enumerate(_messages(grid)):
            _put(writer, topic, stamp_ns, cdr)
            if count % REPORT_EVERY == 0:
                progress((stamp_ns - grid.start_ns) // grid.interval_ns)
        writer.close(metadata)
    progress(int(grid.sample[-1]) + 1)


def _put(writer: BagWriter, topic: str, stamp_ns: int, cdr: bytes) -> None:
    kind = TOPICS['friction' if topic == FORCE else topic].type
    writer.write(f'/{topic}', kind, stamp_ns, cdr)


def _messages(grid: Grid) -> Iterator[tuple[str, int, bytes]]:
    """Yield topic, stamp [ns] and message of everything, in the order of time."""
    stamps = (grid.start_ns + grid.interval_ns * grid.sample).tolist()
    parts = (_commands(grid), _samples(grid), _forces(grid))
    streams = [stream for part in parts for stream in part]
    for k, stamp_ns in enumerate(stamps):
        for topic, message in streams:
            yield topic, stamp_ns, message(k, stamp_ns)


Message = Callable[[int, int], bytes]
"""Takes the number of a row and its stamp [ns]."""


def _commands(grid: Grid) -> Iterator[tuple[str, Message]]:
    """Yield the command and the valve voltages, which a sample finds in force."""
    signals = grid.signals
    if 'u' in signals:
        u = signals['u'].tolist()
        yield 'u', lambda k, _: pack_float64(u[k])
    given = [name for name in ('voltage_1', 'voltage_2') if name in signals]
    if len(given) == 1:
        raise RigError(f'{given[0]} without the other valve; map voltage_1 and voltage_2, or u')
    if given:
        pairs = list(zip(*(signals[name].tolist() for name in given), strict=True))
    elif 'u' in signals:
        pairs = [valve_voltages(value) for value in u]
    else:
        return
    yield 'valve_voltages', lambda k, _: pack_valve_voltages(*pairs[k])


def _samples(grid: Grid) -> Iterator[tuple[str, Message]]:
    """Yield the topics of the plant for which there is a signal."""
    signals = grid.signals
    topics = [topic for name in NEEDED_BY if name in signals for topic in NEEDED_BY[name]]
    if not topics:
        return
    nothing = np.full(grid.sample.size, np.nan)
    x = signals.get('position', nothing)
    columns = (
        x,
        signals.get('velocity', _velocity(grid)),
        *(signals.get(name, nothing) for name in ('pressure_1', 'pressure_2')),
    )
    rows = list(zip(*(column.tolist() for column in columns), strict=True))
    plant = PlantMessages(pressure_variance=0.0)  # 0 is "not known", as sensor_msgs says
    packed: dict[str, bytes] = {}

    def message_of(topic: str) -> Message:
        def message(k: int, stamp_ns: int) -> bytes:
            if topic == topics[0]:
                plant.pack(Sample(k, *rows[k]), stamp_ns)
                packed.update(plant.by_topic(simulated_time=False))
            return packed[topic]

        return message

    yield from ((topic, message_of(topic)) for topic in topics)


def _velocity(grid: Grid) -> Floats:
    """Return the velocity of the samples that there are [m/s]; NaN without a position."""
    if 'position' not in grid.signals:
        return np.full(grid.sample.size, np.nan)
    position = grid.filled()[1]['position']
    return smoothed_velocity(position, grid.interval_ns * 1e-9)[grid.sample]


def _forces(grid: Grid) -> Iterator[tuple[str, Message]]:
    def message_of(values: list[float]) -> Message:
        encoder = FrictionMessage()
        return lambda k, stamp_ns: encoder.pack(values[k], stamp_ns)

    for name in (FORCE, 'friction'):
        if name in grid.signals:
            yield name, message_of(grid.signals[name].tolist())


def smoothed_velocity(position: Floats, interval: float) -> Floats:
    """
    Return the velocity [m/s] as the rig's own data acquisition makes it, shape (n,).

    The differentiated position through a first-order low-pass at 32 Hz, without it where the
    sampling is too slow for one.

    :param position: [m], shape (n,)
    :param interval: [s]
    """
    slope = np.diff(position, prepend=position[:1]) / interval
    if VELOCITY_CUTOFF * interval >= 0.45:
        return slope
    warped = np.tan(np.pi * VELOCITY_CUTOFF * interval)
    pole = (1.0 - warped) / (1.0 + warped)
    drive = 0.5 * (1.0 - pole) * (slope + np.concatenate([[0.0], slope[:-1]]))
    return np.array(list(itertools.accumulate(drive.tolist(), lambda v, d: pole * v + d)))
