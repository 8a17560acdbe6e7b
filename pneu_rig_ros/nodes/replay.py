"""The replay node: plays back the topics of a bag, also faster or slower than recorded."""

import time
from collections.abc import Iterator
from functools import partial

from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.rig_node import Parameter, RigNode
from pneu_rig_ros.nodes.timing import LoopTimer
from pneu_rig_ros.records.cdr_encoding import NANOSECONDS
from pneu_rig_ros.records.playback import Message, Playback
from pneu_rig_ros.records.topics import CLOCK

LONGEST_PAUSE_NS = 20_000_000
"""Longest sleep between two updates, so that services are served [ns]."""

BATCH_SIZE = 500
"""Most messages published in one update, so that other nodes of the loop are updated too."""

SAMPLES = 'joint_states'


class ReplayNode(RigNode):
    """
    Publishes the messages of a bag unchanged, at the recorded intervals divided by `rate`.

    Topics that other nodes compute (friction, predictions, diagnostics) are played only if listed
    in `topics`. A late message does not delay those after it. The process ends with the bag.
    """

    NAME = 'replay'
    PARAMETERS = (
        Parameter('bag', '', 'bag directory', constraint='must be given'),
        Parameter('rate', 1.0, 'playback rate: recorded over playback time', '-', 0.01, 100.0),
        Parameter('repeat', False, 'whether the bag is played in a loop'),
        Parameter('clock', False, 'whether /clock is published, from the log times'),
        Parameter('topics', '', 'topics to play, comma-separated; empty: all not computed'),
        Parameter('exclude', '', 'topics to exclude, comma-separated'),
        Parameter('delay', 1.0, 'time for discovery before the start', 's', 0.0, 3600.0),
        Parameter('paused', False, 'whether to start paused; ~/pause changes it'),
    )

    def set_up(self) -> None:
        """Open the bag; create publishers and the service."""
        if not self.text('bag'):
            raise RigError('replay: bag is empty; pass the bag directory')
        topics, exclude = self._names('topics'), self._names('exclude')
        self._playback = Playback(self.text('bag'), topics, exclude)
        self.duration = self._playback.duration
        """Length of the bag [s]."""
        self._publish = {t: self.add_publisher(t).publish for t in self._playback.topics}
        self._clock_publisher = self.add_publisher(CLOCK) if self.flag('clock') else None
        self._repeat = self.flag('repeat')
        self._rate = self.number('rate')
        self._paused = self.flag('paused')
        self.create_service(SetBool, '~/pause', self._on_pause)
        self._messages: Iterator[Message] = iter(())
        self._next: Message | None = None
        self._started = False
        self._origin_ns = time.monotonic_ns() + round(self.number('delay') * NANOSECONDS)

    def _names(self, parameter: str) -> list[str]:
        return [name.strip() for name in self.text(parameter).split(',') if name.strip()]

    @property
    def elapsed(self) -> float:
        """Time since the start of the bag [s]."""
        if self._next is None:
            return self.duration if self._started else 0.0
        return (self._next.time_ns - self._playback.start_ns) * 1e-9

    def loop_timer(self) -> LoopTimer:
        """Return itself: it sleeps until the next message is due."""
        return self

    def wait(self) -> None:
        """Sleep until the next message is due, at most LONGEST_PAUSE_NS."""
        due = self._due_ns(self._next) if self._next and not self._paused else self._origin_ns
        pause = due - time.monotonic_ns()
        if pause > 0 or self._paused or not self._started:
            time.sleep(min(max(pause, 1_000_000), LONGEST_PAUSE_NS) * 1e-9)

    def _due_ns(self, message: Message) -> int:
        """Return when a message is due on the monotonic clock [ns]."""
        since_start = message.time_ns - self._playback.start_ns
        return self._origin_ns + round(since_start / self._rate)

    def update(self) -> None:
        """Publish the messages that are due."""
        now = time.monotonic_ns()
        if self._paused or self.done or now < self._origin_ns or not self.ready():
            return
        if not self._started:
            self._started = True
            self._origin_ns = now
            self._messages = self._playback.messages()
            self._next = next(self._messages, None)
        for _ in range(BATCH_SIZE):
            if self._next is None or self._due_ns(self._next) > now:
                break
            self._send(self._next)
            self._next = next(self._messages, None)
        if self._next is None:
            self._started, self.done = not self._repeat, not self._repeat

    def _send(self, message: Message) -> None:
        if self._clock_publisher and message.topic == SAMPLES:
            now = Time(nanoseconds=message.time_ns).to_msg()
            self._clock_publisher.publish(Clock(clock=now))
        self._publish[message.topic](message.cdr)
        self.rate.count += 1

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if self._paused and not request.data and self._next is not None:
            # Continue here: the next message is due now.
            self._origin_ns += time.monotonic_ns() - self._due_ns(self._next)
        self._paused = request.data
        response.success = True
        response.message = 'paused' if self._paused else 'running'
        return response

    def close(self) -> None:
        """Close the bag."""
        self._playback.close()

    def status(self) -> NodeStatus:
        """Return progress for `/diagnostics`."""
        values: dict[str, object] = {
            'published': self.rate.count,
            'elapsed [s]': f'{self.elapsed:.2f}',
            'duration [s]': f'{self.duration:.2f}',
            'topics': ', '.join(self._playback.topics),
        }
        states = {'finished': self.done, 'paused': self._paused, 'waiting': not self._started}
        state = next((name for name, active in states.items() if active), 'running')
        return NodeStatus(state, values)


main = partial(runner.main, [ReplayNode])

if __name__ == '__main__':
    raise SystemExit(main())
