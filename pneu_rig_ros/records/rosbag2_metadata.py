"""The metadata.yaml of a rosbag2 directory, version 9 since ROS 2 Jazzy, with a checksum."""

import os
import re
import sys
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any
from zlib import crc32

import yaml
from mcap.summary import Summary

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.topics import STREAM_DEPTH, topic_named
from pneu_rig_ros.records.whole_files import atomic_write
from pneu_rig_ros.rig.yaml_file import parse_yaml

FILE_NAME = 'metadata.yaml'

LARGEST_METADATA = 10_000_000
"""Of metadata.yaml [byte]."""

NEEDS_CONVERSION = ('file', 'message')
"""Ways to compress a whole bag that do not limit the decompressed size."""

TYPE_HASH = 'topic_type_hash'
"""Key of the RIHS01 type hash in the metadata of an MCAP channel, as rosbag2 names it."""

_KEY = 'rosbag2_bagfile_information'
_CHECKSUM = '# crc32 {:08x}\n'
_WITH_CHECKSUM = re.compile(rb'(?P<text>.*\n)# crc32 (?P<crc>[0-9a-f]{8})\n', re.DOTALL)


def distribution_of_wheels() -> str:
    """
    Return of which ROS 2 distribution rclpy is installed as a wheel, '' as rosbag2 without one.

    importlib.metadata would take 0.15 s, as it lists all packages to find one by a pattern.
    """
    for folder in map(Path, sys.path):
        for path in folder.glob('ros_*_rclpy-*.dist-info'):
            return path.name.split('_')[1]
    return ''


def offered_qos(topic: str) -> dict[str, Any]:
    """Return the quality of service that `ros2 bag play` gives a topic, as the live one has."""
    known = topic_named(topic)
    latched = known is not None and known.transient_local

    def forever() -> dict[str, int]:  # each time another object: YAML needs no alias for it
        return {'sec': 9_223_372_036, 'nsec': 854_775_807}

    return {
        'history': 'keep_last',
        'depth': known.depth if known else STREAM_DEPTH,
        'reliability': 'reliable',
        'durability': 'transient_local' if latched else 'volatile',
        'deadline': forever(),
        'lifespan': forever(),
        'liveliness': 'automatic',
        'liveliness_lease_duration': forever(),
        'avoid_ros_namespace_conventions': False,
    }


def format_metadata(file_name: str, summary: Summary, custom_data: Mapping[str, str]) -> str:
    """Return the text of metadata.yaml for a bag of one MCAP file with this index."""
    statistics = summary.statistics
    assert statistics is not None
    start, end = statistics.message_start_time, statistics.message_end_time
    extent = {
        'starting_time': {'nanoseconds_since_epoch': start},
        'duration': {'nanoseconds': end - start},
        'message_count': statistics.message_count,
    }
    counts = statistics.channel_message_counts
    information = {
        'version': 9,
        'storage_identifier': 'mcap',
        **extent,
        'topics_with_message_count': [
            {
                'topic_metadata': {
                    'name': channel.topic,
                    'type': summary.schemas[channel.schema_id].name,
                    'serialization_format': channel.message_encoding,
                    'offered_qos_profiles': [offered_qos(channel.topic)],
                    'type_description_hash': channel.metadata[TYPE_HASH],
                },
                'message_count': counts.get(channel.id, 0),
            }
            for channel in summary.channels.values()
        ],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [file_name],
        # a copy, as YAML would refer to the same objects by an alias
        'files': [{'path': file_name, **deepcopy(extent)}],
        'custom_data': dict(custom_data) or None,
        'ros_distro': os.environ.get('ROS_DISTRO') or distribution_of_wheels(),
    }
    return yaml.safe_dump({_KEY: information}, allow_unicode=True)


def write_metadata(directory: Path, text: str) -> None:
    """Write metadata.yaml with a comment at its end that has its checksum."""
    atomic_write(directory / FILE_NAME, text + _CHECKSUM.format(crc32(text.encode())))


def read_metadata(directory: Path) -> dict[str, Any]:
    """
    Return the bag information in the metadata.yaml of a bag, {} without one.

    :raises RigError: when it was changed, is invalid, or needs unlimited memory
    """
    path = directory / FILE_NAME
    if not path.is_file():
        return {}
    with path.open('rb') as file:
        data = file.read(LARGEST_METADATA + 1)
    checked = _WITH_CHECKSUM.fullmatch(data)
    if checked and crc32(checked['text']) != int(checked['crc'], 16):
        raise RigError(
            f'{path}: changed since it was written, its checksum does not fit; where '
            'that was on purpose, delete its last line'
        )
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        raise RigError(f'{path}: {error}') from None
    whole = parse_yaml(text, str(path), LARGEST_METADATA, LARGEST_METADATA)
    information = whole.get(_KEY) if isinstance(whole, dict) else None
    if not isinstance(information, dict):
        raise RigError(f'{path}: lacks {_KEY}')
    mode = str(information.get('compression_mode')).lower()
    if mode in NEEDS_CONVERSION:
        raise RigError(
            f'{directory}: compressed {mode} by {mode}; '
            'uncompressed or compressed chunks are read: ros2 bag convert'
        )
    return information
