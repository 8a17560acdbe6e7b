"""A bag while it is being written, and when it cannot be: readable by all, losing nothing."""

import gc
import resource
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import BagWriter, bag, repair
from pneu_rig_ros.records.bag import open_bag
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.records.mcap_file import McapFile

FLOAT64 = 'std_msgs/msg/Float64'
Row = tuple[str, int, bytes]


@pytest.fixture
def writer(tmp_path: Path) -> Iterator[BagWriter]:
    made = BagWriter(tmp_path / 'bag')
    made.add_topic('/silent', FLOAT64)
    yield made
    made.abort()


def write(writer: BagWriter, topic: str, numbers: range) -> list[Row]:
    rows = [(topic, 1_000 * k, pack_float64(0.1 * k)) for k in numbers]
    for name, time, cdr in rows:
        writer.write(name, FLOAT64, time, cdr)
    writer.flush()
    return rows


def ours(path: Path) -> list[Row]:
    with open_bag(path) as reader:
        assert {c.topic for c in reader.connections} >= {'/silent', '/a'}
        rows = [(c.topic, t, bytes(data)) for c, t, data in reader.messages()]
        assert reader.message_count == len(rows)
        return rows


def of_rosbags(path: Path) -> list[Row]:
    with Reader(path / 'bag.mcap') as reader:
        return [(c.topic, t, bytes(data)) for c, t, data in reader.messages()]


def of_mcap(path: Path) -> list[Row]:
    with (path / 'bag.mcap').open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        return [(c.topic, m.log_time, m.data) for _, c, m in reader.iter_messages()]


@pytest.mark.parametrize('read', [ours, of_rosbags, of_mcap])
def test_three_readers_read_it_after_every_flush(writer, read):
    rows = []
    for k, topic in enumerate(('/a', '/a', '/late', '/a')):
        rows += write(writer, topic, range(500 * k, 500 * k + 300 + k))
        assert read(writer.path) == rows


def test_it_can_be_read_before_there_is_anything_in_it(writer):
    with open_bag(writer.path) as reader:
        assert reader.message_count == 0
    assert of_rosbags(writer.path) == of_mcap(writer.path) == []


def test_index_of_a_complete_bag_is_that_of_its_chunks(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/silent', FLOAT64)
        rows = write(writer, '/a', range(1000)) + write(writer, '/b', range(1000, 1500))
        growing = ours(writer.path)
    assert growing == rows
    assert ours(tmp_path / 'bag') == of_mcap(tmp_path / 'bag') == of_rosbags(tmp_path / 'bag')


def test_opened_while_it_grows_it_ends_where_it_ended_then(writer):
    first = write(writer, '/a', range(1000))
    with open_bag(writer.path) as reader:
        write(writer, '/a', range(1000, 2000))
        assert [(c.topic, t, bytes(data)) for c, t, data in reader.messages()] == first


def test_torn_file_is_refused_until_it_is_repaired(writer):
    rows = write(writer, '/a', range(1000))
    file = writer.path / 'bag.mcap'
    file.write_bytes(file.read_bytes() + b'\x06\xff\x00')
    with pytest.raises(RigError, match='run: pneu-rig repair'):
        ours(writer.path)
    assert repair(writer.path).repaired
    assert of_mcap(writer.path) == rows


def test_what_was_written_before_the_disk_was_full_stays(tmp_path):
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = BagWriter(tmp_path / 'bag')
    rows = write(writer, '/a', range(1000))
    size = (writer.path / 'bag.mcap').stat().st_size
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 4096, limits[1]))
    try:
        with pytest.raises(RigError, match=r'cannot write the bag .*: File too large'):
            write(writer, '/a', range(1000, 2000))
        assert of_mcap(writer.path) == of_rosbags(writer.path) == rows
        writer.close({})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    with Reader(writer.path) as reader:
        assert reader.message_count == 1000
    assert of_mcap(writer.path) == rows


def test_a_bag_appended_to_between_two_looks_is_looked_at_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[BinaryIO] = []

    def look(stream: BinaryIO) -> McapFile:
        looks.append(stream)
        if len(looks) == 1:
            raise RigError('in the middle of a piece')
        return McapFile(stream)

    monkeypatch.setattr(bag, 'ATTEMPTS', 2)
    monkeypatch.setattr(bag, 'McapFile', look)
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write('/u', 'std_msgs/msg/Float64', 1, pack_float64(0.3))
        writer.flush()
        with bag.open_bag(tmp_path / 'bag') as reader:
            assert reader.message_count == 1
    assert len(looks) == 2


def test_memory_of_a_writer_does_not_grow_with_its_bag(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        write(writer, '/a', range(1))
        tracemalloc.start()
        for k in range(1, 500):
            write(writer, '/a', range(k, k + 1))
        gc.collect()
        growth, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert growth < 20_000
