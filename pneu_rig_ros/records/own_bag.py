"""Reads a whole rig from a bag of this project: messages in any order, signals on one grid out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.bag import Bag, Connection, custom_data, find_namespace, open_bag
from pneu_rig_ros.records.cdr import (
    unpack_float64,
    unpack_fluid_pressure,
    unpack_joint_state,
    unpack_valve_voltages,
)
from pneu_rig_ros.records.description import configuration_in
from pneu_rig_ros.records.grid import check_gaps
from pneu_rig_ros.records.recording import NEVER, Floats, Stamps, check_stamps
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.valve_drive import valve_voltages

SAMPLED = ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure')
"""Topics that every rig has."""

STAMPED = (*SAMPLED, 'friction', 'force')
"""Topics whose messages have the stamp of their sample."""


class Stream(NamedTuple):
    """One topic: m messages in the order of their arrival."""

    arrival_ns: Stamps
    """Shape (m,)."""
    values: Floats
    """Shape (m, number of values)."""
    stamps: Stamps
    """Shape (m,); empty for messages without a stamp."""


_DECODERS: dict[str, Callable[[bytes], tuple[Any, ...]]] = {
    'joint_states': unpack_joint_state,
    'chamber_1/pressure': unpack_fluid_pressure,
    'chamber_2/pressure': unpack_fluid_pressure,
    'friction': unpack_joint_state,
    'force': unpack_joint_state,
    'u': lambda data: (0, unpack_float64(data)),
    'valve_voltages': lambda data: (0, *unpack_valve_voltages(data)),
}
"""Topic -> function that returns stamp (0 for none) and values of a message."""

EFFORT = 2
"""Column of the force in the values of a JointState."""


class OwnBag(NamedTuple):
    """
    Content of a bag.

    :param start_ns: stamp of the first sample [ns]
    :param interval_ns: sampling interval [ns]
    :param signals: name -> values on the grid, shape (n,) each
    :param missing: stamped topic -> stamps of the samples it lacks [ns]
    :param arrival_ns: when the recorder got each sample [ns], shape (n,)
    :param counts: topic -> number of messages in the bag
    :param metadata: custom data of the bag
    :param protected: whether every message has a checksum
    """

    start_ns: int
    interval_ns: int
    signals: dict[str, Floats]
    missing: dict[str, Stamps]
    arrival_ns: Stamps
    counts: dict[str, int]
    metadata: dict[str, str]
    protected: bool


def holds_rig(path: Path) -> bool:
    """
    Return whether a bag has all the topics of a rig, as the recorder of this project names them.

    :raises RigError: when it is not a bag, or is cut off
    """
    if path.suffix in ('.db3', '.bag') or (path.is_dir() and any(path.glob('*.db3'))):
        return False  # the recorder writes MCAP
    with open_bag(path) as reader:
        topics = [connection.topic for connection in reader.connections]
        if not any(topic.endswith('/joint_states') for topic in topics):
            return False
        namespace = find_namespace(topics)
        return all(f'{namespace}/{topic}' in topics for topic in SAMPLED)


def read_own_bag(path: Path) -> OwnBag:
    """
    Read a complete bag of a rig.

    :param path: the bag's directory, or a file in it
    :raises RigError: when it is not a bag, is cut off, or lacks the signals of a rig
    """
    with open_bag(path) as reader:
        namespace = find_namespace(c.topic for c in reader.connections)
        metadata = custom_data(reader, reader.information)
        protected = reader.protected()
        counts = _counts(reader, namespace)
        try:
            streams = _streams(reader, namespace)
        except RigError as error:
            raise RigError(f'{path}: {error}') from error
    try:
        return _align(streams, counts, metadata, protected)
    except RigError as error:
        raise RigError(f'{path}: {error}') from error


def _counts(reader: Bag, namespace: str) -> dict[str, int]:
    present = {c.topic: c.msgcount for c in reader.connections}
    names = {topic: topic if topic.startswith('/') else f'{namespace}/{topic}' for topic in TOPICS}
    return {topic: present[name] for topic, name in names.items() if name in present}


def _streams(reader: Bag, namespace: str) -> dict[str, Stream]:
    """Decode the topics of a recording in one pass over the bag."""
    names = {f'{namespace}/{topic}': topic for topic in _DECODERS}
    connections = [c for c in reader.connections if c.topic in names]
    arrivals: dict[str, list[int]] = {topic: [] for topic in _DECODERS}
    rows: dict[str, list[tuple[Any, ...]]] = {topic: [] for topic in _DECODERS}
    for connection in connections:
        _check_type(connection, names[connection.topic])
    for connection, arrival_ns, cdr in reader.messages(connections):
        topic = names[connection.topic]
        arrivals[topic].append(arrival_ns)
        try:
            rows[topic].append(_DECODERS[topic](cdr))
        except RigError as error:
            number = len(rows[topic]) + 1
            raise RigError(f'{connection.topic}: message {number}: {error}') from error
    for connection in connections:
        found = len(rows[names[connection.topic]])
        if found != connection.msgcount:
            raise RigError(
                f'{connection.topic}: {found} messages, the index says {connection.msgcount}'
            )
    return {topic: _stream(arrivals[topic], rows[topic]) for topic in _DECODERS}


def _check_type(connection: Connection, topic: str) -> None:
    wanted = TOPICS['friction' if topic == 'force' else topic].type
    if connection.msgtype != wanted:
        raise RigError(f'{connection.topic} is {connection.msgtype}, must be {wanted}')


def _stream(arrivals: list[int], rows: list[tuple[Any, ...]]) -> Stream:
    stamps, *values = zip(*rows, strict=True) if rows else ((), ())
    return Stream(
        np.array(arrivals, dtype=np.int64),
        np.array(values, dtype=np.float64).T,
        np.array(stamps, dtype=np.int64),
    )


def _align(
    streams: dict[str, Stream], counts: dict[str, int], metadata: dict[str, str], protected: bool
) -> OwnBag:
    for topic in SAMPLED:
        if streams[topic].stamps.size == 0:
            raise RigError(
                f'no message on {topic}: was the plant running and unpaused, '
                'or is this a part of a rig?'
            )
    interval = _interval(streams['joint_states'].stamps, configuration_in(metadata))
    start = min(int(streams[topic].stamps.min()) for topic in SAMPLED)
    end = max(int(streams[topic].stamps.max()) for topic in SAMPLED)
    stamped = [topic for topic in STAMPED if streams[topic].stamps.size]
    for topic in stamped:
        check_stamps(streams[topic].stamps, start, interval, topic)
    check_gaps((end - start) // interval + 1, streams['joint_states'].stamps.size)
    grid = np.arange(start, end + 1, interval, dtype=np.int64)
    joint = streams['joint_states']
    arrival = np.full(grid.size, NEVER, dtype=np.int64)
    arrival[(joint.stamps - start) // interval] = joint.arrival_ns
    signals = _sampled(streams, grid, interval) | _held(streams, arrival)
    missing = {
        topic: np.setdiff1d(grid, streams[topic].stamps, assume_unique=True) for topic in stamped
    }
    return OwnBag(start, interval, signals, missing, arrival, counts, metadata, protected)


def _sampled(streams: dict[str, Stream], grid: Stamps, interval: int) -> dict[str, Floats]:
    """Return the signals of the stamped topics on the grid."""
    joint, cap, rod = (streams[topic] for topic in SAMPLED)
    signals = {
        'position': _fill(joint, 0, grid),
        'velocity': _fill(joint, 1, grid),
        'pressure_1': _fill(cap, 0, grid),
        'pressure_2': _fill(rod, 0, grid),
    }
    if streams['force'].stamps.size:
        signals['force'] = _fill(streams['force'], EFFORT, grid)
    if streams['friction'].stamps.size:
        signals['friction'] = _place(streams['friction'], EFFORT, grid, interval)
    return signals


def _held(streams: dict[str, Stream], arrival: Stamps) -> dict[str, Floats]:
    """Return the command and the valve voltages that had arrived with each sample."""
    signals = {}
    valves, command = streams['valve_voltages'], streams['u']
    if valves.arrival_ns.size:
        voltages = _hold(valves, arrival, valve_voltages(0.0))
        signals = {'voltage_1': voltages[:, 0].copy(), 'voltage_2': voltages[:, 1].copy()}
    if command.arrival_ns.size and np.isfinite(command.values).all():
        signals['u'] = _hold(command, arrival, (0.0,))[:, 0].copy()
    return signals


def _interval(stamps: Stamps, configuration: RigConfiguration | None) -> int:
    """Return the sampling interval [ns]: the configured one, else the shortest step."""
    if configuration is not None:
        return configuration.interval_ns
    if stamps.size < 2:
        raise RigError('one sample and no configuration: the sampling interval is unknown')
    return max(1, int(np.diff(stamps).min()))


def _fill(stream: Stream, column: int, grid: Stamps) -> Floats:
    """Return a column of the stream on the grid, linear where samples are missing."""
    # From the first sample on, as a float cannot hold the nanoseconds since 1970.
    known = stream.stamps - grid[0]
    filled: Floats = np.interp(grid - grid[0], known, stream.values[:, column])
    return filled


def _place(stream: Stream, column: int, grid: Stamps, interval: int) -> Floats:
    """Return a column of the stream on the grid, NaN where it has no value."""
    values = np.full(grid.size, np.nan)
    index = (stream.stamps - grid[0]) // interval
    inside = (index >= 0) & (index < grid.size)
    values[index[inside]] = stream.values[inside, column]
    return values


def _hold(stream: Stream, arrival: Stamps, before: tuple[float, ...]) -> Floats:
    """Return the last values that had arrived with each sample, `before` the first ones."""
    known = np.maximum.accumulate(arrival)
    last = np.searchsorted(stream.arrival_ns, known, side='right')
    held: Floats = np.concatenate([[before], stream.values])[last]
    return held
