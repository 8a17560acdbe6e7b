"""Where faults happen, and what came of them."""

from __future__ import annotations

import contextlib
import functools
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.bag import open_bag
from reliability.live_rig import ProcessRig
from reliability.witness import Witness


class Stage:
    """
    A live rig and a witness, started when the first fault asks for them; a context manager.

    Its bag is read while it is recorded.
    """

    def __init__(self) -> None:
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> Stage:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.clear()

    def clear(self) -> None:
        """Stop the rig, if there is one, so that others can take its place."""
        self._stack.close()
        for name in ('folder', 'rig', 'witness'):
            self.__dict__.pop(name, None)

    @functools.cached_property
    def folder(self) -> Path:
        """Folder of its bags."""
        folder = tempfile.TemporaryDirectory(prefix='pneu_rig_stage_')
        return Path(self._stack.enter_context(folder))

    @functools.cached_property
    def rig(self) -> ProcessRig:
        """The rig."""
        return self._stack.enter_context(ProcessRig(self.folder / 'bag'))

    @functools.cached_property
    def witness(self) -> Witness:
        """Its witness, who has seen it at work."""
        self.rig.check()
        witness = self._stack.enter_context(Witness())
        witness.hears('friction')
        witness.listen(1.0)
        return witness

    def recorded(self, until_ns: int) -> Path:
        """Listen until its bag holds what came up to a time [ns since 1970]; return the bag."""
        bag = self.newest_bag()

        def there() -> bool:
            try:
                with open_bag(bag) as reader:
                    return int(reader.end_time) > until_ns
            except RigError:  # a busy machine may stop the recorder within a piece for seconds
                return False

        self.witness.until(there, f'{bag} is written')
        return bag

    def newest_bag(self) -> Path:
        """Return the bag that is being recorded."""
        assert self.witness.received
        return max(self.folder.glob('bag*'), key=lambda bag: int(bag.name[4:] or 1))


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
    :param stage: a rig that several faults share
    :param times: how often faults are repeated that strike at random moments
    :param step: to be called after each repetition
    """

    folder: Path
    stage: Stage
    times: int = 1
    step: Callable[[], None] = lambda: None


Fault = Callable[[Scene], Finding]
