"""Whole samples of a rig, whose parts are separate messages, and time by their stamps."""

from bisect import bisect_right
from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.records.cdr_decoding import unpack_fluid_pressure, unpack_joint_state
from pneu_rig_ros.records.topics import SAMPLE_TOPICS

LARGEST_VALUE = 1e9
"""Largest plausible magnitude of a sensor reading [m, Pa]."""


class TimeSynchronizer:
    """
    Combines stamped values of equal stamps, as `message_filters.TimeSynchronizer` does.

    Each queue holds (stamp [ns], value) in order of the stamps. A stamp that is missing in one
    queue is dropped from the others as soon as that queue has a later one. Where stamps jump back,
    as those of a restarted simulation do, what is before the jump is dropped.
    """

    def __init__(self, size: int) -> None:
        self.queues: tuple[deque[tuple[int, Any]], ...] = tuple(deque() for _ in range(size))
        self.dropped = 0
        """Values whose stamp another queue lacks."""

    def complete(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield stamp [ns] and one value of each queue for every complete stamp, in order."""
        while all(self.queues):
            newest = max(queue[0][0] for queue in self.queues)
            if all(queue[0][0] == newest for queue in self.queues):
                yield newest, [queue.popleft()[1] for queue in self.queues]
                continue
            ahead = [queue for queue in self.queues if queue[0][0] == newest]
            behind = [queue for queue in self.queues if queue[0][0] < newest]
            jumps_back = any(len(queue) > 1 and queue[1][0] < queue[0][0] for queue in ahead)
            for queue in ahead if jumps_back else behind:
                queue.popleft()
                self.dropped += 1


class Sample(NamedTuple):
    """
    One sample of a rig [SI]; its velocity may be anything.

    :param stamp_ns: time of the sample [ns]
    :param sent_ns: wall time at which its position was sent [ns]
    """

    stamp_ns: int
    sent_ns: int
    position: float
    velocity: float
    pressure_1: float
    pressure_2: float


class SampleSubscription(TimeSynchronizer):
    """Takes whole samples of a rig; a reading that is not plausible is refused by the node."""

    def __init__(self, node: RigNode) -> None:
        super().__init__(len(SAMPLE_TOPICS))
        self._node = node
        self._joints, *self._chambers = map(node.subscribe, SAMPLE_TOPICS)
        self._stamps: deque[int] = deque(maxlen=2)

    def off_grid(self, interval_ns: int) -> str | None:
        """Return a warning if the last samples were not on a grid of this interval."""
        step_ns = self._stamps[-1] - self._stamps[0] if self._stamps else 0
        if step_ns <= 0 or step_ns % interval_ns == 0:
            return None
        return (
            f'samples are {step_ns * 1e-6:g} ms apart, not on the grid of the sampling.interval '
            f'of the configuration, {interval_ns * 1e-6:g} ms'
        )

    def take_all(self) -> Iterator[Sample]:
        """Yield the samples that have become complete, in order."""
        joints, *pressures = self.queues
        for message in self._joints.take_all_with_info():
            with self._node.skip_invalid(self._joints):
                joint = unpack_joint_state(message.cdr)
                position = _plausible(joint.position, 'position')
                joints.append((joint.stamp_ns, (message.sent_ns, position, joint.velocity)))
        for queue, chamber in zip(pressures, self._chambers, strict=True):
            queue.extend(self._node.take_decoded(chamber, _decode_pressure))
        for stamp_ns, (joint_values, pressure_1, pressure_2) in self.complete():
            sent_ns, position, velocity = joint_values
            self._stamps.append(stamp_ns)
            yield Sample(stamp_ns, sent_ns, position, velocity, pressure_1, pressure_2)


def _decode_pressure(cdr: bytes) -> tuple[int, float]:
    reading = unpack_fluid_pressure(cdr)
    return reading.stamp_ns, _plausible(reading.pressure, 'pressure')


def _plausible(value: float, name: str) -> float:
    if not abs(value) <= LARGEST_VALUE:
        raise RigError(f'{name} {value:g}, allowed are numbers up to {LARGEST_VALUE:g}')
    return value


class SampleClock:
    """
    Time by the stamps of samples, which starts again where they jump back.

    So they do when a simulation is restarted or a bag is played again.
    """

    def __init__(self) -> None:
        self._start_ns: int | None = None
        self._last_ns = 0
        self.elapsed = 0.0
        """Time since the start [s]."""
        self.interval = 0.0
        """Time since the sample before, 0 at the start [s]."""

    @property
    def started(self) -> bool:
        """Whether there was a sample."""
        return self._start_ns is not None

    def update(self, stamp_ns: int) -> None:
        """Set the times to those of the next sample."""
        if self._start_ns is None or stamp_ns < self._last_ns:
            self._start_ns = self._last_ns = stamp_ns
        self.elapsed = (stamp_ns - self._start_ns) * 1e-9
        self.interval = (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns


class SimulatedTime:
    """
    Maps source times of messages to simulated time.

    The stamp of a sample holds from the moment when the sample was sent until the next one is
    sent. This depends on the order of cause and effect only, so that two runs in lock step agree,
    however late the messages were read.
    """

    def __init__(self) -> None:
        self._sent: list[int] = []
        self._stamps: list[int] = []

    def add_sample(self, sent_ns: int, stamp_ns: int) -> None:
        """Add the sample of `stamp_ns`, sent at `sent_ns` and after all samples added before."""
        self._sent.append(sent_ns)
        self._stamps.append(stamp_ns)

    def is_known(self, sent_ns: int) -> bool:
        """Return whether a later sample is known, so that the time asked for is final."""
        return bool(self._sent) and sent_ns <= self._sent[-1]

    def at(self, sent_ns: int) -> int:
        """Return the stamp of the newest sample sent before [ns]; 0 before the first one."""
        index = bisect_right(self._sent, sent_ns)
        return self._stamps[index - 1] if index else 0

    def discard_before(self, sent_ns: int) -> None:
        """Discard the samples that no message sent after `sent_ns` needs."""
        keep = max(bisect_right(self._sent, sent_ns) - 1, 0)
        del self._sent[:keep], self._stamps[:keep]
