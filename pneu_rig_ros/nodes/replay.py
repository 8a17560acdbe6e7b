"""The replay node: the recorded topics of a bag again, so that nodes are driven by them."""

import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import parameters, runner
from pneu_rig_ros.nodes.pacing import Pace
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.records.cdr import NANOSECONDS
from pneu_rig_ros.records.playback import Message, Playback
from pneu_rig_ros.records.topics import CLOCK

LONGEST_PAUSE_NS = 20_000_000
"""Longest sleep between two turns, so that services are served [ns]."""

MOST_AT_ONCE = 500
"""Messages published in one turn at most; readers in the same loop keep up."""

SAMPLES = 'joint_states'


class ReplayNode(RigNode):
    """
    Publishes the messages of a bag unchanged, at the pace in which they were logged.

    What other nodes compute (friction, predictions, diagnostics) is left to them unless asked
    for. A late message does not move those after it. The process ends with the bag.
    """

    PARAMETERS = (
        Parameter('bag', '', 'directory of the bag to play'),
        Parameter('rate', 1.0, 'played over recorded time', '-', 0.01, 100.0),
        Parameter('repeat', False, 'whether the bag is played again and again'),
        Parameter('clock', False, 'whether /clock is published, from the log times'),
        Parameter('topics', '', 'topics to play, comma-separated; empty: all not computed'),
        Parameter('exclude', '', 'topics to leave out, comma-separated'),
        Parameter('delay', 1.0, 'time to find subscribers before the start', 's', 0.0, 3600.0),
        Parameter('paused', False, 'whether to start paused, until ~/pause says otherwise'),
    )

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('replay', context, overrides)
        if not self.text('bag'):
            raise RigError('replay: bag is empty, give the directory of a bag')
        playback = Playback(self.text('bag'), self._names('topics'), self._names('exclude'))
        self._playback = playback.__enter__()
        self._publish = {t: self.outlet(t).publish for t in self._playback.topics}
        self._ticks = self.outlet(CLOCK) if parameters.switch(self, 'clock') else None
        self._repeat = parameters.switch(self, 'repeat')
        self._rate = self.number('rate')
        self._paused = parameters.switch(self, 'paused')
        self._published = Rate()
        self.create_service(SetBool, '~/pause', self._on_pause)
        self._messages: Iterator[Message] = iter(())
        self._next: Message | None = None
        self._started = False
        self._origin_ns = time.monotonic_ns() + round(self.number('delay') * NANOSECONDS)

    def _names(self, parameter: str) -> list[str]:
        return [name.strip() for name in self.text(parameter).split(',') if name.strip()]

    @property
    def elapsed(self) -> float:
        """How much of the bag has been played [s]."""
        if self._next is None:
            return self.duration if self._started else 0.0
        return (self._next.time_ns - self._playback.start_ns) * 1e-9

    @property
    def duration(self) -> float:
        """Length of the bag [s]."""
        return self._playback.duration

    @property
    def published(self) -> int:
        """Messages published so far."""
        return self._published.count

    def pace(self) -> Pace:
        """Return what sleeps until the next message is due."""
        return self

    def wait(self) -> None:
        """Sleep until the next message is due, though not for long."""
        due = self._due_ns(self._next) if self._next and not self._paused else self._origin_ns
        pause = due - time.monotonic_ns()
        if pause > 0 or self._paused or not self._started:
            time.sleep(min(max(pause, 1_000_000), LONGEST_PAUSE_NS) * 1e-9)

    def _due_ns(self, message: Message) -> int:
        """Return when a message is due on the monotonic clock [ns]."""
        since_start = message.time_ns - self._playback.start_ns
        return self._origin_ns + round(since_start / self._rate)

    def work(self) -> None:
        """Publish what is due."""
        now = time.monotonic_ns()
        if self._paused or self.done or now < self._origin_ns or not self.ready():
            return
        if not self._started:
            self._begin(now)
        for _ in range(MOST_AT_ONCE):
            if self._next is None or self._due_ns(self._next) > now:
                break
            self._send(self._next)
            self._next = next(self._messages, None)
        if self._next is None:
            self._end()

    def _begin(self, now: int) -> None:
        self._origin_ns = now
        self._messages = self._playback.messages()
        self._next = next(self._messages, None)
        self._started = True

    def _end(self) -> None:
        if self._repeat:
            self._started = False
        else:
            self.done = True

    def _send(self, message: Message) -> None:
        if self._ticks and message.topic == SAMPLES:
            now = Clock()
            now.clock.sec, now.clock.nanosec = divmod(message.time_ns, NANOSECONDS)
            self._ticks.publish(now)
        self._publish[message.topic](message.cdr)
        self._published.count += 1

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if self._paused and not request.data and self._next is not None:
            # go on from here: the next message is due now
            self._origin_ns += time.monotonic_ns() - self._due_ns(self._next)
        self._paused = request.data
        response.success = True
        response.message = 'paused' if self._paused else 'running'
        return response

    def close(self) -> None:
        """Close the bag."""
        self._playback.__exit__(None, None, None)

    def report(self) -> Report:
        """Return progress and rate for `/diagnostics`."""
        values: dict[str, object] = {
            'rate [Hz]': f'{self._published.per_second():.2f}',
            'published': self._published.count,
            'elapsed [s]': f'{self.elapsed:.2f}',
            'duration [s]': f'{self.duration:.2f}',
            'topics': ', '.join(self._playback.topics),
        }
        states = {'finished': self.done, 'paused': self._paused, 'waiting': not self._started}
        summary = next((name for name, so in states.items() if so), 'running')
        return Report(DiagnosticStatus.OK, summary, values)


class Player:
    """
    A replay in this process.

    :param node: what plays
    :param loop: around it
    """

    def __init__(self, node: ReplayNode, loop: Runner) -> None:
        self._node = node
        self._loop = loop

    @property
    def duration(self) -> float:
        """Length of the bag [s]."""
        return self._node.duration

    @property
    def elapsed(self) -> float:
        """How much of the bag has been played [s]."""
        return self._node.elapsed

    @property
    def published(self) -> int:
        """Messages published so far."""
        return self._node.published

    def run(self, progress: Callable[[float], None]) -> None:
        """Play to the end; `progress` is told the time since the start of the bag [s]."""

        def wanted() -> bool:
            progress(self._node.elapsed)
            return not self._node.done

        self._loop.run(wanted)


@contextmanager
def play(parameters_given: Mapping[str, Any], namespace: str = '') -> Iterator[Player]:
    """
    Play a bag from a program; what runs in the block may be interrupted.

    :param parameters_given: of the node
    :param namespace: of the topics
    :raises RigError: for a wrong parameter, or what is no complete bag
    """
    if not re.fullmatch(r'(/?[A-Za-z_]\w*)*', namespace):
        raise RigError(f'namespace {namespace!r}: allowed are names such as left or lab/left')
    context = Context()
    remap = ['--ros-args', '-r', f'__ns:=/{namespace.strip("/")}'] if namespace else []
    rclpy.init(args=remap, context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = ReplayNode(context, parameters_given)
        loop = Runner([node])
        try:
            yield Player(node, loop)
        finally:
            loop.close()
    finally:
        context.try_shutdown()


def main() -> int:
    """Run the node to the end of the bag or until Ctrl-C; return the exit code."""
    return runner.main([ReplayNode])


if __name__ == '__main__':
    raise SystemExit(main())
