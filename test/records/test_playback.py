"""Bags for playing: order of the messages, choice of topics, and what `ros2 bag play` reads."""

import shutil
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from mcap.writer import IndexType, Writer

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.playback import COMPUTED, Playback
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('playback') / 'bag'
    return simulate(load_configuration('cylinder_1'), 0.3, 0.5, path)


def test_messages_come_in_order_with_causes_before_effects(bag: Path) -> None:
    with Playback(bag) as playback:
        messages = list(playback.messages())
        assert playback.duration == pytest.approx(0.5, abs=2e-3)
        assert not COMPUTED & set(playback.topics)
    times = [message.time_ns for message in messages]
    assert times == sorted(times)
    for stamp in set(times[100:]) - {times[-1]}:  # the last sample has no answer
        topics = [m.topic for m in messages if m.time_ns == stamp]
        assert topics[0] == 'joint_states'
        assert topics[-1] == 'valve_voltages'


def test_file_whose_chunks_have_no_index_of_messages_is_played(bag: Path, tmp_path: Path) -> None:
    """That index is optional in MCAP."""
    other = tmp_path / bag.name
    shutil.copytree(bag, other)
    (file,), (old,) = other.glob('*.mcap'), bag.glob('*.mcap')
    with old.open('rb') as source, file.open('wb') as target:
        writer = Writer(target, index_types=IndexType.ALL & ~IndexType.MESSAGE)
        writer.start('ros2')
        channels: dict[int, int] = {}
        for schema, channel, message in make_reader(source).iter_messages():
            assert schema is not None
            if channel.id not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, 'cdr', known)
            own, time = channels[channel.id], message.log_time
            writer.add_message(own, time, message.data, message.publish_time)
        writer.finish()
    with Playback(bag) as expected, Playback(other) as playback:
        assert list(playback.messages()) == list(expected.messages())


def test_topics_are_chosen(bag: Path) -> None:
    with Playback(bag, only=['u', 'friction']) as playback:
        assert {m.topic for m in playback.messages()} == {'u', 'friction'}
    with Playback(bag, without=['u']) as playback:
        assert 'u' not in playback.topics


@pytest.mark.parametrize(
    ('only', 'without', 'told'),
    [
        (['speed'], [], 'speed is not a topic of a rig'),
        ([], ['speed'], 'speed is not a topic of a rig'),
        (['reference'], [], 'no message on reference'),
        (['u'], ['u'], 'no topic is left'),
    ],
)
def test_a_wrong_choice_is_refused(bag: Path, only: list[str], without: list[str], told: str):
    with pytest.raises(RigError, match=told), Playback(bag, only, without):
        pass


def test_damage_is_told_with_its_repair(bag: Path, tmp_path: Path) -> None:
    damaged = tmp_path / bag.name
    shutil.copytree(bag, damaged)
    (file,) = damaged.glob('*.mcap')
    data = bytearray(file.read_bytes())
    data[len(data) // 3] ^= 1
    file.write_bytes(data)
    with Playback(damaged) as playback, pytest.raises(RigError, match='pneu-rig repair'):
        list(playback.messages())


def test_metadata_are_those_that_rosbag2_writes(bag: Path) -> None:
    information = yaml.safe_load((bag / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information'
    ]
    assert information['version'] == 9
    assert information['storage_identifier'] == 'mcap'
    assert [bag / name for name in information['relative_file_paths']] == list(bag.glob('*.mcap'))
    for entry in information['topics_with_message_count']:
        topic = entry['topic_metadata']
        known = TOPICS[topic['name'] if topic['name'] in TOPICS else topic['name'].lstrip('/')]
        (quality,) = topic['offered_qos_profiles']
        assert topic['type'] == known.type
        assert topic['serialization_format'] == 'cdr'
        assert topic['type_description_hash'].startswith('RIHS01_')
        assert quality['reliability'] == 'reliable'
        assert quality['history'] == 'keep_last'
        assert quality['depth'] == known.depth
        assert quality['durability'] == (
            'transient_local' if known.transient_local else 'volatile'
        )
        assert quality['deadline'] == {'sec': 9_223_372_036, 'nsec': 854_775_807}


def test_predictions_are_not_taken_for_another_rig(tmp_path: Path) -> None:
    source = simulate(load_configuration('cylinder_1'), 0.3, 0.1, tmp_path / 'plain')
    with BagWriter(tmp_path / 'both') as writer, Playback(source) as plain:
        for message in plain.messages():
            for prefix in ('/left/', '/left/predicted/'):
                if prefix == '/left/' or f'predicted/{message.topic}' in TOPICS:
                    kind = TOPICS[message.topic].type
                    writer.write(prefix + message.topic, kind, message.time_ns, message.cdr)
    with Playback(tmp_path / 'both') as playback:
        assert 'predicted/joint_states' not in playback.topics
        assert 'joint_states' in playback.topics
    with Playback(tmp_path / 'both', only=['predicted/joint_states']) as playback:
        assert len(list(playback.messages())) == 87
