"""Joins readings that came in separate messages by their stamp."""

from collections import deque
from collections.abc import Iterator

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr import unpack_fluid_pressure, unpack_joint_state

Reading = tuple[int, float]
"""Stamp [ns] and value."""

LARGEST = 1e9
"""No sensor reads more [m, Pa]."""


def position_reading(cdr: bytes) -> Reading:
    """Decode stamp and position [m] of a JointState; RigError unless they can be used."""
    reading = unpack_joint_state(cdr)
    return reading.stamp_ns, _finite(reading.position, 'position')


def pressure_reading(cdr: bytes) -> Reading:
    """Decode stamp and pressure [Pa] of a FluidPressure; RigError unless they can be used."""
    reading = unpack_fluid_pressure(cdr)
    return reading.stamp_ns, _finite(reading.pressure, 'pressure')


def _finite(value: float, name: str) -> float:
    if not abs(value) <= LARGEST:
        raise RigError(f'{name} {value:g}, allowed are numbers up to {LARGEST:g}')
    return value


class Joiner:
    """
    Joins several streams of stamped values, each in order of its stamps.

    A stamp that one stream lacks is dropped from the others as soon as that stream is past it.

    :param streams: how many
    """

    def __init__(self, streams: int) -> None:
        self.queues: tuple[deque[Reading], ...] = tuple(deque() for _ in range(streams))
        self.dropped = 0

    def joined(self) -> Iterator[tuple[int, list[float]]]:
        """Yield stamp [ns] and the values of all streams for each complete stamp, in order."""
        while all(self.queues):
            newest = max(queue[0][0] for queue in self.queues)
            if all(queue[0][0] == newest for queue in self.queues):
                yield newest, [queue.popleft()[1] for queue in self.queues]
            else:
                self._drop_older(newest)

    def _drop_older(self, stamp_ns: int) -> None:
        for queue in self.queues:
            while queue and queue[0][0] < stamp_ns:
                queue.popleft()
                self.dropped += 1
