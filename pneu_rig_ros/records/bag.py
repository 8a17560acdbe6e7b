"""Opens rosbag2 directories; errors are one line."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, cast

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr import unpack_string
from pneu_rig_ros.records.description import bag_metadata
from pneu_rig_ros.records.integrity import check_bag, check_file
from pneu_rig_ros.records.mcap_index import IndexedFile
from pneu_rig_ros.records.rosbag2_metadata import read_metadata
from pneu_rig_ros.records.topics import DERIVED

if TYPE_CHECKING:
    from rosbags.interfaces.typing import RPath

ATTEMPTS = 8
PAUSE = 0.01
"""
After the first attempt to open a bag that is being recorded [s], then twice as long each time:
appending takes less, unless the recorder has to wait for a processor.
"""


def bag_directory(path: Path | str) -> Path:
    """Return the directory of a bag from its path or that of a file in it; RigError if none."""
    path = Path(path)
    if not path.exists():
        raise RigError(f'{path} does not exist; give the directory of a bag, e.g. under runs/')
    if path.is_file() and path.suffix != '.mcap' and path.name != 'metadata.yaml':
        raise RigError(
            f'{path} is not a bag; pass the bag directory, or turn it into one: pneu-rig import'
        )
    directory = path.parent if path.is_file() else path
    if not storage_files(directory):
        raise RigError(f'{directory} holds no .mcap file; give the directory of a bag')
    return directory


def storage_files(directory: Path) -> list[Path]:
    """Return the MCAP files in a directory, sorted by name."""
    return sorted(directory.glob('*.mcap'))


@contextlib.contextmanager
def open_bag(path: Path | str) -> Iterator[Reader]:
    """
    Open a bag for reading, also one that is still being recorded.

    :raises RigError: when it is not a bag, or is cut off or damaged
    """
    directory = bag_directory(path)
    try:
        with _opened(directory) as reader:
            yield reader
    except RigError:
        raise
    except Exception as error:
        # rosbags, decompressors and parsers raise any exception on damaged data.
        raise RigError(
            f'{directory} is cut off or damaged ({first_line(error)}); '
            f'run: pneu-rig repair {directory}'
        ) from error


@contextlib.contextmanager
def _opened(directory: Path) -> Iterator[Reader]:
    """Open a bag by its metadata, or by its only file when these are not written yet."""
    files = storage_files(directory)
    if (directory / 'metadata.yaml').exists() or len(files) > 1:
        check_bag(directory)
        with Reader(directory) as reader:
            yield reader
        return
    with contextlib.closing(_growing(files[0])) as reader:
        yield reader


def _growing(file: Path) -> Reader:
    """Open a file without metadata; again where it was read while the recorder appended."""
    for attempt in range(ATTEMPTS - 1):
        with contextlib.suppress(Exception):  # readers fail in any way on half a chunk
            return _without_metadata(file)
        time.sleep(PAUSE * 2.0**attempt)
    return _without_metadata(file)


def _without_metadata(file: Path) -> Reader:
    check_file(file)
    reader = Reader(cast('RPath', IndexedFile(file)))
    reader.open()
    return reader


def custom_data(reader: Reader | AnyReader, directory: Path) -> dict[str, str]:
    """
    Return the custom data of an open bag, see `pneu_rig_ros.records.description`.

    A bag of `ros2 bag record`, or one that is being recorded, has none: they follow from a topic.
    """
    kept = read_metadata(directory).get('custom_data')
    if kept:
        return {str(key): str(value) for key, value in kept.items()}
    text = last_text(reader, 'rig_description')
    return bag_metadata(text) if text else {}


def last_text(reader: Reader | AnyReader, topic: str) -> str:
    """Return the last text on a topic in any namespace, empty if there was none."""
    connections = [
        c
        for c in reader.connections
        if c.topic.endswith(f'/{topic}') and c.msgtype == 'std_msgs/msg/String'
    ]
    if not connections:
        return ''
    texts = [unpack_string(bytes(cdr)) for _, _, cdr in reader.messages(connections)]
    return texts[-1] if texts else ''


def first_line(error: BaseException) -> str:
    """Return the first line of an error message, without its full stop."""
    text = str(error).strip() or type(error).__name__
    return text.splitlines()[0].rstrip('.')


def find_namespace(connections: list[Connection]) -> str:
    """Return what precedes '/joint_states' in the bag's topics: '' or '/rig_a' ..."""
    end = '/joint_states'
    derived = tuple(f'/{prefix.rstrip("/")}{end}' for prefix in DERIVED)
    topics = [c.topic for c in connections if not c.topic.endswith(derived)]
    found = sorted({topic.removesuffix(end) for topic in topics if topic.endswith(end)})
    if not found:
        raise RigError('the bag has no topic joint_states: nothing of a rig was recorded')
    if len(found) > 1:
        raise RigError(f'the bag holds several rigs, {", ".join(found)}; record them one by one')
    return found[0]
