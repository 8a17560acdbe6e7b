"""Four node processes with a bag, to be loaded, stopped and killed."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType

from pneu_rig_ros.demo import NodeProcess, Value
from pneu_rig_ros.errors import RigError

ORDER = ('plant', 'valve_command', 'friction_estimator', 'recorder')
"""Sources first, which is the order in which they stop."""

FIRST_SAMPLES: dict[str, dict[str, Value]] = {
    'plant': {'wait_for_subscribers': 1},
    'valve_command': {'wait_for_subscribers': 2},
    'friction_estimator': {'wait_for_subscribers': 1},
}
"""So that the bag begins with sample 0."""

PATIENCE = 60.0


class ProcessRig:
    """
    The rig in four processes; a context manager.

    :param bag: directory to record to
    :param parameters: of the nodes by name, besides those that hold back the first sample
    :param environment: of the nodes by name, besides that of this process
    :param only: which nodes are started at first
    """

    def __init__(
        self,
        bag: Path,
        parameters: Mapping[str, Mapping[str, Value]] | None = None,
        environment: Mapping[str, Mapping[str, str]] | None = None,
        only: Sequence[str] = ORDER,
    ) -> None:
        self.bag = bag
        self._parameters = parameters or {}
        self._environment = environment or {}
        self._only = only
        self._logs = tempfile.TemporaryDirectory(prefix='pneu_rig_')
        self.nodes: dict[str, NodeProcess] = {}

    def start(self, name: str) -> NodeProcess:
        """Start one node, anew if it ran before."""
        given = {**FIRST_SAMPLES.get(name, {}), **self._parameters.get(name, {})}
        if name == 'recorder':
            given = {'output': str(self.bag), **given}
        log = Path(self._logs.name, f'{name}.log')
        self.nodes[name] = NodeProcess(name, given, log, environment=self._environment.get(name))
        return self.nodes[name]

    def log(self, name: str) -> str:
        """Return what a node has written since it was started."""
        return Path(self._logs.name, f'{name}.log').read_text(errors='replace')

    def errors(self, name: str) -> list[str]:
        """Return the error lines that a node has written."""
        return [line for line in self.log(name).splitlines() if line.startswith('Error: ')]

    def newest_bag(self) -> Path:
        """Return the bag that is being recorded: each recorder begins one beside the last."""
        return max(self.bag.parent.glob('bag*'), key=lambda bag: int(bag.name[4:] or 1))

    def check(self) -> None:
        """Raise RigError if a node has ended."""
        for node in self.nodes.values():
            node.check()

    def __enter__(self) -> ProcessRig:
        for name in reversed(self._only):
            self.start(name)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for name in sorted(self.nodes, key=ORDER.index):
            self.nodes[name].stop()
        self._logs.cleanup()


def until(condition: Callable[[], object], what: str, patience: float = PATIENCE) -> None:
    """Ask again and again; RigError when it takes too long [s]."""
    deadline = time.monotonic() + patience
    while not condition():
        if time.monotonic() > deadline:
            raise RigError(f'not within {patience:g} s: {what}')
        time.sleep(0.02)
