"""
Position control: a law from error to command, compensation of friction and overlap, limits.

The rig behaves roughly like an integrator: u opens the valves, the air sets the speed. What makes
it hard is the overlap of the valves, in which nothing flows, and friction that holds the piston
until the pressure has risen to break it away. An integral part then keeps on filling a chamber:
the piston slips past the target, and the same begins in the other direction, a limit cycle.
"""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.quantity import Quantity


class Pid(NamedTuple):
    """u = K_p e + K_i int(e) dt + K_d de/dt."""

    proportional_gain: Annotated[float, Quantity('V/m', 0.0, 1e5, 'u per error')] = 400.0
    integral_gain: Annotated[
        float, Quantity('V/(m*s)', 0.0, 1e5, 'rate of u per error; law pid')
    ] = 200.0
    derivative_gain: Annotated[
        float, Quantity('V*s/m', 0.0, 1e4, 'u per rate of the error; law pid')
    ] = 30.0

    def command(
        self, error: float, error_rate: float, reference_rate: float, integral: float
    ) -> tuple[float, float]:
        """Return the raw command [V], and the rate of the integral of K_i e [V/s]."""
        raw = self.proportional_gain * error + integral + self.derivative_gain * error_rate
        return raw, self.integral_gain * error


class SlidingMode(NamedTuple):
    """
    u = K sat(s / phi) + K_f dr/dt on the surface s = de/dt + 2 lambda e + lambda^2 int(e) dt.

    On the surface the error decays with time constant 1/lambda whatever the friction; the boundary
    layer phi replaces switching, which valves and air would answer by chatter, and the integral
    takes away the offset that friction would leave in it.
    Reference: J.-J. Slotine, W. Li, Applied Nonlinear Control (1991), chapter 7.
    """

    surface_slope: Annotated[
        float, Quantity('1/s', 0.1, 1e3, 'decay of the error on the surface; law sliding_mode')
    ] = 3.0
    switching_gain: Annotated[
        float, Quantity('V', 0.0, 2.5, 'u off the surface; law sliding_mode')
    ] = 2.0
    boundary_layer: Annotated[
        float, Quantity('m/s', 1e-4, 10.0, 'distance at which u is full; law sliding_mode')
    ] = 0.027
    feedforward: Annotated[
        float, Quantity('V*s/m', 0.0, 1e3, 'u per speed of the reference; law sliding_mode')
    ] = 3.0

    def command(
        self, error: float, error_rate: float, reference_rate: float, integral: float
    ) -> tuple[float, float]:
        """
        Return the raw command [V], and the rate of the integral of e [m].

        It grows within the boundary layer only: outside, it would wind up.
        """
        slope = self.surface_slope
        surface = error_rate + 2.0 * slope * error + slope**2 * integral
        distance = surface / self.boundary_layer
        switching = self.switching_gain * min(max(distance, -1.0), 1.0)
        raw = switching + self.feedforward * reference_rate
        return raw, error if abs(distance) < 1.0 else 0.0


Law = Pid | SlidingMode

STILL = 1e-4
"""A reference slower than this stands still [m/s]."""

JUMP = 3.0
"""A reference faster than this is a step, not a motion to follow [m/s]."""


class Compensation(NamedTuple):
    """
    Compensation of friction and valve overlap, which would otherwise cause a limit cycle.

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
    """From position and velocity to the command u, at most ``limit`` [V], sample by sample."""

    def __init__(self, law: Law, compensation: Compensation = NONE, limit: float = 2.5) -> None:
        self._law = law
        self._compensation = compensation
        self._limit = limit
        self._reference = math.nan
        self._integral = 0.0

    def update(self, interval: float, reference: float, position: float, velocity: float) -> float:
        """
        Return the command u [V].

        :param interval: time since the last call [s], 0 in the first one
        :param reference: position reference [m]
        :param position: measured position [m]
        :param velocity: its velocity [m/s]
        """
        rate = self._rate(reference, interval)
        error = reference - position
        if abs(error) < self._compensation.tolerance and abs(rate) < STILL:
            self._integral = 0.0
            return 0.0
        raw, growth = self._law.command(error, rate - velocity, rate, self._integral)
        wanted = self._compensation.jump(raw)
        command = min(max(wanted, -self._limit), self._limit)
        # Anti-windup: a saturated command only lets the integral unwind.
        if command == wanted or (wanted - command) * error < 0.0:
            self._integral += growth * interval
        return command

    def _rate(self, reference: float, interval: float) -> float:
        """Return the speed of the reference [m/s], 0 when it has jumped or is the first one."""
        last, self._reference = self._reference, reference
        moved = abs(reference - last) <= JUMP * interval and interval > 0.0
        return (reference - last) / interval if moved else 0.0
