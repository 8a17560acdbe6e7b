"""
Friction force by Eq. 2 of the paper, from measured position and pressures alone.

In gauge form, so that the atmosphere on the rod's cross-section does not count as friction::

    F_r = p1 A1 - p2 A2 - p_atm (A1 - A2) - M a                                       (2)

The acceleration a is the twice differentiated position, low-passed without phase shift: a
first-order Butterworth filter at 32 Hz, run forwards and backwards (section 2.1). Offline the
whole recording is available. Live, the two-sided impulse response of that same filter is cut off
where 0.3 % of its area is left, so that the live force is the offline force, later by exactly 25
sampling intervals of 1.16 ms: ``DELAY`` = 29.0 ms.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.recording import low_pass
from pneu_rig_ros.rig import RigConfiguration

CUTOFF = 32.0
"""Cut-off frequency of the acceleration filter [Hz], section 2.1."""

DELAY = 0.029
"""Delay of the live estimate [s], rounded to whole samples: 25 of 1.16 ms."""

Pressure = TypeVar('Pressure', float, Floats)


@dataclass(frozen=True)
class ForceBalance:
    """Constants of Eq. 2: A1 and A2 of the piston [m^2], all that moves M [kg], p_atm [Pa]."""

    area_1: float
    area_2: float
    mass: float
    atmospheric_pressure: float

    @classmethod
    def of(cls, configuration: RigConfiguration) -> ForceBalance:
        """Return the constants of a configured rig."""
        model = configuration.model
        areas = model.cylinder.cap_area, model.cylinder.rod_area
        return cls(*areas, model.total_mass, model.gas.atmospheric_pressure)

    def pressure_force(self, pressure_1: Pressure, pressure_2: Pressure) -> Pressure:
        """Return the force of the air on the piston [N] from absolute pressures [Pa]."""
        ambient = self.atmospheric_pressure * (self.area_1 - self.area_2)
        return pressure_1 * self.area_1 - pressure_2 * self.area_2 - ambient


def can_estimate(interval: float) -> bool:
    """Return whether the filter of the acceleration is possible at a sampling interval [s]."""
    return 2.0 * CUTOFF * interval < 1.0


def _require_fast(interval: float) -> None:
    if not can_estimate(interval):
        raise RigError(
            f'friction: a sample every {1e3 * interval:g} ms is too slow for the '
            f'{CUTOFF:g} Hz filter of the acceleration'
        )


def delay_samples(interval: float) -> int:
    """Return the delay of the live estimate [samples] at a sampling interval [s]."""
    return round(DELAY / interval)


def zero_phase(signal: Floats, interval: float) -> Floats:
    """Return a signal, sampled at an interval [s], through the filter of section 2.1, (n,)."""
    once = low_pass(signal, interval, CUTOFF)
    return low_pass(once[::-1], interval, CUTOFF)[::-1]


def causal_kernel(interval: float) -> Floats:
    """
    Return the cut-off two-sided impulse response of the zero-phase low-pass.

    Symmetric with unit sum, so that it delays by exactly its half width and passes a constant
    unchanged. The half width is one less than ``delay_samples``, as the second difference takes
    the other one.

    :param interval: sampling interval [s]
    :return: weights, shape (2 delay_samples - 1,)
    :raises RigError: if the sampling is too slow
    """
    _require_fast(interval)
    half_width = delay_samples(interval) - 1
    impulse, centre = np.zeros(80 * half_width + 1), 40 * half_width
    impulse[centre] = 1.0
    response = zero_phase(impulse, interval)[centre - half_width : centre + half_width + 1]
    kernel = response + response[::-1]
    return np.asarray(kernel / kernel.sum())


def acceleration_zero_phase(position: ArrayLike, interval: float) -> Floats:
    """
    Return the acceleration [m/s^2] of equally spaced positions [m], same shape (n,).

    Second central difference, then forward-backward first-order Butterworth; no phase shift. The
    acceleration is poorly defined at the ends of a recording: it fades to 0 within ``DELAY``.
    """
    x = np.asarray(position, dtype=np.float64)
    if x.ndim != 1 or x.size < 4:
        raise RigError(f'friction: {x.size} samples, at least 4 are needed to differentiate twice')
    _require_fast(interval)
    # Point reflection at its ends continues the position without a jump in velocity, which the
    # second difference would turn into an impulse.
    margin = min(x.size - 1, 2 * delay_samples(interval))
    extended = np.pad(x, margin, mode='reflect', reflect_type='odd')
    filtered = zero_phase(np.diff(extended, 2) / interval**2, interval)
    return filtered[margin - 1 : margin - 1 + x.size]


def friction_zero_phase(
    position: Floats,
    pressure_1: Floats,
    pressure_2: Floats,
    interval: float,
    balance: ForceBalance,
) -> Floats:
    """
    Return the friction force F_r of Eq. 2 [N], offline, in phase with the samples, shape (n,).

    :param position: [m], shape (n,), a sample every ``interval`` [s]
    :param pressure_1: absolute, of the cap end [Pa], shape (n,)
    :param pressure_2: absolute, of the rod end [Pa], shape (n,)
    """
    inertia = balance.mass * acceleration_zero_phase(position, interval)
    return np.asarray(balance.pressure_force(pressure_1, pressure_2) - inertia)


class CausalFriction:
    """
    Live Eq. 2: push a sample each ``interval`` [s], get the force of ``delay_samples`` ago.

    :raises RigError: if the sampling is too slow
    """

    def __init__(self, balance: ForceBalance, interval: float) -> None:
        self.delay_samples = delay_samples(interval)
        self._balance = balance
        # Low-pass and second central difference in one, scaled to a force [N/m]. Symmetric, so
        # the order of the samples does not matter.
        weights = np.convolve(causal_kernel(interval), [1.0, -2.0, 1.0]) / interval**2
        self._kernel: Floats = balance.mass * weights
        self._size = self._kernel.size
        # Every value is stored twice, one window apart, so that the window is always contiguous.
        self._positions = np.zeros(2 * self._size)
        self._forces = [0.0] * self._size
        self.reset()

    def reset(self) -> None:
        """Forget the samples: the next force comes after 2 ``delay_samples`` + 1 of them."""
        self._count = 0

    def push(self, position: float, pressure_1: float, pressure_2: float) -> float | None:
        """
        Take the next sample [m, Pa, Pa] and return F_r [N] of ``delay_samples`` ago.

        None until the filter is full, i.e. for the first 2 ``delay_samples`` samples.
        """
        size, count = self._size, self._count
        slot = count % size
        self._positions[slot] = self._positions[slot + size] = position
        self._forces[slot] = self._balance.pressure_force(pressure_1, pressure_2)
        self._count = count + 1
        if count + 1 < size:
            return None
        window = self._positions[slot + 1 : slot + 1 + size]
        force = self._forces[(count - self.delay_samples) % size]
        return force - float(self._kernel @ window)


def friction_of(recording: Recording) -> Floats:
    """
    Return the friction force F_r of a recording [N], shape (n,), by the zero-phase estimator.

    :raises RigError: when the recording lacks the configuration of the rig
    """
    balance = ForceBalance.of(require_rig(recording))
    return friction_zero_phase(
        recording.position, recording.pressure_1, recording.pressure_2, recording.interval, balance
    )


def known_friction(recording: Recording) -> Floats | None:
    """Return the same, None where the rig is not known or the samples are too few or too far."""
    with contextlib.suppress(RigError):
        return friction_of(recording)
    return None


def require_rig(recording: Recording) -> RigConfiguration:
    """Return the configuration of the recorded rig; RigError when it is not known."""
    if recording.configuration is None:
        raise RigError(
            'the bag does not hold the configuration of the rig, so piston areas, mass and stroke '
            'are unknown; import it with --cylinder, or record rig_description too'
        )
    return recording.configuration
