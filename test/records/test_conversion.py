"""Foreign bags in, tables into bags, bags out as files: the same numbers everywhere."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyarrow import parquet
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, conversion, read_recording
from pneu_rig_ros.records.conversion import read_signals, write_bag, write_csv, write_parquet
from pneu_rig_ros.records.recording import WHOLE, smoothed_velocity
from pneu_rig_ros.rig import load_configuration

STORE = get_typestore(Stores.ROS2_JAZZY)
START = 1_700_000_000_000_000_000
COUNT = 500
SAMPLES = START + 2_000_000 * np.arange(COUNT)
"""Stamps of the joints, every 2 ms."""
TOPICS: dict[str, Any] = {
    'position': {'topic': '/axis/state', 'field': 'position[rod]'},
    'velocity': {'topic': '/axis/state', 'field': 'velocity[1]'},
    'pressure_1': {'topic': '/cap', 'gauge': True},
    'pressure_2': {'topic': '/rod', 'unit': 'kPa'},
    'u': '/command',
}


def motion(stamps: Any) -> Any:
    return 0.1 + 0.05 * np.sin((stamps - START) * 4e-9)


def header(stamp: int) -> Any:
    time = STORE.types['builtin_interfaces/msg/Time'](*divmod(int(stamp), 10**9))
    return STORE.types['std_msgs/msg/Header'](time, '')


def joints(stamp: int) -> Any:
    x = float(motion(stamp))
    values = np.array([7.0, x]), np.array([0.0, 2.0 * x]), np.array([])
    return STORE.types['sensor_msgs/msg/JointState'](header(stamp), ['other', 'rod'], *values)


def cap(stamp: int) -> Any:
    gauge = 2e5 * float(motion(stamp))
    return STORE.types['sensor_msgs/msg/FluidPressure'](header(stamp), gauge, 0.0)


def number(value: float) -> Any:
    return STORE.types['std_msgs/msg/Float64'](value)


@pytest.fixture(params=[StoragePlugin.MCAP, StoragePlugin.SQLITE3], ids=['mcap', 'sqlite3'])
def foreign(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Another rig's bag: joints at 500 Hz, pressures at 250 Hz, a step of the command."""
    path = tmp_path / 'foreign'
    with Writer(path, version=9, storage_plugin=request.param) as writer:

        def put(topic: str, messages: list[tuple[int, Any]]) -> None:
            kind = messages[0][1].__msgtype__
            connection = writer.add_connection(topic, kind, typestore=STORE)
            for stamp, message in messages:
                writer.write(connection, int(stamp), STORE.serialize_cdr(message, kind))

        # recorded 5 ms late, but stamped when sampled
        put('/axis/state', [(stamp + 5_000_000, joints(stamp)) for stamp in SAMPLES])
        put('/cap', [(stamp + 5_000_000, cap(stamp)) for stamp in SAMPLES[::2]])
        put('/rod', [(stamp, number(100.0 + float(motion(stamp)))) for stamp in SAMPLES[::2]])
        steps = [(START, number(0.0)), (SAMPLES[100], number(0.34))]
        put('/command', steps)
    return path


def test_foreign_bag_is_read_by_stamps_joint_names_and_units(foreign: Path) -> None:
    table = read_recording(foreign, {'topics': TOPICS}, atmospheric_pressure=1e5)
    stamps = table.stamps
    np.testing.assert_array_equal(stamps, SAMPLES[: stamps.size])
    np.testing.assert_allclose(table['position'], motion(stamps), atol=1e-12)
    np.testing.assert_allclose(table['velocity'], 2 * motion(stamps), atol=1e-12)
    np.testing.assert_allclose(table['pressure_1'], 1e5 + 2e5 * motion(stamps), atol=0.5)
    np.testing.assert_allclose(table['pressure_2'], 1e5 + 1e3 * motion(stamps), atol=0.01)
    np.testing.assert_array_equal(table['u'], np.where(stamps < SAMPLES[100], 0.0, 0.34))
    assert table.atmospheric_pressure == 1e5


def test_foreign_bag_becomes_a_record(foreign: Path, tmp_path: Path) -> None:
    table = read_recording(foreign, {'topics': TOPICS})
    write_bag(table, tmp_path / 'ours', {'load_mass': 2.0}, load_configuration('cylinder_1'))
    record = read_recording(tmp_path / 'ours')
    assert record.interval_ns == 2_000_000
    assert record.start_ns == START
    np.testing.assert_array_equal(record.position, table['position'])
    np.testing.assert_array_equal(record.pressure_2, table['pressure_2'])
    assert record.voltage_1[99] == pytest.approx(2.5, abs=2e-3)
    assert record.voltage_1[100] == pytest.approx(2.84, abs=2e-3)
    assert record.conditions['load_mass'] == 2.0
    assert record.configuration is not None
    assert record.configuration.model.operation.load_mass == 2.0
    assert record.metadata['source'] == str(foreign)


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        (
            {'position': '/axis/stat'},
            "position: topic: unknown name .* did you mean '/axis/state'",
        ),
        ({'position': {'topic': '/axis/state', 'field': 'pos'}}, "has no 'pos', allowed: header"),
        ({'position': {'topic': '/axis/state', 'field': 'position[2]'}}, 'it has 2 elements'),
        (
            {'position': {'topic': '/axis/state', 'field': 'position[a]'}},
            r"has no 'position\[a\]'",
        ),
        (
            {'position': {'topic': '/axis/state', 'field': 'header'}},
            'is no number, allowed: stamp',
        ),
        ({'position': {'topic': '/axis/state', 'field': '1'}}, "'1' is not of the form"),
        ({'voltage_1': '/axis/state'}, 'name the field of sensor_msgs/msg/JointState'),
        ({'pressure_1': {'topic': '/cap', 'unit': 'm'}}, "unit 'm' is of another kind"),
        ({'position': {'topic': '/axis/state', 'fild': 'x'}}, "unknown name 'fild', did you mean"),
        ({'pos': '/axis/state'}, "topics: unknown name 'pos'"),
        ({'pressure_1': '/cap', 'pressure_2': '/cap'}, 'pressure_2 and pressure_1 are both /cap'),
    ],
)
def test_what_is_wrong_with_a_mapping_of_topics_is_said(
    foreign: Path, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(RigError, match=message):
        read_recording(foreign, {'topics': TOPICS | change})


def test_bag_and_table_are_not_mixed_up(foreign: Path, bag: Path, tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r'maps columns, but .* is a bag'):
        read_recording(foreign, {'time': {'rate': '1 Hz'}, 'position': {'column': 1, 'unit': 'm'}})
    (tmp_path / 'a.csv').write_text('1,2\n3,4\n')
    with pytest.raises(RigError, match=r'maps topics of a bag, but .* is a text table'):
        read_recording(tmp_path / 'a.csv', {'topics': TOPICS})
    with pytest.raises(RigError, match='none of the topics of this project'):
        read_recording(foreign)
    (tmp_path / 'empty').mkdir()
    with pytest.raises(RigError, match=r'holds no \.mcap file'):
        read_recording(tmp_path / 'empty')


def test_own_bag_needs_no_mapping_and_comes_back_the_same(bag: Path, tmp_path: Path) -> None:
    table, record = read_recording(bag), read_recording(bag)
    write_bag(table, tmp_path / 'again')
    again = read_recording(tmp_path / 'again')
    for name in ('position', 'velocity', 'pressure_1', 'pressure_2', 'voltage_1', 'voltage_2'):
        np.testing.assert_array_equal(getattr(again, name), getattr(record, name))
    assert again.interval_ns == record.interval_ns
    assert again.conditions == record.conditions


def test_velocity_is_made_as_the_rig_makes_it(bag: Path) -> None:
    record = read_recording(bag)
    made = smoothed_velocity(record.position, record.interval)
    np.testing.assert_allclose(made, record.velocity, atol=1e-12)
    slow = smoothed_velocity(np.array([0.0, 1.0, 3.0]), 0.02)
    np.testing.assert_allclose(slow, [0.0, 50.0, 100.0])


def part(*names: str) -> Recording:
    signals = {name: 2e5 + np.arange(50.0) for name in names}
    return Recording('here', 500_000_000, 10_000_000, signals)


def test_part_of_a_rig_is_kept_and_told_from_a_whole_one(tmp_path: Path) -> None:
    table = part('velocity', 'pressure_1', 'force')
    write_bag(table, tmp_path / 'part')
    again = read_recording(tmp_path / 'part')
    assert set(again.signals) == {'velocity', 'pressure_1', 'force'}
    for name in ('velocity', 'force'):
        np.testing.assert_array_equal(again[name], table[name])
    with pytest.raises(RigError, match='part: no position in it; it has pressure_1, force, velo'):
        assert again.position is None
    columns = [column.title for column in read_signals(tmp_path / 'part')[0]]
    assert columns == ['stamp_ns', 'time_s', 'velocity_m_per_s', 'pressure_1_Pa', 'force_N']


def test_gauge_pressures_bring_their_surroundings(tmp_path: Path) -> None:
    signals = {'pressure_1': np.full(4, 3e5)}
    table = Recording('here', 0, 1_000_000_000, signals, atmospheric_pressure=9.9e4)
    write_bag(table, tmp_path / 'told', {'load_mass': 1.0})
    text = (tmp_path / 'told' / 'conditions.yaml').read_text()
    assert text == 'load_mass: 1.0 kg\natmospheric_pressure: 99000.0 Pa\n'
    with pytest.raises(RigError, match='counted from 99000 Pa, but the conditions say'):
        write_bag(table, tmp_path / 'no', {'atmospheric_pressure': 1e5})
    assert os.listdir(tmp_path) == ['told']


def test_nothing_half_written_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RigError, match='voltage_1 without the other valve'):
        write_bag(part('position', 'voltage_1'), tmp_path / 'no')

    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(conversion, 'BLOCK', 10)
    with pytest.raises(KeyboardInterrupt):
        write_bag(part('position'), tmp_path / 'no', progress=interrupted)
    assert os.listdir(tmp_path) == []
    write_bag(part('position'), tmp_path / 'yes')
    with pytest.raises(RigError, match='exists; name a bag that does not'):
        write_bag(part('position'), tmp_path / 'yes')


def test_csv_reads_back_to_the_same_signals(bag: Path, tmp_path: Path) -> None:
    columns, _ = read_signals(bag)
    path = write_csv(columns, tmp_path / 'signals.csv')
    units = {'position': 'm', 'pressure_1': 'Pa', 'voltage_2': 'V'}
    mapping = {name: {'column': f'{name}_{unit}', 'unit': unit} for name, unit in units.items()}
    table = read_recording(path, {'time': {'column': 'time_s', 'unit': 's'}, **mapping})
    record = read_recording(bag)
    assert table.interval_ns == record.interval_ns
    for name in units:
        np.testing.assert_allclose(table[name], getattr(record, name), rtol=1e-9)
    assert path.read_text().splitlines()[1].endswith(',')  # no friction before the filter is full
    assert os.listdir(tmp_path) == ['signals.csv']


def test_parquet_holds_signals_units_and_conditions(bag: Path, tmp_path: Path) -> None:
    path = write_parquet(*read_signals(bag), tmp_path / 'signals.parquet')
    table, record = parquet.read_table(path), read_recording(bag)
    np.testing.assert_array_equal(table['position_m'].to_numpy(), record.position)
    np.testing.assert_array_equal(table['stamp_ns'].to_numpy(), record.stamps)
    assert table['friction_N'].null_count == int(np.isnan(record.friction).sum())
    assert table.schema.field('pressure_1_Pa').metadata == {b'unit': b'Pa'}
    assert b'supply_pressure: 400000.0 Pa' in table.schema.metadata[b'conditions']
    assert b'cylinder_2' in table.schema.metadata[b'configuration']


def test_what_was_read_is_what_its_bag_holds(foreign: Path, tmp_path: Path) -> None:
    full = read_recording(foreign, {'topics': TOPICS})
    lost = full.stamps[[7, 8, 200]]
    names = [name for name in full.signals if name != 'velocity']
    direct = replace(
        full,
        signals={name: full[name] for name in names},
        missing=dict.fromkeys(names, lost),
        conditions={'load_mass': 2.0},
    )
    write_bag(direct, tmp_path / 'bag')
    record = read_recording(tmp_path / 'bag')
    there = record.arrival_ns > 0
    for name in (*WHOLE, 'velocity', 'voltage_1', 'voltage_2'):
        was, reads = getattr(direct, name), getattr(record, name)
        np.testing.assert_allclose(reads[there], was[there], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(reads, was, rtol=1e-5, atol=4e-3)  # interpolated
    for topic in ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure'):
        np.testing.assert_array_equal(record.missing[topic], lost)
    assert direct.interval_ns == record.interval_ns
    assert record.conditions == {'load_mass': 2.0, 'atmospheric_pressure': 1e5}
    assert record.metadata['source'] == str(foreign)
