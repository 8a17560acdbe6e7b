"""Atomic file writes: a file is replaced in one step, or stays as it was."""

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path

from pneu_rig_ros.errors import RigError


@contextlib.contextmanager
def writing(what: object) -> Iterator[None]:
    """Make a RigError of an OSError while something is written, such as 'the bag runs/stroke'."""
    try:
        yield
    except OSError as error:
        raise RigError(f'cannot write {what}: {error.strerror or error}') from error


def atomic_write(path: Path, content: str | Callable[[Path], object]) -> Path:
    """
    Write a file beside its place, then move it there.

    :param content: the text, or a function that writes the file; what UTF-8 cannot encode, as in
        a file name of bytes, is escaped
    :raises RigError: when it cannot be written; an existing file is then unchanged
    """
    unfinished = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        with writing(path):
            if callable(content):
                content(unfinished)
            else:
                unfinished.write_text(content, encoding='utf-8', errors='backslashreplace')
            unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
    return path
