"""Synchronisation of the position and the pressures of a sample, which are separate messages."""

from collections import deque
from collections.abc import Iterator

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr import unpack_fluid_pressure, unpack_joint_state

StampedValue = tuple[int, float]
"""Stamp [ns] and value."""

LARGEST_VALUE = 1e9
"""Largest plausible magnitude of a sensor reading [m, Pa]."""


def decode_position(cdr: bytes) -> StampedValue:
    """Decode stamp and position [m] of a JointState; RigError unless they are plausible."""
    reading = unpack_joint_state(cdr)
    return reading.stamp_ns, _plausible(reading.position, 'position')


def decode_pressure(cdr: bytes) -> StampedValue:
    """Decode stamp and pressure [Pa] of a FluidPressure; RigError unless they are plausible."""
    reading = unpack_fluid_pressure(cdr)
    return reading.stamp_ns, _plausible(reading.pressure, 'pressure')


def _plausible(value: float, name: str) -> float:
    if not abs(value) <= LARGEST_VALUE:
        raise RigError(f'{name} {value:g}, allowed are numbers up to {LARGEST_VALUE:g}')
    return value


class TimeSynchronizer:
    """
    Combines stamped values of equal stamps, as `message_filters.TimeSynchronizer` does.

    Each queue must be in order of its stamps. A stamp that is missing in one queue is dropped
    from the others as soon as that queue has a later one.

    :param size: number of queues
    """

    def __init__(self, size: int) -> None:
        self.queues: tuple[deque[StampedValue], ...] = tuple(deque() for _ in range(size))
        self.dropped = 0

    def complete(self) -> Iterator[tuple[int, list[float]]]:
        """Yield stamp [ns] and one value of each queue for every complete stamp, in order."""
        while all(self.queues):
            newest = max(queue[0][0] for queue in self.queues)
            if all(queue[0][0] == newest for queue in self.queues):
                yield newest, [queue.popleft()[1] for queue in self.queues]
            else:
                self._drop_before(newest)

    def _drop_before(self, stamp_ns: int) -> None:
        for queue in self.queues:
            while queue and queue[0][0] < stamp_ns:
                queue.popleft()
                self.dropped += 1
