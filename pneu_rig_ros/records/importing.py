"""
Writes measured signals as a bag, in the form in which the recorder writes one.

Position and both pressures make a bag that every command reads; fewer signals make one of a part
of a rig. A measured force goes on a topic `force`, in the form of `friction`.
"""

from __future__ import annotations

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
    check_plausible,
    format_conditions,
    with_zero,
)
from pneu_rig_ros.records.description import (
    bag_metadata,
    describe,
    git_revision,
    package_version,
)
from pneu_rig_ros.records.recording import Recording
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

    The bag is written atomically. Missing samples stay missing. Without `voltage_1`
    and `voltage_2` the valve voltages follow from `u` by Eq. 1, if it was recorded.

    :param recording: the signals
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
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        # On the same file system, so that the bag can be moved in one step.
        with tempfile.TemporaryDirectory(prefix=f'.{out.name}.', dir=out.parent) as folder:
            bag = Path(folder, out.name)  # under its final name, which is in the metadata
            _write(bag, recording, configuration, progress or (lambda _: None))
            if known:
                (bag / FILE_NAME).write_text(format_conditions(known), encoding='utf-8')
            bag.replace(out)
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


def _messages(recording: Recording) -> Iterator[tuple[str, int, bytes]]:
    """
    Yield topic, stamp [ns] and message of everything, in the order of time.

    Commands come before the sample that finds them in force.
    """
    if ('voltage_1' in recording) != ('voltage_2' in recording):
        given = 'voltage_1' if 'voltage_1' in recording else 'voltage_2'
        raise RigError(f'{given} without the other valve; map voltage_1 and voltage_2, or u')
    moving = 'position' in recording
    recorded = {
        'u': 'u' in recording,
        'valve_voltages': recording.driven,
        'joint_states': moving,
        'position': moving,
        'velocity': moving,
        'chamber_1/pressure': 'pressure_1' in recording,
        'chamber_2/pressure': 'pressure_2' in recording,
        FORCE: FORCE in recording,
        'friction': 'friction' in recording,
    }
    topics = [topic for topic, wanted in recorded.items() if wanted]
    present = {topic: _present(recording, topic).tolist() for topic in topics}
    nothing = np.full(recording.size, np.nan)
    names = ('position', 'pressure_1', 'pressure_2', 'u', FORCE, 'friction')
    position, pressure_1, pressure_2, u, force, friction = (
        recording.signals.get(name, nothing).tolist() for name in names
    )
    velocity = (recording.velocity if moving else nothing).tolist()
    voltages = [nothing.tolist()] * 2
    if recording.driven:
        voltages = [recording.voltage_1.tolist(), recording.voltage_2.tolist()]
    plant = PlantMessages(pressure_variance=0.0)  # 0 is "not known", as sensor_msgs says
    encoder = FrictionMessage()
    for k, stamp_ns in enumerate(recording.stamps.tolist()):
        plant.pack(Sample(k, position[k], velocity[k], pressure_1[k], pressure_2[k]), stamp_ns)
        messages = {
            'u': pack_float64(u[k]),
            'valve_voltages': pack_valve_voltages(voltages[0][k], voltages[1][k]),
            **plant.by_topic(simulated_time=False),
            FORCE: encoder.pack(force[k], stamp_ns),
            'friction': encoder.pack(friction[k], stamp_ns),
        }
        for topic in topics:
            if present[topic][k]:
                yield topic, stamp_ns, messages[topic]


def _present(recording: Recording, topic: str) -> NDArray[np.bool_]:
    """Return which samples of a topic are not missing, shape (n,)."""
    present = np.ones(recording.size, dtype=np.bool_)
    if topic == 'friction':
        present = np.isfinite(recording.friction)
    for source in (topic, *SOURCES.get(topic, ())):
        present &= ~np.isin(recording.stamps, recording.missing.get(source, ()))
    return present
