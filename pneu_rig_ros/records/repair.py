"""
Makes a valid bag from one whose recorder was killed.

Such a file lacks its last chunk, index and metadata, and may end within a record. What can be
read of it is written into a new bag beside the old one, read back, and only then moved to its
place; the cut file stays beside it under another name. Chunks that do not fit their checksums are
skipped. The custom data of a metadata.yaml that is intact are kept.
"""

import contextlib
import os
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from mcap.summary import Summary

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.atomic_write import writing
from pneu_rig_ros.records.bag import (
    NOTHING_TO_RECOVER,
    bag_directory,
    custom_data,
    open_bag,
    storage_files,
)
from pneu_rig_ros.records.cdr_decoding import unpack_string
from pneu_rig_ros.records.description import METADATA, TYPE_HASH, bag_metadata, read_metadata
from pneu_rig_ros.records.mcap_file import chunk_messages, scan_records
from pneu_rig_ros.records.writer import BagWriter, Definition

CUT_SUFFIX = '.cut'
"""Appended to the name of the file that was repaired."""

DESCRIPTION = '/rig_description'
"""End of the topic with the configuration."""


@dataclass(frozen=True)
class RepairReport:
    """
    Result of a repair.

    :param repaired: False if the bag was healthy and nothing was changed
    :param messages: messages in the bag now
    :param duration: from the first to the last of them [s]
    :param configuration_found: whether the rig's configuration could be recovered
    :param cut_file: where the old file is kept, None if nothing was changed
    :param damaged_chunks: chunks skipped, as they do not fit their checksums
    :param configuration_lost: whether it was not recovered because it was in one of these
    """

    path: Path
    repaired: bool
    messages: int
    duration: float
    configuration_found: bool
    cut_file: Path | None
    damaged_chunks: int = 0
    configuration_lost: bool = False


def repair(path: Path | str) -> RepairReport:
    """
    Repair a bag in place; a healthy one is left alone.

    :param path: the bag's directory, or a file in it
    :raises RigError: when there is no bag or nothing in it can be read
    """
    directory = bag_directory(path)
    file, *others = storage_files(directory)
    if others:
        names = ', '.join(each.name for each in (file, *others))
        raise RigError(
            f'{directory} holds several .mcap files ({names}); repair handles bags of one file'
        )
    try:
        return _healthy(directory)
    except RigError:
        return _rewrite(directory, file)


def _healthy(directory: Path) -> RepairReport:
    """Read every message; RigError without metadata, or if index and content do not agree."""
    if not (directory / METADATA).exists():
        raise RigError(f'{directory} has no metadata.yaml')
    with open_bag(directory) as reader:
        count = sum(1 for _ in reader.messages())
        if count != reader.message_count:
            raise RigError(f'{directory}: index says {reader.message_count}, found {count}')
        metadata = custom_data(reader, reader.information)
        duration = (reader.end_time - reader.start_time) * 1e-9
    return RepairReport(directory, False, count, duration, 'configuration' in metadata, None)


def _rewrite(directory: Path, file: Path) -> RepairReport:
    """Write what can be read beside the bag, check it, and put it into its place."""
    folder = directory.parent / f'.{directory.name}.repair'
    shutil.rmtree(folder, ignore_errors=True)
    with writing(f'beside the bag, {folder}'):
        folder.mkdir()
    try:
        new = folder / file.stem
        damaged = _copy_messages(file, new, _custom_data(directory))
        report = _healthy(new)
        if report.messages == 0:
            raise RigError(f'{directory} {NOTHING_TO_RECOVER}')
        cut_file = _swap(new, directory, file)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    was_there = any(topic.endswith(DESCRIPTION) for topics in damaged for topic in topics)
    return replace(
        report,
        path=directory,
        repaired=True,
        cut_file=cut_file,
        damaged_chunks=len(damaged),
        configuration_lost=was_there and not report.configuration_found,
    )


def _custom_data(directory: Path) -> dict[str, str]:
    """Return the custom data of the old metadata.yaml, none where it is missing or damaged."""
    try:
        information = read_metadata(directory)
        information['version']  # the last key that is written: a file cut off lacks it
        return {str(key): str(value) for key, value in information['custom_data'].items()}
    except (RigError, OSError, LookupError, AttributeError):
        return {}


def _copy_messages(file: Path, new: Path, kept: dict[str, str]) -> list[set[str]]:
    """
    Write all that can be read of a file into a new bag; return the topics in each damaged chunk.

    :param kept: custom data of the old bag, which take precedence over the messages
    """
    metadata: dict[str, str] = {}
    summary, damaged = Summary(), []
    with file.open('rb') as stream, BagWriter(new) as writer:
        with contextlib.suppress(Exception):  # up to the first invalid record
            scan_records(stream, summary)
        for chunk in summary.chunk_indexes:
            try:
                messages = chunk_messages(stream, chunk, summary)
            except Exception:  # parsers fail in any way on damaged data
                damaged.append(chunk.message_index_offsets.keys())
                continue
            for log_time, number, message in messages:
                if number not in summary.channels:
                    continue  # declared in a damaged chunk
                channel = summary.channels[number]
                schema = summary.schemas[channel.schema_id]
                type_hash = channel.metadata.get(TYPE_HASH, '')
                definition = Definition(schema.data, schema.encoding, type_hash)
                writer.add_topic(channel.topic, schema.name, definition)
                writer.write(channel.topic, schema.name, log_time, message)
                if channel.topic.endswith(DESCRIPTION):
                    with contextlib.suppress(RigError):  # not readable before the damage either
                        metadata = bag_metadata(unpack_string(message))
        writer.close(metadata | kept)
    channels = summary.channels
    return [{channels[n].topic for n in numbers & channels.keys()} for numbers in damaged]


def _swap(new: Path, directory: Path, file: Path) -> Path:
    """
    Put the new bag's files in the place of the old ones; return where the cut file went.

    The cut file gets a second name before its first name is taken over, and each step leaves
    either the cut or the whole file under the bag's name, so that repair can be run again.
    """
    (fresh,) = storage_files(new)
    for part in (fresh, new / METADATA):
        with part.open('rb') as written:
            os.fsync(written.fileno())
    numbers = ('', *range(2, 10_000))
    names = (Path(f'{file}{CUT_SUFFIX}{number}') for number in numbers)
    cut_file = next(name for name in names if not name.exists())
    try:
        os.link(file, cut_file)
    except OSError:  # a file system without links
        shutil.copy2(file, cut_file)
    fresh.replace(file)
    (new / METADATA).replace(directory / METADATA)
    return cut_file
