"""
Reads the signals of any rig's bag: topics of any name, messages of any type, each with own stamps.

The signal with the most messages gives the instants; the others are interpolated to them, voltages
held. Only the time span that all signals cover is read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.typesys import Stores, get_typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.bag import check_bag, custom_data, find_namespace, first_line
from pneu_rig_ros.records.cdr import NANOSECONDS
from pneu_rig_ros.records.decompression import check_ros1_chunks
from pneu_rig_ros.records.grid import HELD, Columns, resample
from pneu_rig_ros.records.mapping import Source, TableMapping
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS, Floats, Stamps
from pneu_rig_ros.records.rosbag2_metadata import read_metadata
from pneu_rig_ros.records.scaling import in_si, unit_of

USUAL_FIELDS = {
    'std_msgs/msg/Float64': 'data',
    'std_msgs/msg/Float32': 'data',
    'std_msgs/msg/Int32': 'data',
    'std_msgs/msg/Int16': 'data',
    'sensor_msgs/msg/FluidPressure': 'fluid_pressure',
    'sensor_msgs/msg/Range': 'range',
}
"""Message type -> field that holds its number."""

USUAL_JOINT_FIELDS = {
    'position': 'position[0]',
    'velocity': 'velocity[0]',
    'force': 'effort[0]',
    'friction': 'effort[0]',
}
"""Signal -> field of a JointState."""

OWN = {
    'position': Source(topic='joint_states'),
    'velocity': Source(topic='joint_states'),
    'pressure_1': Source(topic='chamber_1/pressure'),
    'pressure_2': Source(topic='chamber_2/pressure'),
    'u': Source(topic='u'),
    'voltage_1': Source(topic='valve_voltages', field='data[0]'),
    'voltage_2': Source(topic='valve_voltages', field='data[1]'),
    'force': Source(topic='force'),
}
"""
Where the signals are in a bag of this project; names without the namespace. Without `friction`,
which is an estimate that starts late and ends early.
"""

_STEP = re.compile(r'\.?(?P<name>[A-Za-z_]\w*)|\[(?P<item>[^\[\]]+)\]')


class Stream(NamedTuple):
    """One signal as it was recorded: stamps [ns] and values in SI units, shape (m,)."""

    stamps: Stamps
    values: Floats


class MappedBag(NamedTuple):
    """
    What is read of a bag.

    :param columns: signals at the stamps of the one with the most messages
    :param metadata: custom data of the bag
    :param protected: whether every message has a checksum
    """

    columns: Columns
    metadata: dict[str, str]
    protected: bool


def read_mapped_bag(path: Path, mapping: TableMapping | None, zero: float) -> MappedBag:
    """
    Read the mapped signals of a bag; those of this project without a mapping.

    :param zero: pressure of the surroundings [Pa], for gauge pressures
    :raises RigError: when it is no bag, a topic or field is missing, or a value is no number
    """
    if mapping is not None and not mapping.of_bag:
        raise RigError(f'{mapping.origin}: maps columns, but {path} is a bag; write topics: ...')
    directory = path if path.is_dir() or path.suffix == '.bag' else path.parent
    try:
        protected = directory.is_dir() and check_bag(directory)
        with AnyReader([directory], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            _check_ros1(reader)
            sources = dict(mapping.signals) if mapping else _own(reader.connections)
            streams, gauge = _streams(reader, sources, mapping.origin if mapping else path, zero)
            custom = custom_data(reader, read_metadata(directory))
    except RigError:
        raise
    except Exception as error:
        # rosbags, decompressors and parsers raise any exception on damaged data.
        raise RigError(f'{path}: cannot be read as a bag: {first_line(error)}') from error
    return MappedBag(_columns(path, streams, gauge), custom, protected)


def _check_ros1(reader: AnyReader) -> None:
    """Raise RigError for a bag of ROS 1 with a chunk that would fill the memory."""
    for bag in reader.readers:
        if isinstance(bag, Reader1):
            check_ros1_chunks(Path(str(bag.path)), [chunk.pos for chunk in bag.chunk_infos])


def _own(connections: list[Connection]) -> dict[str, Source]:
    """Return the sources of this project's topics, as far as the bag has messages on them."""
    filled = {connection.topic for connection in connections if connection.msgcount}
    namespace = _namespace(connections)
    named = {
        name: source for name, source in OWN.items() if f'{namespace}/{source.topic}' in filled
    }
    if not named:
        raise RigError('the bag has none of the topics of this project; map its own')
    return {
        name: Source(topic=f'{namespace}/{source.topic}', field=source.field)
        for name, source in named.items()
    }


def _namespace(connections: list[Connection]) -> str:
    has_joint = any(c.topic.endswith('/joint_states') for c in connections)
    return find_namespace(c.topic for c in connections) if has_joint else ''


def _streams(
    reader: AnyReader, sources: dict[str, Source], origin: object, zero: float
) -> tuple[dict[str, Stream], bool]:
    by_topic = {connection.topic: connection for connection in reader.connections}
    streams, any_gauge = {}, False
    for name, source in sources.items():
        where = f'{origin}: {name}'
        if source.topic not in by_topic:
            raise RigError(f'{where}: topic: {unknown(source.topic, sorted(by_topic))}')
        connection = by_topic[source.topic]
        path = source.field or usual_field(connection.msgtype, name, where)
        stamps, raw = _collected(reader, connection, path, where)
        unit = unit_of(source, source.unit or SIGNALS[name], name, where)
        values, gauge = in_si(raw, name, source, unit, where, zero)
        if name in PRESSURES and (values <= 0).any():
            raise RigError(f'{where}: {values.min():.6g} Pa absolute; is it gauge? (gauge: true)')
        streams[name] = Stream(stamps, values)
        any_gauge |= gauge
    return streams, any_gauge


def usual_field(message_type: str, signal: str, where: str) -> str:
    """Return the field of a message type that holds a signal; RigError if it is not clear."""
    if message_type == 'sensor_msgs/msg/JointState' and signal in USUAL_JOINT_FIELDS:
        return USUAL_JOINT_FIELDS[signal]
    if message_type not in USUAL_FIELDS:
        raise RigError(f'{where}: name the field of {message_type}, such as field: data[0]')
    return USUAL_FIELDS[message_type]


def _collected(
    reader: AnyReader, connection: Connection, path: str, where: str
) -> tuple[Stamps, Floats]:
    """Return stamps [ns] and values of one topic, in the order of their stamps."""
    steps = list(_steps(path, where))
    rows = []
    for _, log_time, data in reader.messages([connection]):
        message = reader.deserialize(data, connection.msgtype)
        rows.append((_stamp(message, log_time), _value(message, steps, path, where)))
    if not rows:
        raise RigError(f'{where}: no message on {connection.topic}')
    # By stamp, and of equal stamps the last.
    latest = dict(sorted(rows, key=lambda row: row[0]))
    return np.array(list(latest), dtype=np.int64), np.array(list(latest.values()))


def _steps(path: str, where: str) -> Iterator[str]:
    """Yield the steps of a path such as 'pose.position.x', 'data[0]' or 'position[piston]'."""
    at = 0
    while at < len(path):
        match = _STEP.match(path, at)
        if match is None:
            raise RigError(
                f'{where}.field: {path!r} is not of the form pose.position.x or data[0]'
            )
        yield match[0].removeprefix('.')
        at = match.end()


def _stamp(message: Any, log_time: int) -> int:
    """Return the stamp of the header [ns], else the time of recording."""
    header = getattr(message, 'header', None)
    stamp = getattr(header, 'stamp', None)
    if stamp is None:
        return log_time
    if not 0 <= stamp.nanosec < NANOSECONDS:
        raise RigError(f'stamp with {stamp.nanosec} ns in a second, allowed are below 1e9')
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def _value(message: Any, steps: list[str], path: str, where: str) -> float:
    found = message
    for step in steps:
        inner = _inner(message, found, step)
        if inner is None:
            kind = message.__msgtype__
            raise RigError(f'{where}.field: {kind} has no {path!r}{_fields(found)}')
        found = inner
    try:
        value = float(found)
    except (TypeError, ValueError):
        raise RigError(f'{where}.field: {path!r} is no number{_fields(found)}') from None
    if not np.isfinite(value):
        raise RigError(f'{where}: {path!r} is {value} in a message, must be finite')
    return value


def _inner(message: Any, part: Any, step: str) -> Any:
    """Return an attribute, or the item in brackets by its number or joint name; None without."""
    if not step.startswith('['):
        return getattr(part, step, None)
    item = step[1:-1]
    try:
        return part[int(item) if item.isdigit() else message.name.index(item)]
    except (AttributeError, IndexError, TypeError, ValueError):
        return None


def _fields(part: Any) -> str:
    names = [name for name in getattr(part, '__dataclass_fields__', ()) if name[0] != '_']
    if names:
        return f', allowed: {", ".join(names)}'
    return f', it has {len(part)} elements' if hasattr(part, '__len__') else ''


def _columns(path: Path, streams: dict[str, Stream], gauge: bool) -> Columns:
    """Return all streams at the stamps of the one with the most messages."""
    sampled = {name: s for name, s in streams.items() if name not in HELD} or streams
    main = max(sampled, key=lambda name: sampled[name].stamps.size)
    start = max(int(stream.stamps[0]) for stream in sampled.values())
    end = min(int(stream.stamps[-1]) for stream in sampled.values())
    stamps = streams[main].stamps
    stamps = stamps[(stamps >= start) & (stamps <= end)]
    if stamps.size < 2:
        raise RigError(f'{path}: the signals do not overlap in time: {", ".join(streams)}')
    epoch = int(stamps[0])
    time = _seconds(stamps, epoch)
    signals = {
        name: resample(time, _seconds(stream.stamps, epoch), stream.values, name)
        for name, stream in streams.items()
    }
    late = [name for name in streams if name in HELD and streams[name].stamps[0] > epoch]
    notes = (f'{name} starts after the first sample; its first value is held' for name in late)
    return Columns(time, signals, epoch, gauge, tuple(notes))


def _seconds(stamps: Stamps, epoch: int) -> Floats:
    return np.asarray((stamps - epoch) * 1e-9, dtype=np.float64)
