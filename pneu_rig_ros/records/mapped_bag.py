"""
Reads the signals of any rig's bag: topics of any name, messages of any type, each with own stamps.

The signal with the most messages gives the instants; the others are interpolated to them, voltages
held. Only the time span that all signals cover is read.
"""

import contextlib
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag1.reader import Header, read_bytes, read_uint32

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.bag import check_bag, custom_data, find_namespace, folder_of, reading
from pneu_rig_ros.records.cdr_encoding import NANOSECONDS, typestore
from pneu_rig_ros.records.description import read_metadata
from pneu_rig_ros.records.grid import HELD, Columns, resample
from pneu_rig_ros.records.mapping import Source, TableMapping, in_si
from pneu_rig_ros.records.mcap_file import decompress
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS, Stamps
from pneu_rig_ros.records.topics import JOINT

USUAL_FIELDS = {
    'std_msgs/msg/Float64': 'data',
    'std_msgs/msg/Float32': 'data',
    'sensor_msgs/msg/FluidPressure': 'fluid_pressure',
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
    'position': ('joint_states', ''),
    'velocity': ('joint_states', ''),
    'pressure_1': ('chamber_1/pressure', ''),
    'pressure_2': ('chamber_2/pressure', ''),
    'u': ('u', ''),
    'voltage_1': ('valve_voltages', 'data[0]'),
    'voltage_2': ('valve_voltages', 'data[1]'),
    'force': ('force', ''),
}
"""
Signal -> topic without its namespace and field, in a bag of this project. Without `friction`,
which is an estimate that starts late and ends early.
"""

_STEP = re.compile(r'\.?[A-Za-z_]\w*|\[[^\[\]]+\]')

Stream = tuple[Stamps, Floats]
"""One signal as it was recorded: stamps [ns] and values in SI units, shape (m,)."""


def read_mapped_bag(path: Path, mapping: TableMapping | None, zero: float) -> Columns:
    """
    Read the mapped signals of a bag; those of this project without a mapping.

    :param zero: pressure of the surroundings [Pa], for gauge pressures
    :raises RigError: when it is not a bag, a topic or field is missing, or a value is not a number
    """
    if mapping is not None and not mapping.of_bag:
        raise RigError(f'{mapping.origin}: maps columns, but {path} is a bag; write topics: ...')
    directory = folder_of(path) or path
    streams, gauge = {}, False
    with reading(path):
        protected = directory.is_dir() and check_bag(directory)
        with AnyReader([directory], default_typestore=typestore()) as reader:
            for bag in reader.readers:
                if isinstance(bag, Reader1):
                    _check_ros1_chunks(Path(str(bag.path)), [c.pos for c in bag.chunk_infos])
            sources = mapping.signals if mapping else _own_sources(reader.connections)
            for name, source in sources.items():
                where = f'{mapping.origin if mapping else path}: {name}'
                streams[name], is_gauge = _read_stream(reader, name, source, where, zero)
                gauge |= is_gauge
            custom = custom_data(reader, read_metadata(directory)) if directory.is_dir() else {}
    return _columns(path, streams)._replace(gauge=gauge, metadata=custom, protected=protected)


def _check_ros1_chunks(path: Path, offsets: Iterable[int]) -> None:
    """Raise RigError unless the chunks of a ROS 1 bag, by offset [byte], have the stated size."""
    with path.open('rb') as stream:
        for offset in offsets:
            stream.seek(offset)
            header = Header.read(stream)
            data = read_bytes(stream, read_uint32(stream))
            decompress(data, header.get_string('compression'), header.get_uint32('size'))


def _own_sources(connections: list[Connection]) -> dict[str, Source]:
    """Return the sources of this project's topics, as far as the bag has messages on them."""
    filled = {connection.topic for connection in connections if connection.msgcount}
    topics = [connection.topic for connection in connections]
    has_joint = any(topic.endswith('/joint_states') for topic in topics)
    namespace = find_namespace(topics) if has_joint else ''
    sources = {
        name: Source(topic=f'{namespace}/{topic}', field=field)
        for name, (topic, field) in OWN.items()
        if f'{namespace}/{topic}' in filled
    }
    if 'velocity' not in sources and (topic := f'{namespace}/velocity') in filled:
        sources['velocity'] = Source(topic=topic)  # of a part without a position
    if not sources:
        raise RigError('the bag has none of the topics of this project; map its own')
    return sources


def _read_stream(
    reader: AnyReader, name: str, source: Source, where: str, zero: float
) -> tuple[Stream, bool]:
    """Return the stream of a signal in the order of its stamps, and whether it was gauge."""
    by_topic = {connection.topic: connection for connection in reader.connections}
    if source.topic not in by_topic:
        raise RigError(f'{where}: topic: {unknown(source.topic, sorted(by_topic))}')
    connection = by_topic[source.topic]
    usual = USUAL_JOINT_FIELDS if connection.msgtype == JOINT else {}
    path = source.field or usual.get(name) or USUAL_FIELDS.get(connection.msgtype)
    if path is None:
        raise RigError(f'{where}: name the field of {connection.msgtype}, such as field: data[0]')
    steps = _steps(path, where)
    rows = []
    for _, log_time, data in reader.messages([connection]):
        message = reader.deserialize(data, connection.msgtype)
        rows.append((_stamp(message, log_time), _value(message, steps, path, where)))
    if not rows:
        raise RigError(f'{where}: no message on {connection.topic}')
    # By stamp, and of equal stamps the last.
    latest = dict(sorted(rows, key=lambda row: row[0]))
    raw = np.array(list(latest.values()))
    values, gauge = in_si(raw, name, source, source.unit or SIGNALS[name], where, zero)
    if name in PRESSURES and (values <= 0).any():
        raise RigError(f'{where}: {values.min():.6g} Pa absolute; is it gauge? (gauge: true)')
    return (np.array(list(latest), dtype=np.int64), values), gauge


def _steps(path: str, where: str) -> list[str]:
    """Return the steps of a path such as 'pose.position.x', 'data[0]' or 'position[piston]'."""
    steps = _STEP.findall(path)
    if ''.join(steps) != path:
        raise RigError(f'{where}.field: {path!r} is not of the form pose.position.x or data[0]')
    return [step.removeprefix('.') for step in steps]


def _stamp(message: Any, log_time: int) -> int:
    """Return the stamp of the header [ns], else the time of recording."""
    stamp = getattr(getattr(message, 'header', None), 'stamp', None)
    if stamp is None:
        return log_time
    if not 0 <= stamp.nanosec < NANOSECONDS:
        raise RigError(f'stamp with {stamp.nanosec} ns in a second, allowed are below 1e9')
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def _value(message: Any, steps: list[str], path: str, where: str) -> float:
    """Return the number at the end of a path; an item is given by its number or joint name."""
    part = message
    for step in steps:
        inner, item = None, step[1:-1]
        if not step.startswith('['):
            inner = getattr(part, step, None)
        else:
            with contextlib.suppress(AttributeError, IndexError, TypeError, ValueError):
                inner = part[int(item) if item.isdigit() else message.name.index(item)]
        if inner is None:
            raise RigError(
                f'{where}.field: {message.__msgtype__} has no {path!r}{_contents(part)}'
            )
        part = inner
    try:
        value = float(part)
    except (TypeError, ValueError):
        raise RigError(f'{where}.field: {path!r} is no number{_contents(part)}') from None
    if not np.isfinite(value):
        raise RigError(f'{where}: {path!r} is {value} in a message, must be finite')
    return value


def _contents(part: Any) -> str:
    """Say what else a part of a message has, for an error."""
    names = [name for name in getattr(part, '__dataclass_fields__', ()) if name[0] != '_']
    if names:
        return f', allowed: {", ".join(names)}'
    return f', it has {len(part)} elements' if hasattr(part, '__len__') else ''


def _columns(path: Path, streams: dict[str, Stream]) -> Columns:
    """Return all streams at the stamps of the one with the most messages."""
    sampled = {name: s for name, s in streams.items() if name not in HELD} or streams
    stamps, _ = max(sampled.values(), key=lambda stream: stream[0].size)
    start = max(int(s[0]) for s, _ in sampled.values())
    end = min(int(s[-1]) for s, _ in sampled.values())
    stamps = stamps[(stamps >= start) & (stamps <= end)]
    if stamps.size < 2:
        raise RigError(f'{path}: the signals do not overlap in time: {", ".join(streams)}')
    epoch = int(stamps[0])
    time = (stamps - epoch).astype(np.float64) * 1e-9
    signals = {
        name: resample(time, (own - epoch).astype(np.float64) * 1e-9, values, name)
        for name, (own, values) in streams.items()
    }
    late = [name for name in streams if name in HELD and streams[name][0][0] > epoch]
    notes = (f'{name} starts after the first sample; its first value is held' for name in late)
    return Columns(time, signals, epoch, notes=tuple(notes))
