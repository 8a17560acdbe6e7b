"""A killed recorder costs less than half a second, and repair never makes things worse."""

import os
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import BagWriter, read_recording, repair
from pneu_rig_ros.records.writer import Definition

Row = tuple[str, int, bytes]

# Writes at the pace of the rig and says every sample that it has handed to the writer.
WRITER = """
import sys, time
from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.description import describe
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.records.cdr_encoding import PlantMessages, pack_string
from pneu_rig_ros.rig import Rig, load_configuration
rig = Rig(load_configuration('cylinder_1', seed=11))
messages = PlantMessages(rig.sensors.pressure_variance, clock=True)
writer = BagWriter(sys.argv[1])
text = pack_string(describe(rig.configuration))
writer.write('/rig_description', 'std_msgs/msg/String', 0, text)
sample, start = rig.reset(), time.monotonic_ns()
while True:
    stamp = sample.index * rig.configuration.interval_ns
    while time.monotonic_ns() < start + stamp:
        time.sleep(0.0005)
    for topic, cdr in messages.pack(sample, stamp).items():
        writer.write('/' + topic.lstrip('/'), TOPICS[topic].type, stamp, cdr)
    print(sample.index, flush=True)
    sample = rig.step(2.9, 2.1)
"""


def content(directory: Path) -> list[Row]:
    with Reader(directory) as reader:
        return sorted((c.topic, t, bytes(data)) for c, t, data in reader.messages())


def snapshot(directory: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in directory.iterdir()}


@pytest.mark.parametrize('attempt', [0, pytest.param(1, marks=pytest.mark.long)])
def test_recorder_killed_at_a_random_moment(tmp_path: Path, attempt: int) -> None:
    bag = tmp_path / 'bag'
    last = random.Random(attempt).randrange(800, 1800)
    with subprocess.Popen(
        [sys.executable, '-c', WRITER, str(bag)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        written = next(index for index in map(int, process.stdout) if index >= last)
        os.kill(process.pid, signal.SIGKILL)
    before = read_recording(bag)
    report = repair(bag)
    assert report.repaired
    assert report.configuration_found
    record = read_recording(bag)
    assert written - record.position.size < 0.5 / 1.16e-3
    assert before.position.tolist() == record.position.tolist()
    assert before.metadata == record.metadata
    # A chunk may end between two messages of one sample.
    assert all(set(stamps) <= {record.stamps[-1]} for stamps in record.missing.values())
    assert record.configuration is not None
    assert record.configuration.seed == 11
    assert not repair(bag).repaired


def test_repaired_bag_is_read_alike_by_three_readers(
    bag: Path, cut: Callable[[int], Path]
) -> None:
    broken = cut((bag / 'second.mcap').stat().st_size // 2)
    report = repair(broken)
    rows = content(broken)
    assert set(rows) <= set(content(bag))
    assert report.messages == len(rows) > 100
    with (broken / f'{broken.name}.mcap').open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        decoded = list(reader.iter_decoded_messages())
    assert sorted((c.topic, m.log_time, m.data) for _, c, m, _ in decoded) == rows
    record = read_recording(broken)
    positions = [ros.position[0] for _, c, _, ros in decoded if c.topic == '/joint_states']
    forces = [ros.fluid_pressure for _, c, _, ros in decoded if c.topic == '/chamber_1/pressure']
    assert record.position.tolist() == positions
    # the cut may be within a sample: its pressure is then not there
    assert len(positions) - 1 <= len(forces) <= len(positions)
    assert record.pressure_1.tolist()[: len(forces)] == forces


@pytest.mark.parametrize('share', [0.2, 0.4, 0.5, 0.6, 0.8, 0.9, 0.99, 0.99999])
def test_cut_anywhere_gives_the_messages_up_to_there(
    bag: Path, cut: Callable[[int], Path], share: float
) -> None:
    broken = cut(int(share * (bag / 'second.mcap').stat().st_size))
    before = snapshot(broken)
    report = repair(broken)
    assert set(content(broken)) <= set(content(bag))
    assert report.cut_file is not None
    assert report.cut_file.read_bytes() == before[f'{broken.name}.mcap']
    assert list(broken.parent.iterdir()) == [broken]


@pytest.mark.parametrize('size', [0, 7, 8, 30, 100, 1000])
def test_cut_before_the_first_message_is_told_and_kept(
    cut: Callable[[int], Path], size: int
) -> None:
    broken = cut(size)
    before = snapshot(broken)
    with pytest.raises(RigError, match='nothing to recover'):
        repair(broken)
    assert snapshot(broken) == before
    assert list(broken.parent.iterdir()) == [broken]


def test_whole_file_without_metadata_loses_nothing(bag: Path, cut: Callable[[int], Path]) -> None:
    broken = cut((bag / 'second.mcap').stat().st_size)
    assert repair(broken).repaired
    assert content(broken) == content(bag)
    assert read_recording(broken).metadata == read_recording(bag).metadata


def test_topic_of_a_type_that_ros_lacks_is_kept(tmp_path: Path) -> None:
    """Its definition is in the file."""
    bag, text = tmp_path / 'bag', b'float64 torque\n'
    with BagWriter(bag) as writer:
        writer.add_topic('/gripper', 'lab_msgs/msg/Grip', Definition(text, 'ros2msg', 'RIHS01_0'))
        writer.write('/gripper', 'lab_msgs/msg/Grip', 1, b'\0\1\0\0' + bytes(8))
        writer.write('/u', 'std_msgs/msg/Float64', 2, b'\0\1\0\0' + bytes(8))
        writer.close({})
    whole = (bag / 'bag.mcap').read_bytes()
    (bag / 'metadata.yaml').unlink()
    report = repair(bag)
    assert (report.repaired, report.messages) == (True, 2)
    assert (bag / 'bag.mcap').read_bytes() == whole


def test_healthy_bag_is_left_alone(bag: Path) -> None:
    before = snapshot(bag)
    report = repair(bag)
    assert not report.repaired
    assert report.cut_file is None
    assert report.messages == len(content(bag))
    assert snapshot(bag) == before


def test_damage_in_the_middle_is_found(bag: Path, cut: Callable[[int], Path]) -> None:
    size = (bag / 'second.mcap').stat().st_size
    broken = cut(size)
    (broken / 'metadata.yaml').write_bytes(
        (bag / 'metadata.yaml')
        .read_bytes()
        .replace(b'second.mcap', f'{broken.name}.mcap'.encode())
    )
    file = broken / f'{broken.name}.mcap'
    data = bytearray(file.read_bytes())
    data[size // 4 : size // 4 + 4000] = bytes(4000)
    file.write_bytes(data)
    report = repair(broken)
    assert report.repaired
    assert report.messages < len(content(bag))


def first_chunk_damaged(bag: Path, folder: Path) -> Path:
    """Return a copy of a bag with one bit changed in the chunk that says the configuration."""
    broken = Path(shutil.copytree(bag, folder / 'broken'))
    file = broken / f'{bag.name}.mcap'
    data = bytearray(file.read_bytes())
    data[data.index(b'cap_dead_volume')] ^= 1
    file.write_bytes(data)
    return broken


def test_configuration_in_intact_metadata_is_kept(bag: Path, tmp_path: Path) -> None:
    broken = first_chunk_damaged(bag, tmp_path)
    report = repair(broken)
    assert (report.repaired, report.damaged_chunks) == (True, 1)
    assert (report.configuration_found, report.configuration_lost) == (True, False)
    assert read_recording(broken).metadata == read_recording(bag).metadata


@pytest.mark.parametrize('damage', ['removed', 'changed', 'cut off'])
def test_configuration_lost_with_its_chunk_is_told(bag: Path, tmp_path: Path, damage: str) -> None:
    broken = first_chunk_damaged(bag, tmp_path)
    metadata = broken / 'metadata.yaml'
    text = metadata.read_text()
    changed = {'changed': text.replace('cylinder_2', 'cylinder_3'), 'cut off': text[:1600]}
    metadata.unlink() if damage == 'removed' else metadata.write_text(changed[damage])
    report = repair(broken)
    assert (report.configuration_found, report.configuration_lost) == (False, True)
    assert read_recording(broken).configuration is None


def test_configuration_is_not_lost_with_another_chunk(
    bag: Path, cut: Callable[[int], Path]
) -> None:
    size = (bag / 'second.mcap').stat().st_size
    file = (broken := cut(size)) / f'cut_{size}.mcap'
    data = bytearray(file.read_bytes())
    data[data.index(b'piston', size // 2)] ^= 1
    file.write_bytes(data)
    report = repair(broken)
    assert report.damaged_chunks == 1
    assert (report.configuration_found, report.configuration_lost) == (True, False)


@pytest.mark.parametrize('stage', ['link', 'replace'])
def test_failure_while_swapping_keeps_the_cut_file(
    bag: Path, cut: Callable[[int], Path], stage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = cut((bag / 'second.mcap').stat().st_size // 2)
    before = snapshot(broken)

    def fail(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(*((os, 'link') if stage == 'link' else (Path, 'replace')), fail)
        with pytest.raises(KeyboardInterrupt):
            repair(broken)
    assert before.items() <= snapshot(broken).items()
    assert repair(broken).repaired


def test_no_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RigError, match='does not exist'):
        repair(tmp_path / 'nowhere')
