"""
What rosbag2 reads of a bag besides its messages: metadata.yaml, its copy in the file, channels.

The tables are the decoders of rosbag2_storage (yaml.hpp and qos.cpp of version 9, the same in the
branches jazzy and rolling), which convert each field to a type of C++ and end with an exception
where it is missing or does not fit.
"""

import copy
import re
import sys
from collections.abc import Callable
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.reader import make_reader
from mcap.records import Statistics
from mcap.summary import Summary

from pneu_rig_ros.records.description import distribution_of_wheels, format_metadata
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate


def integer(low: int, high: int) -> Callable[[Any], bool]:
    return lambda value: type(value) is int and low <= value <= high


def text(value: Any) -> bool:
    return type(value) is str


def name_of(*names: str) -> Callable[[Any], bool]:
    return lambda value: value in names


def flag(value: Any) -> bool:
    return type(value) is bool


INT, UINT64 = integer(-(2**31), 2**31 - 1), integer(0, 2**64 - 1)
INSTANT, LENGTH = {'nanoseconds_since_epoch': UINT64}, {'nanoseconds': UINT64}
RMW_TIME = {'sec': UINT64, 'nsec': UINT64}
QOS = {
    'history': name_of('system_default', 'keep_last', 'keep_all', 'unknown'),
    'depth': INT,
    'reliability': name_of('system_default', 'reliable', 'best_effort', 'unknown'),
    'durability': name_of('system_default', 'transient_local', 'volatile', 'unknown'),
    'deadline': RMW_TIME,
    'lifespan': RMW_TIME,
    'liveliness': name_of('system_default', 'automatic', 'manual_by_topic', 'unknown'),
    'liveliness_lease_duration': RMW_TIME,
    'avoid_ros_namespace_conventions': flag,
}
TOPIC = {
    'name': text,
    'type': text,
    'serialization_format': text,
    'offered_qos_profiles': [QOS],
    'type_description_hash': text,
}
FILE = {'path': text, 'starting_time': INSTANT, 'duration': LENGTH, 'message_count': UINT64}
BAG = {
    'version': integer(9, 9),
    'storage_identifier': text,
    'duration': LENGTH,
    'starting_time': INSTANT,
    'message_count': UINT64,
    'topics_with_message_count': [{'topic_metadata': TOPIC, 'message_count': UINT64}],
    'compression_format': text,
    'compression_mode': text,
    'relative_file_paths': [text],
    'files': [FILE],
    'custom_data': lambda value: value is None or all(map(text, [*value, *value.values()])),
    'ros_distro': text,
}


def mismatches(value: Any, form: Any, where: str = '') -> list[str]:
    """Return where a value is not of a form: a mapping, a list of one form, or a check."""
    if isinstance(form, dict):
        if not isinstance(value, dict) or value.keys() != form.keys():
            return [where]
        return [bad for key in form for bad in mismatches(value[key], form[key], f'{where}/{key}')]
    if isinstance(form, list):
        if not isinstance(value, list):
            return [where]
        return [bad for item in value for bad in mismatches(item, form[0], f'{where}/-')]
    return [] if form(value) else [where]


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('metadata') / 'bag'
    return simulate(load_configuration('cylinder_1'), 0.3, 0.2, path)


def information(document: str) -> dict[str, Any]:
    whole = yaml.safe_load(document)
    assert list(whole) == ['rosbag2_bagfile_information']
    return dict(whole['rosbag2_bagfile_information'])


def test_every_field_is_there_in_the_type_that_rosbag2_converts_to(bag: Path) -> None:
    document = (bag / 'metadata.yaml').read_text()
    assert mismatches(information(document), BAG) == []
    assert '&' not in document  # no alias, as QoS profiles are alike
    assert '\t' not in document


def test_check_of_the_form_sees_what_rosbag2_would_refuse(bag: Path) -> None:
    good = information((bag / 'metadata.yaml').read_text())
    for path, value in (
        ('version', 8),
        ('custom_data', {'seed': 1}),
        ('topics_with_message_count/0/topic_metadata/offered_qos_profiles', '- history: 1'),
        ('topics_with_message_count/0/topic_metadata/offered_qos_profiles/0/depth', 2**31),
        ('topics_with_message_count/0/topic_metadata/offered_qos_profiles/0/history', 1),
        ('files/0/message_count', -1),
    ):
        bad: Any = copy.deepcopy(good)
        *parents, last = [int(part) if part.isdigit() else part for part in path.split('/')]
        item = bad
        for key in parents:
            item = item[key]
        item[last] = value
        assert mismatches(bad, BAG), path


def test_file_repeats_them_for_ros2_bag_reindex(bag: Path) -> None:
    """Of the mcap plugin: record `rosbag2`, and QoS and type hash of each channel as texts."""
    document = information((bag / 'metadata.yaml').read_text())
    topics = [entry['topic_metadata'] for entry in document['topics_with_message_count']]
    with (bag / 'bag.mcap').open('rb') as stream:
        reader = make_reader(stream)
        profile, summary = reader.get_header().profile, reader.get_summary()
        (record,) = [m for m in reader.iter_metadata() if m.name == 'rosbag2']
    assert summary is not None
    assert profile == 'ros2'
    assert information(record.metadata['serialized_metadata']) == document
    for channel, topic in zip(summary.channels.values(), topics, strict=True):
        assert channel.topic == topic['name']
        assert summary.schemas[channel.schema_id].name == topic['type']
        assert summary.schemas[channel.schema_id].encoding == 'ros2msg'
        assert channel.metadata['topic_type_hash'] == topic['type_description_hash']
        profiles = yaml.safe_load(channel.metadata['offered_qos_profiles'])
        assert profiles == topic['offered_qos_profiles']


@pytest.mark.parametrize(
    ('environment', 'wheels', 'distribution'),
    [
        ('kilted', ['jazzy'], 'kilted'),
        ('', ['kilted'], 'kilted'),
        (None, ['jazzy'], 'jazzy'),
        (None, ['lyrical', 'jazzy'], 'lyrical'),  # rclpy is imported from the first folder
        (None, [], ''),  # as rosbag2
    ],
)
def test_distribution_is_that_of_the_environment_or_else_of_the_wheels(
    environment: str | None,
    wheels: list[str],
    distribution: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if environment is None:
        monkeypatch.delenv('ROS_DISTRO', raising=False)
    else:
        monkeypatch.setenv('ROS_DISTRO', environment)
    for name in wheels:
        (tmp_path / name / f'ros_{name}_rclpy-7.1.6.dist-info').mkdir(parents=True)
    summary = Summary()
    summary.statistics = Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)
    with monkeypatch.context() as patch:
        patch.setattr(sys, 'path', [str(tmp_path / name) for name in wheels])
        document = format_metadata('bag.mcap', summary, {})
    assert information(document)['ros_distro'] == distribution


def test_distribution_is_found_by_the_name_that_pip_gives_its_wheel() -> None:
    """The package ros-jazzy-rclpy, of which `distribution_of_wheels` looks up no metadata."""
    names = [re.fullmatch('ros-([a-z]+)-rclpy', str(each.name)) for each in distributions()]
    assert distribution_of_wheels() in ({name[1] for name in names if name} or {''})
