"""A recording refuses what is not one run on one grid, and says what is in it."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import BagWriter, Recording, read_recording
from pneu_rig_ros.records.bag import last_text, open_bag
from pneu_rig_ros.records.cdr_encoding import PlantMessages, pack_valve_voltages
from pneu_rig_ros.records.recording import WHOLE
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import Rig, Sample, load_configuration
from pneu_rig_ros.rig.sensors import sensor_noise
from pneu_rig_ros.rig.valve_drive import DAC_STEP, valve_voltages, voltages_of
from pneu_rig_ros.simulate import simulate

STEP = 1_160_000


def samples(count: int) -> list[Sample]:
    return [Sample(k, 1e-3 * k, 1e-3, 2e5 + k, 1.5e5 - k) for k in range(count)]


def write_bag(
    path: Path, stamps: list[int], lost: set[tuple[str, int]] = frozenset(), prefix: str = ''
) -> Path:
    """Write samples with these stamps [ns], without the lost (topic, index) ones."""
    messages = PlantMessages(pressure_variance=4.0)
    with BagWriter(path) as writer:
        for sample, stamp in zip(samples(len(stamps)), stamps, strict=True):
            for topic, cdr in messages.pack(sample, stamp).items():
                if (topic, sample.index) not in lost:
                    writer.write(f'{prefix}/{topic}', TOPICS[topic].type, stamp + 500, cdr)
    return path


def test_every_value_of_a_simulation_is_read_back(bag: Path) -> None:
    record = read_recording(bag)
    rig = Rig(load_configuration('cylinder_2', seed=7))
    expected = [rig.reset(), *(rig.step(*valve_voltages(0.34)) for _ in range(862))]
    assert record.position.tolist() == [sample.position for sample in expected]
    assert record.velocity.tolist() == [sample.velocity for sample in expected]
    assert record.pressure_1.tolist() == [sample.pressure_1 for sample in expected]
    assert record.pressure_2.tolist() == [sample.pressure_2 for sample in expected]
    assert set(zip(record.voltage_1[1:], record.voltage_2[1:], strict=True)) == {
        valve_voltages(0.34)
    }
    assert record.configuration == rig.configuration
    assert record.metadata['cylinder'] == 'cylinder_2'
    assert record.metadata['seed'] == '7'


def test_bag_of_ros2_bag_record_says_by_topic_what_rig_it_is_of(bag: Path, tmp_path: Path) -> None:
    # rosbag2 writes '~' where the recorder of this package keeps the configuration
    copy = shutil.copytree(bag, tmp_path / 'copy')
    data = yaml.safe_load((bag / 'metadata.yaml').read_text())
    assert data['rosbag2_bagfile_information']['custom_data']
    data['rosbag2_bagfile_information']['custom_data'] = None
    (copy / 'metadata.yaml').write_text(yaml.safe_dump(data))
    record = read_recording(copy)
    assert record.configuration == load_configuration('cylinder_2', seed=7)
    assert record.metadata['cylinder'] == 'cylinder_2'


def test_grid_is_exact(bag: Path) -> None:
    record = read_recording(bag)
    assert record.start_ns == 0
    assert record.stamps.tolist() == [STEP * k for k in range(863)]
    assert record.duration == pytest.approx(0.99992)
    np.testing.assert_array_equal(record.arrival_ns, record.stamps)


def test_bag_of_a_slow_rig_has_a_finite_velocity_and_no_friction(tmp_path: Path) -> None:
    slow = replace(load_configuration('cylinder_2'), interval_ns=16_000_000)
    record = read_recording(simulate(slow, 0.34, 2.0, tmp_path / 'slow'))
    assert 'friction' not in record.counts
    assert np.abs(record['velocity']).max() < 1.0


def test_missing_samples_are_named_by_stamp_and_bridged(tmp_path: Path) -> None:
    start = 1_700_000_000_000_000_000
    stamps = [start + STEP * k for k in range(50)]
    lost = {('joint_states', 20), ('joint_states', 21), ('chamber_2/pressure', 0)}
    record = read_recording(write_bag(tmp_path / 'bag', stamps, lost))
    assert record.missing['joint_states'].tolist() == [stamps[20], stamps[21]]
    assert record.missing['chamber_1/pressure'].tolist() == []
    assert record.missing['chamber_2/pressure'].tolist() == [stamps[0]]
    assert record.position[20] == pytest.approx(0.020)
    assert record.arrival_ns[19:23].tolist() == [stamps[19] + 500, -1, -1, stamps[22] + 500]


def test_namespace_is_found(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / 'bag', [0, STEP, 2 * STEP], prefix='/lab/rig_a')
    assert read_recording(bag).counts['joint_states'] == 3


def test_two_rigs_in_one_bag_are_refused(tmp_path: Path) -> None:
    messages = PlantMessages(pressure_variance=4.0).pack(samples(1)[0], 0)
    with BagWriter(tmp_path / 'bag') as writer:
        for name in ('/a/joint_states', '/b/joint_states'):
            writer.write(name, TOPICS['joint_states'].type, 0, messages['joint_states'])
    with pytest.raises(RigError, match='several rigs, /a, /b'):
        read_recording(tmp_path / 'bag')


def test_last_text_of_a_topic_is_found(bag: Path) -> None:
    with open_bag(bag) as reader:
        assert '<joint name="piston" type="prismatic">' in last_text(reader, 'robot_description')
        assert last_text(reader, 'joint_states') == last_text(reader, 'nothing') == ''


def test_voltages_hold_from_their_arrival(tmp_path: Path) -> None:
    messages = PlantMessages(pressure_variance=4.0)
    type_name = TOPICS['valve_voltages'].type
    with BagWriter(tmp_path / 'bag') as writer:
        for sample in samples(6):
            for topic, cdr in messages.pack(sample, STEP * sample.index).items():
                writer.write(f'/{topic}', TOPICS[topic].type, STEP * sample.index, cdr)
            if sample.index == 2:
                late = STEP * 2 + 10
                writer.write('/valve_voltages', type_name, late, pack_valve_voltages(3.0, 2.0))
    record = read_recording(tmp_path / 'bag')
    rest = valve_voltages(0.0)
    assert record.voltage_1.tolist() == [rest[0]] * 3 + [3.0] * 3
    assert record.voltage_2.tolist() == [rest[1]] * 3 + [2.0] * 3


@pytest.mark.parametrize(
    ('stamps', 'message'),
    [
        ([0, STEP, STEP + 7, 3 * STEP], 'is .* off the sampling grid'),
        ([0, STEP, 2 * STEP, STEP], 'stamps must increase'),
        ([0, STEP, STEP, 2 * STEP], 'stamps must increase'),
    ],
)
def test_stamps_off_the_grid_are_refused(
    tmp_path: Path, bag: Path, stamps: list[int], message: str
) -> None:
    path = write_bag(tmp_path / 'bag', stamps)
    with pytest.raises(RigError, match=message):
        read_recording(path)


def test_stamps_that_jitter_are_put_on_a_uniform_grid(tmp_path: Path) -> None:
    """As of a controller that stamps with the processor's clock: 3 % of the interval, rms."""
    start, count = 1_700_000_000_000_000_000, 2000
    jitter = np.clip(0.03 * np.random.default_rng(1).standard_normal(count), -0.2, 0.2)
    stamps = [start + STEP * k + round(STEP * each) for k, each in enumerate(jitter)]
    record = read_recording(write_bag(tmp_path / 'bag', stamps, {('joint_states', 20)}))
    assert record.interval_ns == STEP
    assert abs(record.start_ns - start) < 0.01 * STEP
    assert record.position.tolist() == pytest.approx([1e-3 * k for k in range(count)])
    assert record.missing['joint_states'].tolist() == [record.start_ns + 20 * STEP]
    arrived = np.delete(record.arrival_ns - record.stamps, 20)
    assert arrived.min() >= 0
    assert arrived.max() < 0.2 * STEP


def test_bag_without_a_rig_is_refused(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/chatter', 'std_msgs/msg/String')
    with pytest.raises(RigError, match='none of the topics of this project; map its own'):
        read_recording(tmp_path / 'bag')


def test_no_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RigError, match='does not exist'):
        read_recording(tmp_path / 'nowhere')
    with pytest.raises(RigError, match=r'holds no \.mcap file'):
        read_recording(tmp_path)


def ramp() -> Recording:
    values = np.linspace(0.0, 1.0, 10)
    signals = ('position', 'velocity', 'pressure_1', 'pressure_2', 'voltage_1', 'voltage_2')
    return Recording('ramp', 0, STEP, {name: values.copy() for name in (*signals, 'friction')})


@pytest.mark.parametrize('name', ['velocity', 'pressure_2', 'friction'])
def test_unequal_lengths_are_refused(name: str) -> None:
    with pytest.raises(RigError, match=rf'{name} has shape \(9,\), position has \(10,\)'):
        ramp().with_signals(**{name: np.zeros(9)})


def test_voltages_of_many_commands_are_those_of_each() -> None:
    u = np.concatenate([np.linspace(-3.0, 3.0, 5001), np.arange(-2048, 2049) * 0.5 * DAC_STEP])
    expected = [valve_voltages(command) for command in u.tolist()]
    np.testing.assert_array_equal(np.stack(voltages_of(u), axis=1), expected)


def test_arrivals_are_as_many_as_the_samples_and_else_their_stamps() -> None:
    assert ramp().arrival_ns.tolist() == ramp().stamps.tolist()
    with pytest.raises(RigError, match=r'arrival_ns has shape \(9,\), position has \(10,\)'):
        replace(ramp(), arrival_ns=np.zeros(9, dtype=np.int64))


@pytest.mark.parametrize('bad', [np.nan, np.inf])
def test_values_that_are_not_finite_are_refused(bad: float) -> None:
    values = np.zeros(10)
    values[4] = bad
    with pytest.raises(RigError, match=r'pressure_1 is .* at sample 4, must be finite'):
        ramp().with_signals(pressure_1=values)


def test_friction_may_have_gaps_but_no_infinity() -> None:
    values = np.zeros(10)
    values[0] = np.nan
    assert np.isnan(ramp().with_signals(friction=values).friction[0])
    values = np.full(10, np.inf)
    with pytest.raises(RigError, match='friction is inf'):
        ramp().with_signals(friction=values)


def test_signals_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match='read-only'):
        ramp().position[0] = 1.0


def test_what_is_there_is_told() -> None:
    part = Recording('seal', 0, STEP, {'position': np.zeros(4), 'force': np.ones(4)})
    assert 'force' in part
    assert 'u' not in part
    with pytest.raises(RigError, match=r'^seal: no pressure_1 in it; it has position, force$'):
        part['pressure_1']
    with pytest.raises(RigError, match='no voltage_1 in it'):
        assert part.voltage_1 is None
    assert not part.driven
    with pytest.raises(RigError, match='empty: no samples'):
        Recording('empty', 0, STEP, {})


def test_voltages_and_velocity_follow_from_what_there_is() -> None:
    u = np.array([0.0, 0.0, 0.34, 0.34])
    recording = Recording('driven', 0, STEP, {'position': 1e-3 * np.arange(4.0), 'u': u})
    assert recording.driven
    pairs = zip(recording.voltage_1, recording.voltage_2, strict=True)
    assert list(pairs) == [valve_voltages(value) for value in u]
    assert recording.velocity.shape == (4,)
    assert recording.with_signals(velocity=np.ones(4)).velocity.tolist() == [1.0] * 4


def test_a_part_keeps_its_stamps() -> None:
    whole = replace(ramp(), missing={'joint_states': np.array([2 * STEP, 7 * STEP])})
    part = whole.cut(3, 9)
    assert part.stamps.tolist() == whole.stamps[3:9].tolist()
    assert part.arrival_ns.tolist() == whole.arrival_ns[3:9].tolist()
    assert part.missing['joint_states'].tolist() == [7 * STEP]
    np.testing.assert_array_equal(part['velocity'], whole['velocity'][3:9])
    assert part.time[0] == 0.0


def test_noise_and_resolution_are_those_of_the_sensors(bag: Path) -> None:
    recording = read_recording(bag)
    sensors = load_configuration('cylinder_2').sensors
    position, pressure = sensor_noise(sensors)
    assert recording.noise['position'] == pytest.approx(position, rel=0.2)
    assert recording.noise['pressure_1'] == pytest.approx(pressure, rel=0.5)
    assert recording.resolution['position'] == pytest.approx(sensors.position_span / 4095)
    assert recording.noise['voltage_1'] == recording.resolution['voltage_1'] == 0.0


def test_own_bag_brings_name_conditions_and_command(bag: Path) -> None:
    recording = read_recording(bag / f'{bag.name}.mcap')
    assert recording.name == bag.name
    assert recording.conditions['supply_pressure'] == 4e5
    assert set(recording['u'][1:]) == {0.34}
    assert set(recording.signals) == {
        *WHOLE,
        'velocity',
        'friction',
        'u',
        'voltage_1',
        'voltage_2',
    }
