"""The recorder node: every topic of the rig into a bag, losing nothing."""

import contextlib
import itertools
import shutil
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from rclpy.context import Context

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.losses import Losses
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.nodes.timeline import Timeline
from pneu_rig_ros.nodes.wall_clock import WallClock
from pneu_rig_ros.nodes.wiring import Arrival, Inlet
from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.bag import storage_files
from pneu_rig_ros.records.cdr import unpack_stamp, unpack_string
from pneu_rig_ros.records.description import bag_metadata
from pneu_rig_ros.records.repair import CUT_SUFFIX
from pneu_rig_ros.records.topics import CLOCK, TOPICS

SAMPLES = 'joint_states'
DESCRIPTION = 'rig_description'
STAMPED = {CLOCK} | {
    topic.name
    for topic in TOPICS.values()
    if topic.type in ('sensor_msgs/msg/JointState', 'sensor_msgs/msg/FluidPressure')
}


class RecorderNode(RigNode):
    """
    Writes the raw messages of all topics to a rosbag2 directory with MCAP storage.

    The log time is the time of reception, as in rosbag2, and never goes back. In simulated time it
    is the stamp, and for messages without one the stamp of the sample that was sent last before.
    When the bag cannot be written any more, what is in it stays and the rig goes on unrecorded.
    """

    period_ns = 20_000_000

    PARAMETERS = (Parameter('output', '', 'directory to create; empty: runs/ and the date'),)

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('recorder', context, overrides)
        default = f'runs/{datetime.now():%Y-%m-%d_%H-%M-%S}'
        self._writer = BagWriter(successor(Path(self.text('output') or default)))
        self._failure: RigError | None = None
        self._wall_clock = WallClock()
        self._newest_ns = 0
        self._description = ''
        self._timeline = Timeline() if self.simulated_time else None
        self._waiting: list[tuple[Inlet, Arrival]] = []
        self._rate = Rate()
        self._losses = Losses()
        for topic in TOPICS.values():
            inlet = self.inlet(topic.name)
            if not topic.extra:
                self._writer.add_topic(inlet.name, topic.type)
        self.get_logger().info(f'recording to {self._writer.path.resolve()}')

    def work(self) -> None:
        """Write all that has arrived; drop it once the bag cannot be written any more."""
        batch = [(inlet, arrival) for inlet in self.inlets for arrival in inlet.arrivals()]
        self._wall_clock.look()
        for inlet, arrival in batch:
            self._losses.note(inlet.topic.name, arrival.number)
            if inlet.topic.name == DESCRIPTION:
                with self.refusing(inlet):
                    self._description = unpack_string(arrival.cdr)
        if self._failure is None:
            try:
                self._record(batch)
            except RigError as error:
                self._failure = error
                self.get_logger().error(self._told(error))

    def _record(self, batch: list[tuple[Inlet, Arrival]]) -> None:
        if self._timeline is None:
            self._write_received(batch)
        else:
            self._write_simulated(batch, self._timeline)
        if not batch:
            self._writer.flush()

    def _write_received(self, batch: list[tuple[Inlet, Arrival]]) -> None:
        """Write at the time of reception; a clock that is set does not turn time back."""
        newest: dict[str, int] = {}
        timed = []
        for inlet, arrival in batch:
            received_ns = self._wall_clock.steady(arrival.received_ns)
            newest[inlet.name] = max(received_ns, newest.get(inlet.name, self._newest_ns))
            timed.append((newest[inlet.name], inlet, arrival.cdr))
        for time_ns, inlet, cdr in sorted(timed, key=lambda item: item[0]):
            self._newest_ns = time_ns
            self._write(inlet, time_ns, cdr)

    def _write_simulated(self, batch: list[tuple[Inlet, Arrival]], timeline: Timeline) -> None:
        """Write at simulated time; what has no stamp waits until the sample after it is here."""
        for inlet, arrival in batch:
            if inlet.topic.name in STAMPED:
                self._write_stamped(inlet, arrival, timeline)
            else:
                self._waiting.append((inlet, arrival))
        waiting, self._waiting = self._waiting, []
        for inlet, arrival in waiting:
            if timeline.knows(arrival.sent_ns):
                self._write(inlet, timeline.time_of(arrival.sent_ns), arrival.cdr)
            else:
                self._waiting.append((inlet, arrival))
        timeline.forget_before(min((a.sent_ns for _, a in self._waiting), default=0))

    def _write_stamped(self, inlet: Inlet, arrival: Arrival, timeline: Timeline) -> None:
        stamp_ns: int | None = None
        with self.refusing(inlet):
            stamp_ns = unpack_stamp(arrival.cdr)
        if stamp_ns is None:
            return
        if inlet.topic.name == SAMPLES:
            timeline.mark(arrival.sent_ns, stamp_ns)
        self._write(inlet, stamp_ns, arrival.cdr)

    def _write(self, inlet: Inlet, log_time_ns: int, cdr: bytes) -> None:
        self._writer.write(inlet.name, inlet.topic.type, log_time_ns, cdr)
        self._rate.count += 1

    def close(self) -> None:
        """
        Write what still waits, then index and metadata.

        :raises RigError: when the bag could not be written to its end
        """
        self.work()
        if self._failure is not None:
            with contextlib.suppress(RigError):  # there may be room for the index
                self._writer.close(bag_metadata(self._description))
            raise RigError(self._told(self._failure))
        for inlet, arrival in self._waiting:
            assert self._timeline is not None
            self._write(inlet, self._timeline.time_of(arrival.sent_ns), arrival.cdr)
        self._writer.close(bag_metadata(self._description))
        self.get_logger().info(f'{self._rate.count} messages in {self._writer.path.resolve()}')

    def withdraw(self) -> None:
        """Leave no bag behind."""
        self._writer.abort()
        shutil.rmtree(self._writer.path)

    def report(self) -> Report:
        """Return rate, losses and bag for `/diagnostics`."""
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'messages': self._rate.count,
            'lost': self._losses.total,
            'bag': self._writer.path.resolve(),
        }
        lost = self._losses.total
        return Report.of(
            'recording',
            values,
            warnings=(
                f'{lost} messages lost' if lost else None,
                None if self.simulated_time else self._wall_clock.told('log times'),
            ),
            errors=(self._told(self._failure) if self._failure else None,),
        )

    def _told(self, failure: RigError) -> str:
        return f'{failure}; recording has ended, what was recorded is kept'


def successor(path: Path) -> Path:
    """Return the path; where a killed recorder has left its bag, the next name that is free."""
    cut = storage_files(path) and not (path / 'metadata.yaml').exists()
    repaired = any(path.glob(f'*{CUT_SUFFIX}*'))
    if not (cut or repaired):
        return path
    names = (path.with_name(f'{path.name}_{number}') for number in itertools.count(2))
    return next(name for name in names if not name.exists())


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([RecorderNode])


if __name__ == '__main__':
    raise SystemExit(main())
