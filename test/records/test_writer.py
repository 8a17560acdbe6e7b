"""What the writer writes, every reader reads: rosbags, mcap, mcap with ROS 2 support."""

import resource
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.cdr_encoding import pack_float64

FLOAT64 = 'std_msgs/msg/Float64'
Row = tuple[str, int, bytes]


def messages() -> list[Row]:
    """Two topics, 3 000 messages, some of them a little late."""
    return [
        (f'/t{k % 2}', 1_000 * k - (700 if k % 5 == 0 else 0) + 10_000, pack_float64(0.1 * k))
        for k in range(3000)
    ]


@pytest.fixture
def written(tmp_path: Path) -> Path:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/silent', 'std_msgs/msg/String')
        for k, (topic, log_time, cdr) in enumerate(messages()):
            writer.write(topic, FLOAT64, log_time, cdr)
            if k % 1000 == 500:
                writer.flush()
        writer.close({'seed': '3', 'configuration': 'a: 1\n# ü\n'})
    return tmp_path / 'bag'


def by_time(rows: list[Row]) -> list[Row]:
    return sorted(rows, key=lambda row: row[1])


def test_rosbags_reads_back_every_message(written: Path) -> None:
    with Reader(written) as reader:
        rows = [(c.topic, t, bytes(data)) for c, t, data in reader.messages()]
        assert {c.topic: c.msgcount for c in reader.connections} == {
            '/silent': 0,
            '/t0': 1500,
            '/t1': 1500,
        }
        assert reader.message_count == 3000
        assert reader.start_time == min(row[1] for row in messages())
        assert reader.storage.metadata.custom == {'seed': '3', 'configuration': 'a: 1\n# ü\n'}
    assert sorted(rows) == sorted(messages())


def test_mcap_reads_back_every_message_and_the_statistics(written: Path) -> None:
    with (written / 'bag.mcap').open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        times = [row[1] for row in messages()]
        assert summary.statistics.message_count == 3000
        assert summary.statistics.message_start_time == min(times)
        assert summary.statistics.message_end_time == max(times)
        assert sum(summary.statistics.channel_message_counts.values()) == 3000
        assert len(summary.chunk_indexes) == 4
        rows = [(c.topic, m.log_time, m.data) for _, c, m in reader.iter_messages()]
    assert rows == by_time(messages())


def test_mcap_ros2_decodes_every_value(written: Path) -> None:
    with (written / 'bag.mcap').open('rb') as stream:
        decoded = list(
            make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        )
    values = [(channel.topic, message.log_time, ros.data) for _, channel, message, ros in decoded]
    assert values == [
        (topic, log_time, 0.1 * k)
        for log_time, k, topic in sorted(
            (log_time, k, topic) for k, (topic, log_time, _) in enumerate(messages())
        )
    ]


def test_flush_puts_all_messages_into_the_file(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / 'bag')
    for topic, log_time, cdr in messages()[:100]:
        writer.write(topic, FLOAT64, log_time, cdr)
    file = tmp_path / 'bag' / 'bag.mcap'
    assert file.stat().st_size < 100 * 12
    writer.flush()
    assert file.stat().st_size > 100 * 12
    size = file.stat().st_size
    writer.flush()
    assert file.stat().st_size == size
    writer.abort()


def test_bag_without_messages_is_readable(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/silent', FLOAT64)
    with Reader(tmp_path / 'bag') as reader:
        assert [c.topic for c in reader.connections] == ['/silent']
        assert reader.message_count == 0
        assert list(reader.messages()) == []


def test_exception_leaves_a_file_without_index(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), BagWriter(tmp_path / 'bag') as writer:
        writer.write('/t', FLOAT64, 1, pack_float64(1 / 0))
    assert not (tmp_path / 'bag' / 'metadata.yaml').exists()


def test_existing_path_is_refused_and_kept(tmp_path: Path) -> None:
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'precious').write_text('data')
    with pytest.raises(RigError, match='bag exists; name a bag that does not'):
        BagWriter(tmp_path / 'bag')
    assert (tmp_path / 'bag' / 'precious').read_text() == 'data'


def test_path_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    with pytest.raises(RigError, match=r'cannot write the bag .*: Not a directory'):
        BagWriter(tmp_path / 'file' / 'bag')


def test_unknown_type_is_refused(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer, pytest.raises(RigError, match='nosuch_msgs'):
        writer.write('/t', 'nosuch_msgs/msg/Nothing', 1, b'')


def test_full_disk_is_told_in_one_line(tmp_path: Path) -> None:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = BagWriter(tmp_path / 'bag')
    for k in range(1000):
        writer.write('/t', FLOAT64, k, pack_float64(1.0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with pytest.raises(RigError, match=r'cannot write the bag .*: File too large'):
            writer.flush()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        writer.abort()
