"""A DDS domain of this test process alone: neither another run nor a demonstration is heard."""

import fcntl
import tempfile
from pathlib import Path
from typing import TextIO

DOMAINS = range(51, 101)
"""Of the tests; `pneu-rig demo` takes lower ones."""

_held: list[TextIO] = []


def own_domain() -> int:
    """Return the first domain that no other test process holds; it is held until this one ends."""
    for domain in DOMAINS:
        lock = (Path(tempfile.gettempdir()) / f'pneu_rig_ros_domain_{domain}').open('w')
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
        else:
            _held.append(lock)
            return domain
    raise RuntimeError(f'other tests hold all of the domains {DOMAINS}')
