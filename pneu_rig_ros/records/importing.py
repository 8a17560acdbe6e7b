"""
Writes measured signals as a bag, in the form in which the recorder writes one.

Position and both pressures make a bag that every command reads; fewer signals make one of a part
of a rig. A measured force goes on a topic `force`, in the form of `friction`.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr import (
    FrictionMessage,
    PlantMessages,
    pack_float64,
    pack_string,
    pack_valve_voltages,
)
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
from pneu_rig_ros.records.plausible import check_plausible
from pneu_rig_ros.records.recording import Floats, Recording
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.records.writer import BagWriter
from pneu_rig_ros.rig import RigConfiguration, Sample
from pneu_rig_ros.rig.urdf import robot_description

Progress = Callable[[int], None]
"""Callback with the number of samples written."""

REPORT_EVERY = 512
"""Samples between two calls of the progress function."""

LEAST_INTERVAL, MOST_INTERVAL = 100_000, 1_000_000_000
"""Between two samples [ns]."""

NEEDED_BY = {
    'position': ('joint_states', 'position', 'velocity'),
    'pressure_1': ('chamber_1/pressure',),
    'pressure_2': ('chamber_2/pressure',),
}
"""Signal -> topics that are written for it."""

SOURCES = {
    'joint_states': ('position',),
    'position': ('joint_states',),
    'velocity': ('joint_states', 'position'),
    'chamber_1/pressure': ('pressure_1',),
    'chamber_2/pressure': ('pressure_2',),
    'valve_voltages': ('u', 'voltage_1', 'voltage_2'),
}
"""Topic -> signals and topics whose missing samples it shares."""

FORCE = 'force'
"""Topic and signal of a measured force; a JointState whose effort it is."""


def write_bag(
    recording: Recording,
    out: Path | str,
    conditions: Mapping[str, float] | None = None,
    configuration: RigConfiguration | None = None,
    progress: Progress | None = None,
) -> None:
    """
    Write a recording as a bag.

    The bag appears as a whole or not at all. Samples that are missing stay so. Without `voltage_1`
    and `voltage_2` the valve voltages follow from `u` by Eq. 1, if it was recorded.

    :param recording: the signals
    :param out: the bag's directory, must not exist
    :param conditions: go into ``conditions.yaml`` in the bag, beside those that the recording
        knows and the surroundings that gauge pressures were counted from
    :param configuration: the rig, if it is known: goes into the bag under these conditions
    :param progress: called with the number of samples written
    :raises RigError: when the bag exists or cannot be written, or a voltage lacks the other
    """
    out, source = Path(out), recording.metadata.get('source', recording.name)
    if out.exists():
        raise RigError(f'{out} exists; name a bag that does not, or remove it')
    known = with_zero(
        {**recording.conditions, **(conditions or {})}, recording.atmospheric_pressure
    )
    if configuration is not None:
        configuration = apply_conditions(configuration, known)
        check_plausible(source, recording.signals, configuration)
    if not LEAST_INTERVAL <= recording.interval_ns <= MOST_INTERVAL:
        raise RigError(
            f'{source}: a sample every {recording.interval_ns * 1e-6:g} ms, allowed '
            'are 0.1 to 1000 ms; is the time in another unit?'
        )
    folder = _folder_beside(out)
    try:
        # Under its final name, which is in the metadata.
        _write(folder / out.name, recording, configuration, progress or (lambda _: None))
        if known:
            (folder / out.name / FILE_NAME).write_text(format_conditions(known), encoding='utf-8')
        (folder / out.name).replace(out)
    except OSError as error:
        raise RigError(f'cannot write the bag {out}: {error.strerror}') from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _folder_beside(out: Path) -> Path:
    """Return a folder on the same file system, so that the bag can be moved in one step."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f'.{out.name}.', dir=out.parent))
    except OSError as error:
        raise RigError(f'cannot write the bag {out}: {error.strerror}') from error


def _write(
    path: Path, recording: Recording, configuration: RigConfiguration | None, progress: Progress
) -> None:
    metadata = {
        'source': recording.metadata.get('source', recording.name),
        'package_version': package_version(),
        'git_revision': git_revision(),
    }
    start_ns = recording.start_ns
    with BagWriter(path) as writer:
        if configuration is not None:
            sampled = replace(configuration, interval_ns=recording.interval_ns)
            description = describe(sampled)
            metadata |= bag_metadata(description)
            # A real rig has neither; those in the description belong to its model.
            del metadata['friction_model'], metadata['seed']
            _put(writer, 'rig_description', start_ns, pack_string(description))
            _put(writer, 'robot_description', start_ns, pack_string(robot_description(sampled)))
        for count, (topic, stamp_ns, cdr) in enumerate(_messages(recording)):
            _put(writer, topic, stamp_ns, cdr)
            if count % REPORT_EVERY == 0:
                progress((stamp_ns - start_ns) // recording.interval_ns)
        writer.close(metadata)
    progress(recording.size)


def _put(writer: BagWriter, topic: str, stamp_ns: int, cdr: bytes) -> None:
    kind = TOPICS['friction' if topic == FORCE else topic].type
    writer.write(f'/{topic}', kind, stamp_ns, cdr)


Message = Callable[[int, int], bytes]
"""Takes the number of a sample and its stamp [ns]."""


def _messages(recording: Recording) -> Iterator[tuple[str, int, bytes]]:
    """Yield topic, stamp [ns] and message of everything, in the order of time."""
    parts = (_commands(recording), _samples(recording), _forces(recording))
    streams = [
        (topic, message, _present(recording, topic).tolist())
        for part in parts
        for topic, message in part
    ]
    for k, stamp_ns in enumerate(recording.stamps.tolist()):
        for topic, message, present in streams:
            if present[k]:
                yield topic, stamp_ns, message(k, stamp_ns)


def _present(recording: Recording, topic: str) -> NDArray[np.bool_]:
    """Return which samples of a topic are not missing, shape (n,)."""
    present = np.ones(recording.size, dtype=np.bool_)
    if topic == 'friction':
        present = np.isfinite(recording.friction)
    for source in (topic, *SOURCES.get(topic, ())):
        present &= ~np.isin(recording.stamps, recording.missing.get(source, ()))
    return present


def _commands(recording: Recording) -> Iterator[tuple[str, Message]]:
    """Yield the command and the valve voltages, which a sample finds in force."""
    given = [name for name in ('voltage_1', 'voltage_2') if name in recording]
    if len(given) == 1:
        raise RigError(f'{given[0]} without the other valve; map voltage_1 and voltage_2, or u')
    if 'u' in recording:
        u = recording['u'].tolist()
        yield 'u', lambda k, _: pack_float64(u[k])
    if recording.driven:
        voltages = recording.voltage_1.tolist(), recording.voltage_2.tolist()
        yield 'valve_voltages', lambda k, _: pack_valve_voltages(voltages[0][k], voltages[1][k])


def _samples(recording: Recording) -> Iterator[tuple[str, Message]]:
    """Yield the topics of the plant whose signals were recorded."""
    topics = [topic for name in NEEDED_BY if name in recording for topic in NEEDED_BY[name]]
    nothing = np.full(recording.size, np.nan)
    columns: list[Floats] = [
        recording.signals.get('position', nothing),
        recording.velocity if 'position' in recording else nothing,
        *(recording.signals.get(name, nothing) for name in ('pressure_1', 'pressure_2')),
    ]
    rows = list(zip(*(column.tolist() for column in columns), strict=True))
    plant = PlantMessages(pressure_variance=0.0)  # 0 is "not known", as sensor_msgs says
    packed: dict[str, bytes] = {}
    latest = -1

    def message_of(topic: str) -> Message:
        def message(k: int, stamp_ns: int) -> bytes:
            nonlocal latest
            if k != latest:
                latest = k
                plant.pack(Sample(k, *rows[k]), stamp_ns)
                packed.update(plant.by_topic(simulated_time=False))
            return packed[topic]

        return message

    yield from ((topic, message_of(topic)) for topic in topics)


def _forces(recording: Recording) -> Iterator[tuple[str, Message]]:
    def message_of(values: list[float]) -> Message:
        encoder = FrictionMessage()
        return lambda k, stamp_ns: encoder.pack(values[k], stamp_ns)

    for name in (FORCE, 'friction'):
        if name in recording:
            yield name, message_of(recording[name].tolist())
