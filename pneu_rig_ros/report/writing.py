"""Files that appear as a whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from pneu_rig_ros.errors import RigError


def write_whole(path: Path, text: str) -> Path:
    """
    Write a text file beside its place, then put it there.

    :raises RigError: when it cannot be written
    """
    unfinished = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        unfinished.write_text(text, encoding='utf-8')
        unfinished.replace(path)
    except OSError as error:
        raise RigError(f'cannot write {path}: {error.strerror}') from error
    finally:
        unfinished.unlink(missing_ok=True)
    return path
