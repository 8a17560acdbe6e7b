"""Opens rosbag2 directories with MCAP storage, also ones that grow; errors are one line."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

from mcap.summary import Summary

from pneu_rig_ros.errors import RigError, prefixed
from pneu_rig_ros.records.cdr_decoding import unpack_string
from pneu_rig_ros.records.description import METADATA, bag_metadata, read_metadata
from pneu_rig_ros.records.mcap_file import McapFile, scan_records
from pneu_rig_ros.records.topics import DERIVED, STRING

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

ATTEMPTS = 8
PAUSE = 0.01
"""
After the first attempt to open a bag that is being recorded [s], then twice as long each time:
appending takes less, unless the recorder has to wait for a processor.
"""

NOTHING_TO_RECOVER = 'is not a bag, or was cut off before its first message: nothing to recover'


class Connection(NamedTuple):
    """A topic in a bag, with the names of `rosbags.interfaces.Connection`."""

    topic: str
    msgtype: str
    msgcount: int


class Bag:
    """An open bag: its metadata.yaml, {} while it has none, and its MCAP files, by time."""

    def __init__(
        self, directory: Path, information: dict[str, Any], files: list[McapFile]
    ) -> None:
        self.directory = directory
        self.information = information
        self.files = files
        counts = Counter[tuple[str, str]]()
        for file in files:
            counts.update(file.counts())
        self.connections = [Connection(*key, count) for key, count in counts.items()]
        filled = [file.statistics for file in files if file.statistics.message_count]
        self.message_count = sum(statistics.message_count for statistics in filled)
        self.start_time = min((s.message_start_time for s in filled), default=0)
        self.end_time = max((s.message_end_time for s in filled), default=0)

    def messages(
        self, connections: Iterable[Connection] = (), start: int = 0
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield connection, log time [ns] and bytes on some topics or all, in order of time."""
        wanted = {c.topic: c for c in tuple(connections) or self.connections}
        for file in self.files:
            channels = {
                number: wanted[channel.topic]
                for number, channel in file.summary.channels.items()
                if channel.topic in wanted
            }
            for time_ns, number, cdr in file.messages(channels, start):
                yield channels[number], time_ns, cdr

    def protected(self) -> bool:
        """Return whether every message has a checksum."""
        return bool(self.files) and all(file.protected() for file in self.files)

    def check_counts(self) -> None:
        """Raise RigError when metadata.yaml and the indexes count messages differently."""
        listed, indexed = Counter[str](), Counter[str]()
        for topic in self.information['topics_with_message_count']:
            listed[topic['topic_metadata']['name']] += topic['message_count']
        for connection in self.connections:
            indexed[connection.topic] += connection.msgcount
        for topic in listed | indexed:
            if listed[topic] != indexed[topic]:
                raise RigError(
                    f'{self.directory}: metadata.yaml says {listed[topic]} messages on {topic}, '
                    f'the index {indexed[topic]}'
                )


def folder_of(path: Path) -> Path | None:
    """Return the directory of a bag from its path or a file in it; None for table, ROS 1 bag."""
    if path.is_dir():
        return path
    return path.parent if path.suffix in ('.mcap', '.db3') or path.name == METADATA else None


def bag_directory(path: Path | str) -> Path:
    """Return the directory of a bag from its path or that of a file in it; RigError if none."""
    path = Path(path)
    if not path.exists():
        raise RigError(f'{path} does not exist; give the directory of a bag, e.g. under runs/')
    directory = folder_of(path)
    if directory is None:
        raise RigError(
            f'{path} is not a bag; pass the bag directory, or turn it into one: pneu-rig import'
        )
    if not storage_files(directory):
        raise RigError(f'{directory} holds no .mcap file; give the directory of a bag')
    return directory


def storage_files(directory: Path) -> list[Path]:
    """Return the MCAP files in a directory, sorted by name."""
    return sorted(directory.glob('*.mcap'))


@contextlib.contextmanager
def open_bag(path: Path | str) -> Iterator[Bag]:
    """
    Open a bag for reading: the files that metadata.yaml names, or the one that is being recorded.

    :raises RigError: when it is not a bag, or is cut off or damaged
    """
    directory = bag_directory(path)
    with reading(directory), contextlib.ExitStack() as stack:
        information, files = read_metadata(directory), storage_files(directory)
        if information:
            files = [directory / Path(name).name for name in information['relative_file_paths']]
            if lost := [file.name for file in files if not file.exists()]:
                raise RigError(f'{directory}: files that metadata.yaml names are missing: {lost}')
        elif len(files) > 1:
            raise RigError(f'{directory} has {len(files)} .mcap files, but no metadata.yaml')
        opened = []
        for file in files:
            stream = stack.enter_context(file.open('rb'))
            with prefixed(file):
                opened.append(McapFile(stream) if information else _growing(stream))
        bag = Bag(directory, information, opened)
        if information:
            bag.check_counts()
        yield bag


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Make a RigError of whatever parsers and decompressors raise on damaged data."""
    try:
        yield
    except RigError:
        raise
    except Exception as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: Exception) -> RigError:
    """Return the error for a bag that cannot be read; it names `repair` where that would help."""
    reason = (str(error).strip() or type(error).__name__).splitlines()[0].rstrip('.')
    directory = folder_of(path) or path
    files = storage_files(directory)
    if not files:
        return RigError(f'{path}: cannot be read as a bag: {reason}')
    summary = Summary()
    for file in files:
        with contextlib.suppress(Exception), file.open('rb') as stream:  # up to a wrong record
            scan_records(stream, summary)
    if not summary.chunk_indexes:
        return RigError(f'{directory} {NOTHING_TO_RECOVER}')
    advice = f'({reason}); run: pneu-rig repair {directory}'
    return RigError(f'{directory} is cut off or damaged {advice}')


def _growing(stream: BinaryIO) -> McapFile:
    """Open a file without metadata; again where it was read while the recorder appended."""
    for attempt in range(ATTEMPTS - 1):
        with contextlib.suppress(Exception):  # readers fail in any way on half a chunk
            return McapFile(stream)
        time.sleep(PAUSE * 2.0**attempt)
    return McapFile(stream)


def check_bag(directory: Path) -> bool:
    """
    Check all of a bag that another reader takes as it is; return whether it has checksums.

    :raises RigError: for what was changed, contradicts itself, or would need too much memory
    """
    if not storage_files(directory):
        read_metadata(directory)
        return False  # of another storage
    with open_bag(directory) as bag:
        for file in bag.files:
            file.check_decompression()
        return bag.protected()


def custom_data(bag: Bag | AnyReader, information: Mapping[str, Any]) -> dict[str, str]:
    """
    Return the custom data of an open bag with this metadata.yaml, see `records.description`.

    A bag of `ros2 bag record`, or one that is being recorded, has none: they follow from a topic.
    """
    kept = information.get('custom_data')
    if kept:
        return {str(key): str(value) for key, value in kept.items()}
    text = last_text(bag, 'rig_description')
    return bag_metadata(text) if text else {}


def last_text(bag: Bag | AnyReader, topic: str) -> str:
    """Return the last text on a topic in any namespace, empty if there was none."""
    wanted: list[Any] = [
        c for c in bag.connections if c.topic.endswith(f'/{topic}') and c.msgtype == STRING
    ]
    text = ''
    for _, _, cdr in bag.messages(wanted) if wanted else ():
        text = unpack_string(bytes(cdr))
    return text


def find_namespace(topics: Iterable[str]) -> str:
    """Return what precedes '/joint_states' in the bag's topics: '' or '/rig_a' ..."""
    end = '/joint_states'
    derived = tuple(f'/{prefix.rstrip("/")}{end}' for prefix in DERIVED)
    namespaces = sorted(
        {t.removesuffix(end) for t in topics if t.endswith(end) and not t.endswith(derived)}
    )
    if not namespaces:
        raise RigError('the bag has no topic joint_states: nothing of a rig was recorded')
    if len(namespaces) > 1:
        names = ', '.join(namespaces)
        raise RigError(f'the bag holds several rigs, {names}; record them one by one')
    return namespaces[0]
