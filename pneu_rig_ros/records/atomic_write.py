"""Atomic file writes."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from pneu_rig_ros.errors import RigError


def atomic_write(path: Path, content: str | Callable[[Path], object]) -> Path:
    """
    Write a file beside its place, then move it there.

    :param content: the text, or a function that writes the file; what UTF-8 cannot encode, as in
        a file name of bytes, is escaped
    :raises RigError: when it cannot be written; an existing file is then unchanged
    """
    unfinished = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        if callable(content):
            content(unfinished)
        else:
            unfinished.write_text(content, encoding='utf-8', errors='backslashreplace')
        unfinished.replace(path)
    except OSError as error:
        raise RigError(f'cannot write {path}: {error.strerror}') from error
    finally:
        unfinished.unlink(missing_ok=True)
    return path
