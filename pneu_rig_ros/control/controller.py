"""A position controller: a law, what it needs against friction and valve overlap, and limits."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.control.laws import Law
from pneu_rig_ros.model.quantity import Quantity

STILL = 1e-4
"""A reference slower than this stands still [m/s]."""

JUMP = 3.0
"""A reference faster than this has jumped, which is no motion to follow [m/s]."""


class Compensation(NamedTuple):
    """
    What keeps friction and valve overlap from making a limit cycle.

    Small commands jump over the overlap of the valves, so that a held piston is pushed at once and
    not when an integral has grown. Where the piston is close enough to a reference that stands
    still, the valves are shut and the integral is emptied: friction then holds the piston.
    """

    overlap: Annotated[
        float, Quantity('V', 0.0, 1.0, 'command at which the valves begin to open')
    ] = 0.15
    smoothing: Annotated[
        float, Quantity('V', 1e-4, 1.0, 'raw command over which the jump is spread')
    ] = 0.1
    tolerance: Annotated[float, Quantity('m', 0.0, 0.1, 'error that counts as none')] = 3e-4

    def jump(self, raw: float) -> float:
        """Return the command [V] beyond the overlap for a raw one [V]."""
        return raw + self.overlap * min(max(raw / self.smoothing, -1.0), 1.0)


NONE = Compensation(overlap=0.0, tolerance=0.0)
"""No compensation at all."""


class PositionController:
    """
    From position and velocity to the command u, sample by sample.

    :param law: of control
    :param compensation: of friction and overlap; NONE for the bare law
    :param limit: largest command [V]
    """

    def __init__(self, law: Law, compensation: Compensation = NONE, limit: float = 2.5) -> None:
        self._law = law
        self._compensation = compensation
        self._limit = limit
        self._reference = math.nan

    def update(self, interval: float, reference: float, position: float, velocity: float) -> float:
        """
        Return the command u [V].

        :param interval: time since the last call [s], 0 in the first one
        :param reference: where the piston shall be [m]
        :param position: where it is [m]
        :param velocity: its velocity [m/s]
        """
        rate = self._rate(reference, interval)
        error = reference - position
        if abs(error) < self._compensation.tolerance and abs(rate) < STILL:
            self._law.rest()
            return 0.0
        raw = self._law.command(error, rate - velocity, rate)
        wanted = self._compensation.jump(raw)
        command = min(max(wanted, -self._limit), self._limit)
        if command == wanted or (wanted - command) * error < 0.0:
            self._law.learn(error, interval)
        return command

    def _rate(self, reference: float, interval: float) -> float:
        """Return the speed of the reference [m/s], 0 when it has jumped or is the first one."""
        last, self._reference = self._reference, reference
        moved = abs(reference - last) <= JUMP * interval and interval > 0.0
        return (reference - last) / interval if moved else 0.0
