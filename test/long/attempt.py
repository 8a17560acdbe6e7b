"""One input on one reader, within the limits that must hold: time, memory, one clear line."""

from __future__ import annotations

import contextlib
import resource
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from hypothesis import strategies as st

from pneu_rig_ros.errors import LONGEST_LINE, RigError

from . import damage
from .readers import READERS

LONGEST = 5.0
"""No input may take longer [s]: of processor time, as the machine may be busy with others."""
LARGEST = 2**30
"""Nor more memory [byte]."""


class TooLongError(BaseException):
    """An input took longer than it may; no reader may mistake this for bad input."""


@dataclass
class Tally:
    """How many inputs were read, how many refused, and the longest attempt [s]."""

    read: int = 0
    refused: int = 0
    slowest: float = 0.0


def inputs(name: str) -> damage.Inputs:
    """Return a strategy for damaged inputs of a reader."""
    reader = READERS[name]
    seeds = reader.seeds()
    if name == 'cut bag':
        return damage.cut(seeds)
    edited = damage.edited(seeds, reader.tokens)
    if name in ('bag', 'foreign bag'):
        bad_bags = damage.cut(seeds), damage.flipped(seeds), damage.swollen(seeds)
        return st.one_of(edited, *bad_bags, damage.bombs())
    if name in ('sealed bag', 'metadata'):
        return st.one_of(edited, damage.cut(seeds), damage.flipped(seeds))
    return edited


def attempt(name: str, data: bytes, scratch: Path, tally: Tally) -> None:
    """
    Try an input on a reader; any error but a RigError of one line is passed on.

    :param scratch: a folder for what the reader wants as files
    """
    started = time.process_time()
    try:
        with _time_limit():
            READERS[name].read(data, scratch)
        tally.read += 1
    except RigError as error:
        if not is_one_line(str(error)):
            raise AssertionError(f'not a clear line: {str(error)[:200]!r}') from error
        tally.refused += 1
    except TooLongError:
        raise AssertionError(f'it takes more than {LONGEST:g} s') from None
    tally.slowest = max(tally.slowest, time.process_time() - started)


def is_one_line(text: str) -> bool:
    """Return whether an error message is one printable line that is not too long."""
    return bool(text) and text.isprintable() and len(text) <= LONGEST_LINE + 5


def limit_memory() -> None:
    """Let this process have no more than LARGEST beside what it has now."""
    pages = int(Path('/proc/self/statm').read_text().split()[0])
    size = pages * resource.getpagesize() + LARGEST
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


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
