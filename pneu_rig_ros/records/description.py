"""
What describes a bag: the text on the topic `rig_description`, its custom data, its metadata.yaml.

The text is the configuration's YAML, headed by a comment with package version and git revision.
The custom data follow from the text, so that a bag whose end is missing gets them back from the
recorded message. metadata.yaml is of version 9, since ROS 2 Jazzy, with a checksum.
"""

import functools
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from copy import deepcopy
from importlib import metadata
from pathlib import Path
from typing import Any
from zlib import crc32

import yaml
from mcap.summary import Summary

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.topics import STREAM_DEPTH, topic_named
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml
from pneu_rig_ros.rig.yaml_file import parse_yaml

UNKNOWN = 'unknown'
_HEAD = '# pneu_rig_ros {version}, git revision {revision}\n'
_HEAD_PATTERN = re.compile(r'# pneu_rig_ros (?P<version>\S+), git revision (?P<revision>\S+)')

METADATA = 'metadata.yaml'

LARGEST_METADATA = 10_000_000
"""Of metadata.yaml [byte]."""

TYPE_HASH = 'topic_type_hash'
"""Key of the RIHS01 type hash in the metadata of an MCAP channel, as rosbag2 names it."""

_KEY = 'rosbag2_bagfile_information'
_CHECKSUM = '# crc32 {:08x}\n'
_WITH_CHECKSUM = re.compile(rb'(?P<text>.*\n)# crc32 (?P<crc>[0-9a-f]{8})\n', re.DOTALL)


def describe(configuration: RigConfiguration) -> str:
    """Return the text of `rig_description`: complete YAML that loads back unchanged."""
    head = _HEAD.format(version=package_version(), revision=git_revision())
    return head + configuration.to_yaml()


def bag_metadata(description: str) -> dict[str, str]:
    """Return the custom data of a bag from its `rig_description`, 'unknown' without an entry."""
    head = _HEAD_PATTERN.match(description)
    try:
        sections = parse_yaml(description, 'rig_description')
    except RigError:
        sections = None
    return {
        'configuration': description,
        'cylinder': _entry(sections, 'name'),
        'friction_model': _entry(sections, 'friction', 'model'),
        'seed': _entry(sections, 'sampling', 'seed').removesuffix(' -'),
        'package_version': head['version'] if head else UNKNOWN,
        'git_revision': head['revision'] if head else UNKNOWN,
    }


def configuration_in(custom: Mapping[str, str]) -> RigConfiguration | None:
    """Return the rig that the custom data of a bag describe, None where they do not."""
    text = custom.get('configuration')
    return configuration_from_yaml(text, 'configuration') if text else None


def _entry(sections: object, *keys: str) -> str:
    for key in keys:
        sections = sections.get(key, UNKNOWN) if isinstance(sections, dict) else UNKNOWN
    return str(sections)


@functools.cache
def package_version() -> str:
    """Return the version of the installed package, 'unknown' in a bare source tree."""
    try:
        return metadata.version('pneu_rig_ros')
    except metadata.PackageNotFoundError:
        return UNKNOWN


@functools.cache
def git_revision() -> str:
    """Return the commit of the source tree, '-modified' if it differs; 'unknown' outside git."""
    folder = Path(__file__).resolve().parents[2]

    def output(*words: str) -> str:
        command = ['git', '-C', str(folder), *words]
        run = subprocess.run(command, capture_output=True, text=True, check=True, timeout=5.0)
        return run.stdout.strip()

    try:
        if Path(output('rev-parse', '--show-toplevel')) != folder:
            return UNKNOWN
        return output('describe', '--always', '--dirty=-modified', '--exclude=*')
    except (OSError, subprocess.SubprocessError):
        return UNKNOWN


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
                'message_count': statistics.channel_message_counts.get(channel.id, 0),
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
    atomic_write(directory / METADATA, text + _CHECKSUM.format(crc32(text.encode())))


def read_metadata(directory: Path) -> dict[str, Any]:
    """
    Return the bag information in the metadata.yaml of a bag, {} without one.

    :raises RigError: when it was changed, is invalid, or needs unlimited memory
    """
    path = directory / METADATA
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
    if mode in ('file', 'message'):  # whose decompressed size nothing limits
        raise RigError(
            f'{directory}: compressed {mode} by {mode}; '
            'uncompressed or compressed chunks are read: ros2 bag convert'
        )
    return information
