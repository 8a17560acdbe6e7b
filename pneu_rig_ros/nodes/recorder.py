"""The recorder node: writes every message on the topics of the rig to a bag."""

import contextlib
import itertools
import shutil
from datetime import datetime
from functools import partial
from pathlib import Path

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.managed_node import ManagedNode
from pneu_rig_ros.nodes.rig_node import Parameter
from pneu_rig_ros.nodes.samples import SimulatedTime
from pneu_rig_ros.nodes.timing import WallClock
from pneu_rig_ros.nodes.topics import SHARED_TOPICS, ReceivedMessage
from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.bag import storage_files
from pneu_rig_ros.records.cdr_decoding import unpack_stamp, unpack_string
from pneu_rig_ros.records.description import bag_metadata
from pneu_rig_ros.records.repair import CUT_SUFFIX
from pneu_rig_ros.records.topics import CLOCK, JOINT, PRESSURE, RECORDER_DEPTH, TOPICS

SAMPLES = 'joint_states'
DESCRIPTION = 'rig_description'
STAMPED = {CLOCK} | {t.name for t in TOPICS.values() if t.type in (JOINT, PRESSURE)}


class RecorderNode(ManagedNode):
    """
    Writes the raw messages of all topics to a rosbag2 directory with MCAP storage.

    The log time is the reception time, as in rosbag2, and never decreases. In simulated time it is
    the stamp, and for unstamped messages the stamp of the last sample sent before them. After a
    write error the bag keeps what has been written, and the rig continues without recording.
    """

    NAME = 'recorder'
    period_ns = 20_000_000

    PARAMETERS = (
        Parameter(
            'output',
            '',
            'directory to create; empty: runs/ and the date',
            constraint='must not exist',
        ),
    )

    def set_up(self) -> None:
        """Create the bag and the subscriptions."""
        default = f'runs/{datetime.now():%Y-%m-%d_%H-%M-%S}'
        self._writer = BagWriter(free_path(Path(self.text('output') or default)))
        self._failure: str | None = None
        self._wall_clock = WallClock()
        self._newest_ns = 0
        self._description = ''
        self._simulated = SimulatedTime()
        self._waiting: list[ReceivedMessage] = []
        for topic in TOPICS.values():
            subscription = self.subscribe(topic.name, RECORDER_DEPTH)
            if not topic.extra:
                self._writer.add_topic(subscription.name, topic.type)
        self.get_logger().info(f'recording to {self._writer.path.resolve()}')

    def update(self) -> None:
        """Write all messages that have arrived; discard them after a write error."""
        batch = [m for s in self.polled_subscriptions for m in s.take_all_with_info()]
        self._wall_clock.update()
        for message in batch:
            if message.subscription.topic.name == DESCRIPTION:
                with self.skip_invalid(message.subscription):
                    self._description = unpack_string(message.cdr)
        if self._failure is not None:
            return
        try:
            if self.simulated_time:
                self._write_simulated(batch)
            else:
                self._write_received(batch)
            if not batch:
                self._writer.flush()
        except RigError as error:
            self._failure = f'{error}; recording has ended, what was recorded is kept'
            self.get_logger().error(self._failure)

    def _write_received(self, batch: list[ReceivedMessage]) -> None:
        """Write with the reception time; log times increase even if the clock is set back."""
        newest: dict[str, int] = {}
        timed = []
        for message in batch:
            name = message.subscription.name
            received_ns = self._wall_clock.without_steps(message.received_ns)
            newest[name] = max(received_ns, newest.get(name, self._newest_ns))
            timed.append((newest[name], message))
        for time_ns, message in sorted(timed, key=lambda item: item[0]):
            self._newest_ns = time_ns
            self._write(message, time_ns)

    def _write_simulated(self, batch: list[ReceivedMessage]) -> None:
        """Write with simulated time; unstamped messages wait for the next sample."""
        for message in batch:
            topic_name = message.subscription.topic.name
            if topic_name not in STAMPED:
                self._waiting.append(message)
                continue
            stamp_ns: int | None = None
            with self.skip_invalid(message.subscription):
                stamp_ns = unpack_stamp(message.cdr)
            if stamp_ns is None:
                continue
            if topic_name == SAMPLES:
                self._simulated.add_sample(message.sent_ns, stamp_ns)
            self._write(message, stamp_ns)
        waiting, self._waiting = self._waiting, []
        for message in waiting:
            if self._simulated.is_known(message.sent_ns):
                self._write(message, self._simulated.at(message.sent_ns))
            else:
                self._waiting.append(message)
        self._simulated.discard_before(min((m.sent_ns for m in self._waiting), default=0))

    def _write(self, message: ReceivedMessage, log_time_ns: int) -> None:
        subscription = message.subscription
        self._writer.write(subscription.name, subscription.topic.type, log_time_ns, message.cdr)
        self.rate.count += 1

    def stop(self) -> None:
        """Write the waiting messages."""
        self.update()

    def finish(self) -> None:
        """
        Write index and metadata.

        :raises RigError: when the bag could not be written completely
        """
        if self._failure is not None:
            with contextlib.suppress(RigError):  # the index may still fit
                self._writer.close(bag_metadata(self._description))
            raise RigError(self._failure)
        for message in self._waiting:
            self._write(message, self._simulated.at(message.sent_ns))
        self._writer.close(bag_metadata(self._description))
        self.get_logger().info(f'{self.rate.count} messages in {self._writer.path.resolve()}')

    def abort(self) -> None:
        """Remove the empty bag."""
        if self.configured:
            self._writer.abort()
            shutil.rmtree(self._writer.path)

    def status(self) -> NodeStatus:
        """Return losses and bag for `/diagnostics`."""
        counted = (s for s in self.polled_subscriptions if s.topic.name not in SHARED_TOPICS)
        lost = sum(subscription.sequence.lost for subscription in counted)
        values: dict[str, object] = {
            'messages': self.rate.count,
            'lost': lost,
            'recording': self._failure is None,
            'bag': self._writer.path.resolve(),
        }
        warnings = (
            f'{lost} messages lost' if lost else None,
            None if self.simulated_time else self._wall_clock.warning('log times'),
        )
        return NodeStatus('recording', values, warnings, errors=(self._failure,))


def free_path(path: Path) -> Path:
    """Return the path, or the next free name if a killed recorder has left its bag there."""
    cut = storage_files(path) and not (path / 'metadata.yaml').exists()
    repaired = any(path.glob(f'*{CUT_SUFFIX}*'))
    if not (cut or repaired):
        return path
    names = (path.with_name(f'{path.name}_{number}') for number in itertools.count(2))
    return next(name for name in names if not name.exists())


main = partial(runner.main, [RecorderNode])

if __name__ == '__main__':
    raise SystemExit(main())
