"""
Every reader of the package, as a function of bytes that anybody may have written.

Each either returns, or raises a RigError of one line. What it returns is held against something
else that knows the answer: written out and read again, or decoded by another library.
"""

from __future__ import annotations

import math
import shutil
import struct
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.serde import SerdeError

from pneu_rig_ros.claims.readings import load_reading
from pneu_rig_ros.control.excitation import load_excitation
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import bag as bags
from pneu_rig_ros.records import cdr_decoding, cdr_encoding, read_recording, repair
from pneu_rig_ros.records.conditions import format_conditions, parse_conditions
from pneu_rig_ros.records.description import bag_metadata
from pneu_rig_ros.records.mapping import read_mapping
from pneu_rig_ros.records.playback import Playback
from pneu_rig_ros.records.units import convert
from pneu_rig_ros.rig import configuration_from_yaml
from pneu_rig_ros.rig.yaml_file import configuration_folder

from . import seeds

bags.ATTEMPTS = 1  # nobody records while these bags are read


class Reader(NamedTuple):
    """
    One reader under test.

    :param read: takes bytes and a scratch folder; raises RigError for what it refuses
    :param seeds: valid inputs, from which the tried ones are made
    :param tokens: what is put into them here and there
    """

    read: Callable[[bytes, Path], object]
    seeds: Callable[[], Sequence[bytes]]
    tokens: Sequence[bytes]


def _text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise RigError(f'not UTF-8: {error}') from None


def _written(data: bytes, path: Path) -> Path:
    path.write_bytes(data)
    return path


def _configuration(data: bytes, _: Path) -> None:
    read = configuration_from_yaml(_text(data), 'text')
    assert configuration_from_yaml(read.to_yaml(), 'written') == read


def _conditions(data: bytes, _: Path) -> None:
    read = parse_conditions(_text(data), 'text')
    assert parse_conditions(format_conditions(read), 'written') == read


def _excitation(data: bytes, folder: Path) -> None:
    read = load_excitation(_written(data, folder / 'excitation.yaml'))
    for share in (0.0, 0.3, 0.999, 1.0, 2.0):
        assert math.isfinite(read.level(share * read.duration))


def _quantity(data: bytes, _: Path) -> None:
    value = convert(_text(data), 'Pa', 'text', 1e5)
    assert math.isfinite(value), value


def _table(data: bytes, folder: Path) -> None:
    """Read a mapping and a table, parted by a line of ###."""
    mapping, _, table = data.partition(b'###\n')
    read = read_recording(
        _written(table, folder / 'table.csv'), _written(mapping, folder / 'mapping.yaml')
    )
    assert np.isfinite(read.time).all()
    assert (np.diff(read.time) > 0).all()
    assert all(np.isfinite(values).all() for values in read.signals.values())


def _bag(data: bytes, folder: Path) -> None:
    """Read an MCAP file, without metadata.yaml as one that is still being recorded."""
    bag = folder / 'bag'
    shutil.rmtree(bag, ignore_errors=True)
    bag.mkdir()
    _written(data, bag / 'bag.mcap')
    try:
        record = read_recording(bag)
    except RigError:
        # repair tells, or makes a bag that the reader takes or refuses with a line of its own
        repair(bag)
        record = read_recording(bag)
    assert np.isfinite(record.position).all()
    with Playback(bag) as played:
        assert sum(1 for _ in played.messages()) > 0


def _sealed_bag(data: bytes, folder: Path) -> None:
    """Read an MCAP file beside its metadata.yaml: the same numbers as before, or a RigError."""
    bag = folder / 'stroke'
    shutil.rmtree(bag, ignore_errors=True)
    bag.mkdir()
    _written(data, bag / 'stroke.mcap')
    _written(seeds.bag_metadata(), bag / 'metadata.yaml')
    _same_numbers(bag)


def _cut_bag(data: bytes, folder: Path) -> None:
    """Read the first bytes of an MCAP file: the first samples, or a RigError."""
    bag = folder / 'bag'
    bag.mkdir(exist_ok=True)
    _written(data, bag / 'bag.mcap')
    position = read_recording(bag).position
    assert np.array_equal(position, seeds.numbers().position[: position.size])


def _metadata(data: bytes, folder: Path) -> None:
    """Read a metadata.yaml beside an MCAP file that is whole."""
    bag = folder / 'stroke'
    shutil.rmtree(bag, ignore_errors=True)
    bag.mkdir()
    _written(seeds.protected_bag(), bag / 'stroke.mcap')
    _written(data, bag / 'metadata.yaml')
    record = read_recording(bag)
    assert np.array_equal(record.position, seeds.numbers().position)


def _same_numbers(bag: Path) -> None:
    record, true = read_recording(bag), seeds.numbers()
    assert record.configuration == true.configuration
    assert record.counts == true.counts
    assert list(record.signals) == list(true.signals)
    assert np.array_equal(record.arrival_ns, true.arrival_ns)
    for name in true.signals:
        assert np.array_equal(record[name], true[name], equal_nan=True), name


def _foreign_bag(data: bytes, folder: Path) -> None:
    """Read an MCAP file of somebody else, with any message types."""
    bag = folder / 'stroke'
    shutil.rmtree(bag, ignore_errors=True)
    bag.mkdir()
    _written(data, bag / 'stroke.mcap')
    _written(seeds.foreign_metadata(), bag / 'metadata.yaml')
    table = read_recording(bag, seeds.FOREIGN_MAPPING)
    assert all(np.isfinite(values).all() for values in table.signals.values())


DECODERS: dict[str, tuple[str, Callable[[bytes], Any], Callable[[Any], Any]]] = {
    'float64': ('std_msgs/msg/Float64', cdr_decoding.unpack_float64, lambda m: m.data),
    'string': ('std_msgs/msg/String', cdr_decoding.unpack_string, lambda m: m.data),
    'voltages': (
        'std_msgs/msg/Float64MultiArray',
        cdr_decoding.unpack_valve_voltages,
        lambda m: tuple(m.data),
    ),
    'joint': (
        'sensor_msgs/msg/JointState',
        cdr_decoding.unpack_joint_state,
        lambda m: (
            _nanoseconds(m.header.stamp),
            *(f[0] if len(f) else math.nan for f in (m.position, m.velocity, m.effort)),
        ),
    ),
    'pressure': (
        'sensor_msgs/msg/FluidPressure',
        cdr_decoding.unpack_fluid_pressure,
        lambda m: (_nanoseconds(m.header.stamp), m.fluid_pressure, m.variance),
    ),
}
"""Name -> message type, our decoder, and the same values of what rosbags decodes."""


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * cdr_encoding.NANOSECONDS + int(stamp.nanosec)


def _cdr(data: bytes, _: Path) -> None:
    """Decode CDR; the first byte says as which type. Rosbags must find the same numbers in it."""
    kind, decode, values = list(DECODERS.values())[data[0] % len(DECODERS) if data else 0]
    ours = decode(data[1:])
    try:
        theirs = values(cdr_encoding.typestore().deserialize_cdr(data[1:], kind))
    except SerdeError as error:
        if isinstance(error.__cause__, UnicodeDecodeError):
            return  # a name that nobody asks for, in another encoding
        raise
    assert _bits(ours) == _bits(theirs), (ours, theirs)


def _bits(value: Any) -> Any:
    """Return what compares equal for the same bits, NaN among them."""
    if isinstance(value, tuple):
        return tuple(map(_bits, value))
    return struct.pack('<d', value) if isinstance(value, float) else value


@cache
def _files(pattern: str) -> tuple[bytes, ...]:
    return tuple(path.read_bytes() for path in sorted(configuration_folder().glob(pattern)))


def _yaml_reader(load: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    return lambda data, folder: load(_written(data, folder / 'given.yaml'))


READERS: dict[str, Reader] = {
    'configuration': Reader(_configuration, lambda: _files('cylinder_*.yaml'), seeds.YAML),
    'excitation': Reader(
        _excitation,
        lambda: _files('excitations/*.yaml'),
        seeds.YAML,
    ),
    'reading': Reader(_yaml_reader(load_reading), lambda: _files('readings/*.yaml'), seeds.YAML),
    'system': Reader(_yaml_reader(load_system), lambda: _files('systems/s*[!p].yaml'), seeds.YAML),
    'mapping': Reader(
        _yaml_reader(read_mapping),
        lambda: [*_files('systems/*.map.yaml'), *seeds.MAPPINGS],
        seeds.YAML,
    ),
    'conditions': Reader(_conditions, lambda: seeds.CONDITIONS, seeds.YAML),
    'quantity': Reader(_quantity, lambda: seeds.QUANTITIES, seeds.UNITS),
    'description': Reader(
        lambda data, _: bag_metadata(_text(data)), lambda: _files('cylinder_1.yaml'), seeds.YAML
    ),
    'table': Reader(_table, lambda: seeds.TABLES, seeds.CELLS),
    'bag': Reader(_bag, lambda: [seeds.protected_bag(), seeds.unprotected_bag()], seeds.BINARY),
    'sealed bag': Reader(_sealed_bag, lambda: [seeds.protected_bag()], seeds.BINARY),
    'cut bag': Reader(_cut_bag, lambda: [seeds.protected_bag()], seeds.BINARY),
    'metadata': Reader(_metadata, lambda: [seeds.bag_metadata()], seeds.YAML),
    'foreign bag': Reader(
        _foreign_bag, lambda: [seeds.foreign_bag(), seeds.compressed_bag()], seeds.BINARY
    ),
    'cdr': Reader(_cdr, seeds.messages, seeds.BINARY),
}
"""Name -> reader."""
