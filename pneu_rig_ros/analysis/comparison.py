"""
Two runs side by side: how far apart their signals are, and their stick-slip events.

What is derived - velocity and friction - is derived from both by the same estimators, so that a
difference is one of the runs and not of the filters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.friction import CUTOFF, Floats, ForceBalance, friction_zero_phase
from pneu_rig_ros.analysis.stick_slip import Cycle, find_cycles
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.sensors import Sensors

UNITS = {'position': 'm', 'velocity': 'm/s', 'pressure_1': 'Pa', 'pressure_2': 'Pa',
         'friction': 'N'}  # fmt: skip
"""Signal that is compared -> its unit."""

END_SHARE = 0.98
"""A stroke counts as done at this share of the way to the end stop [-]."""

NOISE_SAMPLES = 8192
"""Length of the noise from which that of the derived signals is found."""


class SignalGap(NamedTuple):
    """
    How far a simulated signal is from a measured one, in the unit of the signal.

    :param unit: of the following four
    :param rmse: root of the mean square of simulated less measured
    :param largest: largest absolute difference
    :param bias: mean of simulated less measured
    :param noise: standard deviation of the measured signal's noise, None if it is not known
    """

    unit: str
    rmse: float
    largest: float
    bias: float
    noise: float | None

    @property
    def multiple(self) -> float | None:
        """The RMSE in multiples of the noise [-], None where the noise is 0 or not known."""
        return self.rmse / self.noise if self.noise else None

    @property
    def above_noise(self) -> float:
        """What of the RMSE noise does not explain: 0 if all of it does [unit]."""
        return float(np.sqrt(max(self.rmse**2 - (self.noise or 0.0) ** 2, 0.0)))


class Events(NamedTuple):
    """
    What happens in a run.

    :param cycles: stick-slip cycles in the order of time
    :param stroke_time: from the start until the piston has gone 98 % of the way to the end stop
        ahead of it [s], None if it does not get there or the stroke is not known
    """

    cycles: tuple[Cycle, ...]
    stroke_time: float | None


@dataclass(frozen=True)
class Run:
    """
    One run on a uniform grid.

    :param name: for people
    :param interval: sampling interval [s]
    :param position: [m], shape (n,)
    :param pressure_1: cap end, absolute [Pa], shape (n,)
    :param pressure_2: rod end, absolute [Pa], shape (n,)
    :param balance: constants of Eq. 2, None where they are not known: then no friction
    :param stroke: L [m], None where it is not known
    :raises RigError: for fewer than 4 samples, or signals of different lengths
    """

    name: str
    interval: float
    position: Floats
    pressure_1: Floats
    pressure_2: Floats
    balance: ForceBalance | None = None
    stroke: float | None = None

    def __post_init__(self) -> None:
        """Check the lengths."""
        sizes = [self.position.size, self.pressure_1.size, self.pressure_2.size]
        if len(set(sizes)) > 1:
            counts = ', '.join(map(str, sizes))
            raise RigError(f'{self.name}: {counts} samples of position, pressure_1, pressure_2; '
                           'must be as many of each')  # fmt: skip
        if sizes[0] < 4:
            raise RigError(f'{self.name}: {sizes[0]} samples, at least 4 are needed')

    @classmethod
    def of(
        cls, name: str, record: Recording, configuration: RigConfiguration | None = None
    ) -> Run:  # fmt: skip
        """Return the run of a record; of the rig `configuration`, else of the record's own."""
        rig = configuration or record.configuration
        return cls(
            name, record.interval, record.position, record.pressure_1, record.pressure_2,
            ForceBalance.of(rig) if rig else None,
            rig.model.cylinder.stroke if rig else None,
        )  # fmt: skip

    @property
    def time(self) -> Floats:
        """Time since the first sample [s], shape (n,)."""
        return self.interval * np.arange(self.position.size, dtype=np.float64)

    @cached_property
    def signals(self) -> dict[str, Floats]:
        """
        Name of :data:`UNITS` -> signal, shape (n,).

        Without friction where the rig is not known, or the sampling too slow for its filter.
        """
        found = {
            'position': self.position,
            'velocity': velocity_of(self.position, self.interval),
            'pressure_1': self.pressure_1,
            'pressure_2': self.pressure_2,
        }
        if self.balance is not None and 2.0 * CUTOFF * self.interval < 1.0:
            found['friction'] = friction_zero_phase(
                self.position, self.pressure_1, self.pressure_2, self.interval, self.balance
            )
        return found

    @cached_property
    def events(self) -> Events:
        """Stick-slip cycles and stroke time."""
        cycles = find_cycles(self.position, self.interval, self.signals.get('friction'))
        reached = stroke_time(self.position, self.interval, self.stroke)
        return Events(tuple(cycles), reached)


def compare_signals(
    measured: Mapping[str, Floats],
    simulated: Mapping[str, Floats],
    noise: Mapping[str, float] | None = None,
    units: Mapping[str, str] | None = None,
    where: NDArray[np.bool_] | None = None,
) -> dict[str, SignalGap]:
    """
    Return how far simulated signals are from measured ones, for every signal that both have.

    :param measured: name -> signal, each of shape (n,), SI units
    :param simulated: the same at the same instants
    :param noise: name -> standard deviation of a measured value, as far as it is known
    :param units: name -> unit; :data:`UNITS` and '' for other names when not given
    :param where: samples that count, shape (n,); all when not given
    :raises RigError: when lengths differ, or nothing is left to compare
    """
    gaps = {}
    for name in (name for name in measured if name in simulated):
        if measured[name].shape != simulated[name].shape:
            raise RigError(f'{name}: {measured[name].shape} measured values against '
                           f'{simulated[name].shape} simulated ones')  # fmt: skip
        difference = simulated[name] - measured[name]
        kept = difference if where is None else difference[where]
        kept = kept[np.isfinite(kept)]
        if kept.size:
            unit = (units or UNITS).get(name, '')
            gaps[name] = _gap(kept, unit, (noise or {}).get(name))
    if not gaps:
        raise RigError('nothing to compare: the runs share no signal')
    return gaps


def _gap(difference: Floats, unit: str, noise: float | None) -> SignalGap:
    rmse = float(np.sqrt(np.mean(difference**2)))
    return SignalGap(unit, rmse, float(np.abs(difference).max()), float(difference.mean()), noise)


def compare_runs(
    measured: Run, simulated: Run, noise: Mapping[str, float] | None = None
) -> dict[str, SignalGap]:
    """Return how far a simulated run is from a measured one; see :func:`compare_signals`."""
    return compare_signals(measured.signals, simulated.signals, noise)


def signal_noise(
    position_noise: float, pressure_noise: float, interval: float,
    balance: ForceBalance | None = None,
) -> dict[str, float]:  # fmt: skip
    """
    Return the standard deviation of the noise of each signal of :data:`UNITS`.

    That of the derived signals comes from the estimators themselves, run on white noise of the
    sensors; they are linear. The noise is drawn from a fixed seed.

    :param position_noise: standard deviation of a reading [m]
    :param pressure_noise: of a reading [Pa]
    :param interval: sampling interval [s]
    :param balance: constants of Eq. 2; without them there is no friction
    """
    draws = np.random.default_rng(0).standard_normal((3, NOISE_SAMPLES))
    x, p1, p2 = draws * np.array([[position_noise], [pressure_noise], [pressure_noise]])
    still = None if balance is None else ForceBalance(
        balance.area_1, balance.area_2, balance.mass, 0.0)  # fmt: skip
    run = Run('noise', interval, x, p1, p2, still)
    inner = slice(NOISE_SAMPLES // 8, -NOISE_SAMPLES // 8)  # ends are padded, not estimated
    found = {name: float(np.std(signal[inner])) for name, signal in run.signals.items()}
    return found | {'position': position_noise,
                    'pressure_1': pressure_noise, 'pressure_2': pressure_noise}  # fmt: skip


def sensor_noise(sensors: Sensors) -> tuple[float, float]:
    """Return the standard deviation of a reading of position [m] and pressure [Pa]: data sheet."""
    codes = 2.0**sensors.resolution - 1.0
    position = np.hypot(sensors.position_noise, sensors.position_span / codes / np.sqrt(12.0))
    pressure = np.hypot(sensors.pressure_noise, sensors.pressure_span / codes / np.sqrt(12.0))
    return float(position), float(pressure)


def stroke_time(position: Floats, interval: float, stroke: float | None) -> float | None:
    """
    Return when the piston has gone 98 % of the way to the end stop ahead of it [s].

    The end ahead is the one further from where the run starts. None if it does not get there, or
    the stroke [m] is not known.
    """
    if stroke is None:
        return None
    outward = position[0] < stroke / 2
    done = position >= END_SHARE * stroke if outward else position <= (1 - END_SHARE) * stroke
    return float(interval * done.argmax()) if done.any() else None
