"""One input tried on one reader, under the limits that must hold: time, memory, one clear line."""

from __future__ import annotations

import contextlib
import hashlib
import resource
import signal
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from pneu_rig_ros.errors import LONGEST_LINE, RigError
from reliability.fuzz.readers import READERS

LONGEST = 5.0
"""No input may take longer [s]: of processor time, as the machine may be busy with others."""
LARGEST = 2**30
"""Nor more memory [byte]."""


class TooLongError(BaseException):
    """An input took longer than it may; no reader may mistake this for bad input."""


@dataclass
class Tally:
    """
    What became of the inputs of one reader.

    :param accepted: read, and found to be what something else says they are
    :param refused: told by a RigError of one line
    :param failures: place in the code -> what happened; the input lies in the folder of failures
    :param slowest: longest attempt [s]
    """

    accepted: int = 0
    refused: int = 0
    failures: dict[str, str] = field(default_factory=dict)
    slowest: float = 0.0

    @property
    def tried(self) -> int:
        """How many inputs."""
        return self.accepted + self.refused + len(self.failures)


def attempt(name: str, data: bytes, scratch: Path, tally: Tally, kept: Path | None = None) -> None:
    """
    Try an input on a reader and enter the outcome.

    :param scratch: a folder for what the reader wants as files
    :param kept: gets the inputs that fail
    """
    started = time.process_time()
    try:
        with _time_limit():
            READERS[name].read(data, scratch)
        tally.accepted += 1
    except RigError as error:
        if problem := complaint(str(error)):
            _fail(name, data, problem, tally, kept)
        else:
            tally.refused += 1
    except (Exception, TooLongError) as error:
        _fail(name, data, _place(error), tally, kept)
    tally.slowest = max(tally.slowest, time.process_time() - started)


def complaint(line: str) -> str:
    """Return what is wrong with an error message, '' if it is one printable line."""
    if not line or not line.isprintable() or len(line) > LONGEST_LINE + 5:
        return f'no clear line: {line[:200]!r}'
    return ''


def limit_memory() -> None:
    """Let this process have no more than LARGEST beside what it has now."""
    pages = int(Path('/proc/self/statm').read_text().split()[0])
    size = pages * resource.getpagesize() + LARGEST
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


def peak_memory() -> int:
    """Return the most memory that this process had [byte]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@contextlib.contextmanager
def _time_limit() -> Iterator[None]:
    def expired(_: int, __: FrameType | None) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGPROF, expired)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _place(error: BaseException) -> str:
    """Return the error, and the last lines of the package or of a library that it comes from."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if '/pneu_rig_ros/' in frame.filename] or frames
    place = f'{Path(ours[-1].filename).name}:{ours[-1].lineno}'
    return f'{place}: {type(error).__name__}: {" ".join(str(error).split())[:200]}'


def _fail(name: str, data: bytes, problem: str, tally: Tally, kept: Path | None) -> None:
    place = problem[:60]
    if place not in tally.failures and kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
        file = kept / f'{name.replace(" ", "_")}_{hashlib.sha256(data).hexdigest()[:12]}'
        file.write_bytes(data)
        problem += f' ({file})'
    tally.failures.setdefault(place, problem)
