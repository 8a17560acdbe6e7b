"""Valid inputs of every reader, and what is put into them to make bad ones."""

from __future__ import annotations

import struct
import tempfile
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode

from pneu_rig_ros.records import Recording, cdr_encoding, read_recording, writer
from pneu_rig_ros.records.mcap_file import CHUNK_CRC_OFFSET
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

DURATION = 0.015
"""Of the stroke in the bags [s]: small, so that many are tried."""
CHUNK_SIZE = 3_000

YAML = (
    b'nan', b'.nan', b'inf m', b'-1', b'1e308', b'1e309 Pa', b'0.0 m', b'true', b'null', b'~',
    b'[]', b'{}', b'[1, 2', b'{a: {b: {c: d}}}', b'2026-13-45', b'1:60:61', b'0x' + b'f' * 300,
    b'9' * 5000, b'*a', b'&a', b'!!python/object/apply:os.system ["true"]', b'!!float x', b'<<: ',
    b'? ', b'- ', b'|\n  ', b'"\\x1b[2J"', b"'", b'"', b'\t', b'\r', b'\0', b'\xff\xfe',
    b'\xef\xbb\xbf', b'%YAML 3.0\n', b'---\n', b'...\n', b': ', b'[' * 60, b'a: b\n' * 400,
    b'x' * 3000, b'\xe2\x80\xae', b' Pa', b' m^2', b'name: ', b'effects: {}\n', b'friction: ',
    b'#', b'</script>', b'../../x', b'\xc2\x85', b'9e99999 s',
)  # fmt: skip
UNITS = (
    b'bar', b'psi', b'gauge', b'abs', b'(', b')', b'*', b'/', b'**', b'^', b'9', b'e', b'E+',
    b'.', b',', b'-', b' ', b'9**9**9', b'm**99999', b'1/0', b'kPa', b'Pa**-1', b'inf', b'nan',
    b'degC', b'%', b'"', b"'", b'[', b'{', b'lambda:', b'__import__("os")', b'\xc2\xb5',
    b'\xe2\x81\xb9', b'bar' * 300, b'1e400', b'0x10', b'\xd9\xa3',
)  # fmt: skip
CELLS = (
    b',', b';', b'\t', b'\n', b'\r', b'"', b'""', b'nan', b'inf', b'1e308', b'-1e308', b'1e-320',
    b'1,5', b'0x1p3', b'1_000', b'=cmd|"/C calc"!A0', b'#', b'###\n', b'\0', b'\xff',
    b'\xef\xbb\xbf', b'\xff\xfe', b'9' * 400, b' ', b'e', b'2026-01-31T12:00:00.1', b'1e18',
    b'9223372036854775807', b'-0', b'+', b'x' * 140_000, b'\x0c', b'\xe2\x80\xa8',
    b'unit: datetime', b'unit: bar', b'scale: 1e300', b'offset: 1e308 m', b'{rate: 1e-300 Hz}',
    b'{interval: 1e300 s}', b'skip_rows: 99999999999999999999', b'decimal: ","', b'\xd9\xa3',
    b'1e400',
)  # fmt: skip
BINARY = (
    b'\0', b'\xff', b'\0' * 8, b'\xff' * 4, b'\xff' * 8, b'\xff' * 7 + b'\x7f',
    struct.pack('<Q', 2**40), struct.pack('<I', 2**31 - 1), struct.pack('<Q', 2**31),
    struct.pack('<d', float('nan')), struct.pack('<d', float('inf')), struct.pack('<d', 1e308),
    struct.pack('<d', -1e308), b'\x06', b'\x05', b'\x02', b'\x89MCAP0\r\n', b'zstd', b'lz4',
    b'\x28\xb5\x2f\xfd', b'/joint_states', b'</script>', b'\x1b[2J', b'../..',
    b'\x00\x01\x00\x00', b'\x00\x00\x00\x00', b'float64[999999999] data', b'string X=', b'\n',
)  # fmt: skip

MAPPINGS = (
    b"separator: ';'\ndecimal: ','\ncomment: '#'\nskip_rows: 1\nheader: true\n"
    b'time: {column: 1, unit: ms}\nposition: {column: x, unit: mm, scale: 2.0, offset: 1 mm}\n'
    b'pressure_1: {column: 3, unit: bar, gauge: true}\natmospheric_pressure: 1.013 bar\n',
    b"topics:\n  position: {topic: /axis, field: 'position[0]'}\n  pressure_1: /cap\n",
)
CONDITIONS = (
    b'supply_pressure: 4 bar gauge\nload_mass: 0.2 kg\natmospheric_pressure: 1.01 bar\n',
    b'rest_time: 15 min\nsupply_pressure: 5e5 Pa\n',
)
QUANTITIES = (
    b'4 bar gauge', b'5e5 Pa', b'1.5 psi (abs)', b'-3 kPa', b'7 N/mm^2', b'1e3 mmHg',
    b'2 kg/(m*s^2)',
)  # fmt: skip
TABLES = (
    b'time: {column: t, unit: s}\nposition: {column: x, unit: mm}\nu: {column: u, unit: V}\n###\n'
    b't,x,u\n0.0,1.0,0.1\n0.1,1.5,0.1\n0.2,2.0,0.2\n0.3,2.5,0.2\n',
    b"separator: ';'\ndecimal: ','\ntime: {column: stamp, unit: datetime}\n"
    b'pressure_1: {column: "p [bar]", gauge: true}\n###\nstamp;p [bar]\n'
    b'2026-01-31T12:00:00.000;1,5\n2026-01-31T12:00:00.010;1,6\n2026-01-31T12:00:00.021;1,7\n',
    b'header: false\ntime: {rate: 862 Hz}\nforce: {column: 1, unit: V, scale: 50 N/V}\n'
    b'velocity: {column: 2, unit: mm/s}\n###\n# made\n1 2\n3 4\n5 6\n',
)
FOREIGN_MAPPING: dict[str, Any] = {
    'topics': {
        'position': {'topic': '/axis', 'field': 'position[0]'},
        'force': {'topic': '/load'},
        'pressure_1': {'topic': '/cap', 'unit': 'bar', 'gauge': True},
    }
}


@cache
def _stroke() -> tuple[bytes, bytes, Recording]:
    """Return a bag's file, its metadata.yaml and what it holds."""
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder, 'stroke')
        with mock.patch.object(writer, 'CHUNK_SIZE', CHUNK_SIZE):
            simulate(load_configuration('cylinder_2', seed=7), 0.34, DURATION, bag)
        file, metadata = (bag / 'stroke.mcap').read_bytes(), (bag / 'metadata.yaml').read_bytes()
        return file, metadata, read_recording(bag)


def protected_bag() -> bytes:
    """Return an MCAP file as the recorder writes it."""
    return _stroke()[0]


def bag_metadata() -> bytes:
    """Return its metadata.yaml."""
    return _stroke()[1]


def numbers() -> Recording:
    """Return what it holds."""
    return _stroke()[2]


@cache
def unprotected_bag() -> bytes:
    """Return the same without checksums, so that damage gets past them."""
    data = bytearray(protected_bag())
    place = len(b'\x89MCAP0\r\n')
    while place + 9 <= len(data):
        opcode, length = struct.unpack_from('<BQ', data, place)
        if opcode == 0x06:
            data[place + CHUNK_CRC_OFFSET : place + CHUNK_CRC_OFFSET + 4] = bytes(4)
        place += 9 + length
        if opcode == 0x02:
            data[place - 4 : place] = bytes(4)
            break
    return bytes(data)


@cache
def _foreign(mode: CompressionMode) -> tuple[bytes, bytes]:
    """Return file and metadata.yaml of a bag with topics and units of others."""
    store = cdr_encoding.typestore()
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder, 'stroke')
        made = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
        made.set_compression(mode, CompressionFormat.ZSTD)
        with made:
            rows = {
                '/axis': ('sensor_msgs/msg/JointState', _joint),
                '/load': ('std_msgs/msg/Float32', lambda k: {'data': np.float32(k)}),
                '/cap': ('sensor_msgs/msg/FluidPressure', _pressure),
            }
            for topic, (kind, fields) in rows.items():
                connection = made.add_connection(topic, kind, typestore=store)
                for k in range(40):
                    message = store.types[kind](**fields(k))
                    made.write(connection, 10**9 + k * 10**7, store.serialize_cdr(message, kind))
        return (bag / 'stroke.mcap').read_bytes(), (bag / 'metadata.yaml').read_bytes()


def foreign_bag() -> bytes:
    """Return an MCAP file of another rig."""
    return _foreign(CompressionMode.NONE)[0]


def compressed_bag() -> bytes:
    """Return the same with compressed chunks."""
    return _foreign(CompressionMode.STORAGE)[0]


def foreign_metadata() -> bytes:
    """Return its metadata.yaml."""
    return _foreign(CompressionMode.NONE)[1]


def _header(k: int) -> Any:
    types = cdr_encoding.typestore().types
    stamp = types['builtin_interfaces/msg/Time'](sec=1, nanosec=k * 10**7)
    return types['std_msgs/msg/Header'](stamp=stamp, frame_id='axis')


def _joint(k: int) -> dict[str, Any]:
    values, none = np.array([0.01 * k]), np.array([], dtype=np.float64)
    return {'header': _header(k), 'name': ['rod'], 'position': values, 'velocity': none,
            'effort': none}  # fmt: skip


def _pressure(k: int) -> dict[str, Any]:
    return {'header': _header(k), 'fluid_pressure': 1.0 + 0.01 * k, 'variance': 0.0}


@cache
def messages() -> tuple[bytes, ...]:
    """Return messages on the wire, each behind the number of its decoder."""
    made = [
        cdr_encoding.pack_float64(0.34),
        cdr_encoding.pack_string('name: rig'),
        cdr_encoding.pack_valve_voltages(2.8, 2.2),
        cdr_encoding.template('predicted/joint_states').at(10**9 + 5, 0.1, 0.2, 3.0),
        cdr_encoding.template('chamber_1/pressure').at(10**9 + 5, 2e5),
    ]
    return tuple(bytes([number]) + cdr for number, cdr in enumerate(made))
