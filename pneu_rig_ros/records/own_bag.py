"""Reads a whole rig from a bag of this project: messages in any order, signals on one grid out."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError, prefixed
from pneu_rig_ros.records.bag import Bag, custom_data, find_namespace, open_bag
from pneu_rig_ros.records.cdr_decoding import DECODERS, decode_all
from pneu_rig_ros.records.conditions import conditions_of
from pneu_rig_ros.records.description import configuration_in
from pneu_rig_ros.records.grid import check_gaps, fit_grid, shortest_decimal
from pneu_rig_ros.records.recording import NEVER, Recording, Stamps, check_stamps
from pneu_rig_ros.records.topics import SAMPLE_TOPICS, TOPICS, absolute_names
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.valve_drive import valve_voltages

STAMPED = (*SAMPLE_TOPICS, 'friction', 'force')
"""Topics whose messages have the stamp of their sample."""

MOST_JITTER = 0.25
"""
Stamps within this share of the interval of a uniform grid are those of samples on it [-]: messages
are stamped after the converter was read, whose clock is steadier than the processor's.
"""

_POSITION, _VELOCITY, _EFFORT = 0, 1, 2
"""Columns in the values of a JointState."""


class Stream(NamedTuple):
    """
    One topic: m messages in the order of their arrival.

    :param arrival_ns: log times [ns], shape (m,)
    :param values: shape (m, number of values)
    :param stamps: [ns], shape (m,); 0 for messages without a stamp
    """

    arrival_ns: Stamps
    values: Floats
    stamps: Stamps


def read_own_bag(path: Path, name: str) -> Recording | None:
    """
    Read a complete bag of a rig, as the recorder writes it; None where it lacks a sample topic.

    :raises RigError: when it is not a bag, is cut off, or lacks the samples of a rig
    """
    with open_bag(path) as bag:
        present = {c.topic: c.msgcount for c in bag.connections}
        if not any(topic.endswith('/joint_states') for topic in present):
            return None
        namespace = find_namespace(present)
        names = absolute_names(namespace).items()
        counts = {topic: present[full] for topic, full in names if full in present}
        if not counts.keys() >= {*SAMPLE_TOPICS}:
            return None
        metadata, protected = custom_data(bag, bag.information), bag.protected()
        with prefixed(path):
            configuration = configuration_in(metadata)
            streams = _read_streams(bag, namespace)
            if configuration is None:
                streams = _without_jitter(streams)
            grid, interval = _sampling_grid(streams, configuration)
    joint = streams['joint_states']
    arrival = np.full(grid.size, NEVER, dtype=np.int64)
    arrival[(joint.stamps - grid[0]) // interval] = joint.arrival_ns
    missing = {
        topic: np.setdiff1d(grid, streams[topic].stamps, assume_unique=True)
        for topic in STAMPED
        if streams[topic].stamps.size
    }
    return Recording(
        name,
        int(grid[0]),
        interval,
        _sampled_signals(streams, grid, interval) | _held_signals(streams, arrival),
        missing=missing,
        arrival_ns=arrival,
        counts=counts,
        metadata=metadata,
        configuration=configuration,
        protected=protected,
        conditions=conditions_of(path, configuration, metadata),
    )


def _read_streams(bag: Bag, namespace: str) -> dict[str, Stream]:
    """Decode the topics of a recording in one pass over the bag."""
    types = {
        f'{namespace}/{topic}': TOPICS['friction' if topic == 'force' else topic].type
        for topic in (*STAMPED, 'u', 'valve_voltages')
    }
    connections = [c for c in bag.connections if c.topic in types]
    for name, kind, _ in connections:
        if kind != types[name]:
            raise RigError(f'{name} is {kind}, must be {types[name]}')
    found: dict[str, tuple[list[int], list[bytes]]] = {name: ([], []) for name in types}
    for connection, arrival_ns, cdr in bag.messages(connections):
        arrivals, messages = found[connection.topic]
        arrivals.append(arrival_ns)
        messages.append(cdr)
    for name, _, indexed in connections:
        if (count := len(found[name][1])) != indexed:
            raise RigError(f'{name}: {count} messages, the index says {indexed}')
    streams = {}
    for name, (arrivals, messages) in found.items():
        with prefixed(name):
            stamps, values = decode_all(DECODERS[types[name]], messages)
        topic = name.removeprefix(f'{namespace}/')
        streams[topic] = Stream(np.array(arrivals, dtype=np.int64), values, stamps)
    return streams


def _without_jitter(streams: dict[str, Stream]) -> dict[str, Stream]:
    """Return the streams with stamps that jitter put on a grid, if they are not too uneven."""
    stamps = streams['joint_states'].stamps
    steps = np.diff(stamps)
    if stamps.size < 2 or steps.min() <= 0 or not (steps % steps.min()).any():
        return streams
    since = (stamps - stamps[0]).astype(np.float64)
    index, interval, off = fit_grid(since)
    if off > MOST_JITTER * interval:
        return streams
    interval = shortest_decimal(interval, int(index[-1]), off)
    first = stamps[0] + round(float(np.mean(since - interval * index)))
    aligned = dict(streams)
    for topic in STAMPED:
        stream = streams[topic]
        numbers = np.rint((stream.stamps - first) / interval).astype(np.int64)
        if not (np.diff(numbers) > 0).all():
            return streams
        on_grid = max(first, 0) + round(interval) * numbers
        # nothing arrives before it was measured
        arrival = np.maximum(stream.arrival_ns, on_grid)
        aligned[topic] = stream._replace(stamps=on_grid, arrival_ns=arrival)
    return aligned


def _sampling_grid(
    streams: dict[str, Stream], configuration: RigConfiguration | None
) -> tuple[Stamps, int]:
    """Return the stamps of all samples, shape (n,), and the interval, configured or shortest."""
    for topic in SAMPLE_TOPICS:
        if streams[topic].stamps.size == 0:
            raise RigError(
                f'no message on {topic}: was the plant running and unpaused, '
                'or is this a part of a rig?'
            )
    stamps = streams['joint_states'].stamps
    if configuration is not None:
        interval = configuration.interval_ns
    elif stamps.size > 1:
        interval = max(1, int(np.diff(stamps).min()))
    else:
        raise RigError('one sample and no configuration: the sampling interval is unknown')
    start = min(int(streams[topic].stamps.min()) for topic in SAMPLE_TOPICS)
    end = max(int(streams[topic].stamps.max()) for topic in SAMPLE_TOPICS)
    for topic in STAMPED:
        check_stamps(streams[topic].stamps, start, interval, topic)
    check_gaps((end - start) // interval + 1, stamps.size)
    return np.arange(start, end + 1, interval, dtype=np.int64), interval


def _sampled_signals(streams: dict[str, Stream], grid: Stamps, interval: int) -> dict[str, Floats]:
    """Return the signals of the stamped topics on the grid, linear where samples are missing."""
    columns = {
        'position': ('joint_states', _POSITION),
        'velocity': ('joint_states', _VELOCITY),
        'pressure_1': ('chamber_1/pressure', 0),
        'pressure_2': ('chamber_2/pressure', 0),
        'force': ('force', _EFFORT),
    }
    signals = {}
    for name, (topic, column) in columns.items():
        stream = streams[topic]
        if stream.stamps.size:
            # From the first sample on, as a float cannot hold the nanoseconds since 1970.
            known = stream.stamps - grid[0]
            signals[name] = np.interp(grid - grid[0], known, stream.values[:, column])
    friction = streams['friction']
    if friction.stamps.size:
        # The estimate starts late and ends early: it is not extended beyond.
        signals['friction'] = np.full(grid.size, np.nan)
        index = (friction.stamps - grid[0]) // interval
        inside = (index >= 0) & (index < grid.size)
        signals['friction'][index[inside]] = friction.values[inside, _EFFORT]
    return signals


def _held_signals(streams: dict[str, Stream], arrival: Stamps) -> dict[str, Floats]:
    """Return the command and the valve voltages that had arrived with each sample."""
    signals = {}
    valves, command = streams['valve_voltages'], streams['u']
    known = np.maximum.accumulate(arrival)

    def hold(stream: Stream, column: int, before: float) -> Floats:
        last = np.searchsorted(stream.arrival_ns, known, side='right')
        return np.concatenate([[before], stream.values[:, column]])[last]

    if valves.arrival_ns.size:
        rest_1, rest_2 = valve_voltages(0.0)
        signals = {'voltage_1': hold(valves, 0, rest_1), 'voltage_2': hold(valves, 1, rest_2)}
    if command.arrival_ns.size and np.isfinite(command.values).all():
        signals['u'] = hold(command, 0, 0.0)
    return signals
