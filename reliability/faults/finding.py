"""What came of a fault."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple


class Finding(NamedTuple):
    """
    One row of the table.

    :param fault: what was done
    :param behaviour: what has to happen
    :param diagnostic: what the user is told, and where
    :param measured: what happened
    :param held: whether it was what has to happen
    """

    fault: str
    behaviour: str
    diagnostic: str
    measured: str
    held: bool


class NotPossible(Exception):
    """A fault that cannot be brought about on this computer; says in a line why."""


class Scene(NamedTuple):
    """
    Where a fault happens, and how often.

    :param folder: empty, of its own
    :param times: how often faults are repeated that strike at random moments
    :param step: to be called after each repetition
    """

    folder: Path
    times: int
    step: Callable[[], None]


Fault = Callable[[Scene], Finding]
