"""
The rig live, in four processes: started, driven, stopped in order.

The nodes hold their first message back until each of their topics has all its subscribers, so that
the bag has everything from the first sample on. At the end each node stops after those that it
listens to.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import OWNER
from pneu_rig_ros.records import repair
from pneu_rig_ros.rig import Rig, RigConfiguration

Value = str | float | int | bool

STOPPING_TIME = 20.0
"""Time after which a node that does not stop by itself is killed [s]."""

LAST_DOMAIN = 232
"""Highest ROS_DOMAIN_ID for which DDS has ports."""


class NodeProcess:
    """
    A node in a process of its own.

    :param name: module under `pneu_rig_ros.nodes`
    :param parameters: of the node
    :param log: file for its output
    :param environment: variables besides those of this process, or in their place
    """

    def __init__(
        self,
        name: str,
        parameters: Mapping[str, Value],
        log: Path,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.name = name
        self._log = log
        self._command = [sys.executable, '-m', f'pneu_rig_ros.nodes.{name}', '--ros-args']
        for key, value in parameters.items():
            # JSON is YAML, in which ROS reads parameters: names, numbers and odd paths survive.
            self._command += ['-p', f'{key}:={json.dumps(value)}']
        self._environment = {OWNER: str(os.getpid()), **(environment or {})}
        log.write_text('')
        self.process = self._start()

    def _start(self) -> subprocess.Popen[bytes]:
        with self._log.open('a') as output:
            return subprocess.Popen(
                self._command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, **self._environment},
                start_new_session=True,  # Ctrl-C stops the nodes in order, through `stop`.
            )

    def revive(self) -> bool:
        """Start the node again if it was killed; RigError if it has ended by itself."""
        code = self.process.poll()
        if code is None:
            return False
        if code >= 0:
            self.check()
        self.process = self._start()
        return True

    def check(self) -> None:
        """Raise RigError if the node has ended."""
        code = self.process.poll()
        if code is None:
            return
        if code < 0:
            reason = f'it was killed by {signal.Signals(-code).name}'
        else:
            lines = map(str.strip, self._log.read_text(errors='replace').splitlines())
            words = [line for line in lines if line] or ['no output']
            errors = [word for word in words if word.startswith('Error: ')]
            reason = (errors or words)[-1].removeprefix('Error: ') + f' (exit code {code})'
        raise RigError(f'the node {self.name} has stopped: {reason}')

    def done(self) -> bool:
        """Return whether the node has ended by itself; RigError if it has failed."""
        if self.process.poll():
            self.check()
        return self.process.returncode == 0

    def stop(self) -> bool:
        """Stop the node; return whether it ended well and by itself."""
        self.process.send_signal(signal.SIGINT)  # which does nothing once it has ended
        try:
            return self.process.wait(STOPPING_TIME) == 0
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            return False


@contextlib.contextmanager
def recorded_rig(
    bag: Path,
    configuration: RigConfiguration,
    plant: Mapping[str, Value],
    report: Callable[[str], None],
) -> Iterator[list[NodeProcess]]:
    """
    Run plant, valve command, friction estimator and recorder for the block; yield these nodes.

    :param bag: directory to record to; repaired if the recorder had to be killed
    :param configuration: of the rig
    :param plant: parameters of the plant that give this configuration
    :param report: callback(stage), in a few words
    """
    from pneu_rig_ros.nodes.embedding import PLANT_SUBSCRIBERS, await_first_sample

    Rig(configuration).warm_up()  # nodes do not wait for each other that long
    report('starting plant, valve_command, friction_estimator, recorder')
    bag, waiting = bag.resolve(), 'wait_for_subscribers'
    # publishers before those that subscribe to them: they stop in this order, too
    parameters: dict[str, Mapping[str, Value]] = {
        'plant': {**plant, waiting: PLANT_SUBSCRIBERS},
        'valve_command': {waiting: 2},
        'friction_estimator': {waiting: 1},
        'recorder': {'output': str(bag)},
    }
    nodes: list[NodeProcess] = []
    with tempfile.TemporaryDirectory(prefix='pneu_rig_') as folder:
        try:
            for name, own in parameters.items():
                nodes.append(NodeProcess(name, own, Path(folder, f'{name}.log')))
            await_first_sample(lambda: check_all(nodes))
            yield nodes
        finally:
            with held_signals():  # a second Ctrl-C must not leave nodes behind
                report('stopping')
                ended = {node.name: node.stop() for node in nodes}
                if not ended.get('recorder', True) and any(bag.glob('*.mcap')):
                    report('repairing the bag')
                    repair(bag)


def check_all(nodes: Iterable[NodeProcess]) -> None:
    """Raise RigError if a node has stopped."""
    for node in nodes:
        node.check()


def drive(
    nodes: Iterable[NodeProcess], u: float, duration: float, progress: Callable[[float], None]
) -> None:
    """
    Hold the command u [V] for a duration [s]; RigError if a node stops meanwhile.

    :param progress: callback(time since the start [s])
    """
    from pneu_rig_ros.nodes.embedding import hold_command

    def checked(elapsed: float) -> None:
        check_all(nodes)
        progress(elapsed)

    hold_command(u, duration, checked)


@contextlib.contextmanager
def restartable_rig(cylinder: str) -> Iterator[list[NodeProcess]]:
    """
    Run a rig that records nothing for the block; yield its nodes, to be revived when killed.

    :param cylinder: name of a shipped cylinder, or a YAML file
    """
    nodes: list[NodeProcess] = []
    with tempfile.TemporaryDirectory(prefix='pneu_rig_') as folder, contextlib.ExitStack() as stop:
        # The source is started last, so that it stops first.
        for name in ('friction_estimator', 'valve_command', 'plant'):
            parameters = {'cylinder': absolute(cylinder)} if name == 'plant' else {}
            nodes.append(NodeProcess(name, parameters, Path(folder, f'{name}.log')))
            stop.callback(nodes[-1].stop)
        yield nodes


def absolute(cylinder: str) -> str:
    """Return the name of a cylinder, or the full path of a file, as nodes may run elsewhere."""
    return str(Path(cylinder).resolve()) if Path(cylinder).exists() else cylinder


@contextlib.contextmanager
def held_signals() -> Iterator[list[int]]:
    """
    Let SIGINT and SIGTERM only be appended to the list that is yielded, for the block.

    KeyboardInterrupt would be lost, or become another exception, in a callback of rclpy.
    """
    received: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: received.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def prepare_environment() -> None:
    """
    Give this process and its nodes a DDS domain of their own, unless the user has chosen one.

    It must come before rclpy is imported. Discovery stays on this host; the domain follows from
    the process number, so that two demonstrations do not meet.

    :raises RigError: when the user's ROS_DOMAIN_ID is not valid
    """
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    domain = os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 50))
    if not (domain.isdecimal() and int(domain) <= LAST_DOMAIN):
        raise RigError(f'ROS_DOMAIN_ID={domain}: must be a whole number from 0 to {LAST_DOMAIN}')
