"""
A recording, prepared to be compared with a model: smoothed motion, rests, what can be trusted.

Of position and pressures both are kept, the readings, whose noise is known, and smoothed ones, of
which the modelled rates are taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter
from scipy.special import ndtr

from pneu_rig_ros.analysis.motion import Rest, find_rests
from pneu_rig_ros.analysis.velocity import adaptive_velocity, window_for
from pneu_rig_ros.model import along
from pneu_rig_ros.model.parameters import Gas, Operation

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SMOOTHING = 0.025
"""Window of the parabolas that smooth pressures and position, short beside a chamber [s]."""
AT_STOP = 3e-4
"""A rest this close to an end stop cannot be told from one at it [m]."""
CLIPPED = 4.0
"""Noises from the end of a span within which readings are cut off on one side [-]."""
IMPACT = 0.1
"""Before it comes to rest at an end stop the piston bounces, and its speed is smeared [s]."""
FINE = 0.5
"""Length of the shortest line fits of the speed in those that tell rest from motion [-]."""
LATEST = 3.0
"""Standard deviations of a clock's offset that it has at most."""
SMEARED = 0.046
"""After a breakaway and before a rest the speed is smeared by the fits it comes from [s]."""


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a reading of x [m], p1, p2 [Pa] and of the bench's force [N]."""

    position: float
    pressure_1: float
    pressure_2: float
    force: float = 0.0


@dataclass(frozen=True)
class Span:
    """Ends of what the sensors read: largest x [m], smallest and largest pressure [Pa]."""

    position: float = np.inf
    low: float = 0.0
    high: float = np.inf


@dataclass(frozen=True)
class Run:
    """
    Signals of n samples of one run.

    :param name: of the recording
    :param interval: [s]
    :param position: readings [m], shape (n,)
    :param pressures: readings of p1, p2, absolute [Pa], shape (n, 2)
    :param voltages: u1, u2 in each interval [V], shape (n - 1, 2)
    :param operation: conditions of the run
    :param atmospheric_pressure: [Pa]
    :param stroke: [m]
    :param noise: of the readings
    :param span: of the sensors
    :param missing: balance -> what is missing to compare it, '' where it is open
    :param force: of a bench that moves the piston, along the outstroke [N], shape (n,); None for a
        piston that is free
    :param force_offset: standard deviation of the zero of that force [N]
    :param clock_offset: of the delay of the pressures against all else [s], 0 where there is none
    :param temperature_offset: of the gas at the start from the supply temperature [K]
    :param late: delay that the pressures have been put right by [s]
    :param temperatures: of the gas in both chambers when the recording began [K], None for the
        supply's
    :param compressed: pressures at the first sample in those when the recording began [-]: in so
        short a time the gas takes no heat
    :param recorded: the whole run with its pressures as recorded, None where it is this one
    """

    name: str
    interval: float
    position: Floats
    pressures: Floats
    voltages: Floats
    operation: Operation
    atmospheric_pressure: float
    stroke: float
    noise: Noise
    span: Span
    missing: Mapping[str, str]
    force: Floats | None = None
    force_offset: float = 0.0
    clock_offset: float = 0.0
    temperature_offset: float = 0.0
    late: float = 0.0
    temperatures: tuple[float, float] | None = None
    compressed: tuple[float, float] = (1.0, 1.0)
    recorded: Run | None = None

    @property
    def balances(self) -> frozenset[str]:
        """Balances that can be compared: of gas_1, gas_2, force."""
        return frozenset(name for name, missing in self.missing.items() if not missing)

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.position.size

    @property
    def time(self) -> Floats:
        """Middles of the intervals [s], shape (n - 1,)."""
        middles: Floats = (np.arange(self.size - 1, dtype=np.float64) + 0.5) * self.interval
        return middles

    @cached_property
    def _speed_and_rests(self) -> tuple[Floats, list[Rest]]:
        noise = self.noise.position
        if noise <= 0.0:  # it does not move
            return np.zeros(self.size), [Rest(0, self.size)]
        rests = find_rests(self.position, self.interval, noise)
        fine = FINE * window_for(self.interval, noise)
        return adaptive_velocity(self.position, self.interval, fine, noise), rests

    @property
    def rests(self) -> list[Rest]:
        """The rests, in the order of time."""
        return self._speed_and_rests[1]

    @cached_property
    def resting(self) -> Flags:
        """Whether the piston rests throughout an interval, shape (n - 1,)."""
        flags = np.zeros(self.size, dtype=np.bool_)
        for rest in self.rests:
            flags[rest.first : rest.end] = True
        both: Flags = np.logical_and(flags[1:], flags[:-1])
        return both

    @cached_property
    def velocity(self) -> Floats:
        """Velocity in each interval [m/s], 0 at rest, shape (n - 1,)."""
        velocity = self._speed_and_rests[0]
        return np.where(self.resting, 0.0, 0.5 * (velocity[1:] + velocity[:-1]))

    @cached_property
    def smooth(self) -> Floats:
        """Position [m] and pressures [Pa] without most of their noise, shape (n, 3)."""
        size = 2 * round(0.5 * SMOOTHING / self.interval) + 1
        columns = np.column_stack([self.position, self.pressures])
        if size >= 5:
            columns = savgol_filter(columns, size, 2, axis=0)
        for rest in self.rests:
            here = slice(rest.first, rest.end)
            columns[here, 0] = self.position[here].mean()
        for column, noise in ((1, self.noise.pressure_1), (2, self.noise.pressure_2)):
            columns[:, column] = unclipped(columns[:, column], self.span.low, noise)
        return columns

    @cached_property
    def contacts(self) -> NDArray[np.int64]:
        """What the piston does in each interval, see ``model.along``, shape (n - 1,)."""
        contacts = np.full(self.size - 1, along.MOVES, dtype=np.int64)
        if self.force is not None:  # the bench holds it, not the seal
            return contacts
        contacts[self.resting] = along.RESTS
        position = self.smooth[1:, 0]
        contacts[self.resting & (position < AT_STOP)] = along.AT_INNER_STOP
        outer = min(self.stroke, self.span.position) - AT_STOP
        contacts[self.resting & (position > outer)] = along.AT_OUTER_STOP
        return contacts

    @cached_property
    def position_known(self) -> Flags:
        """Intervals in which the position is not beyond its sensor's span, shape (n - 1,)."""
        known = self.position < self.span.position - CLIPPED * self.noise.position
        both: Flags = np.logical_and(known[1:], known[:-1])
        return both

    def pressure_known(self, chamber: int) -> Flags:
        """Intervals in which noise of a pressure is not cut off by its span, shape (n - 1,)."""
        noise = (self.noise.pressure_1, self.noise.pressure_2)[chamber - 1]
        values = self.pressures[:, chamber - 1]
        known = values > self.span.low + CLIPPED * noise
        known &= values < self.span.high - CLIPPED * noise
        both: Flags = np.logical_and(known[1:], known[:-1])
        return both

    @cached_property
    def slides(self) -> Flags:
        """Intervals in which the piston moves, and not onto an end stop, shape (n - 1,)."""
        moves: Flags = np.equal(self.contacts, along.MOVES)
        if self.force is not None:
            return moves
        stroke = self.contacts >= along.AT_INNER_STOP
        smeared, before = (round(time / self.interval) for time in (SMEARED, IMPACT))
        for rest in self.rests:
            ahead = before if stroke[min(rest.first, stroke.size - 1)] else smeared
            moves[max(rest.first - ahead, 0) : rest.end + smeared] = False
        return moves

    def started(self, operation: Operation) -> Operation:
        """Return an operation that begins as the run does, within the stroke."""
        x, p1, p2 = self.smooth[0].tolist()
        return operation._replace(
            initial_position=min(max(x, 0.0), self.stroke), initial_pressure_1=p1,
            initial_pressure_2=p2,
        )  # fmt: skip

    @property
    def has_errors(self) -> bool:
        """Whether the clock of the pressures or the temperature at the start may be off."""
        return self.clock_offset > 0.0 or self.temperature_offset > 0.0

    @property
    def margin(self) -> float:
        """Duration at either end for which a pressure that is late may not be known [s]."""
        return LATEST * self.clock_offset

    @property
    def begin(self) -> float:
        """Time of the first sample in the recording [s]."""
        return 0.0 if self.recorded is None else round(self.margin / self.interval) * self.interval

    def with_delay(self, late: float) -> Run:
        """
        Return the run if its pressures were recorded late [s], without ``margin`` at its ends.

        Its size does not depend on the delay.
        """
        whole = self.recorded or self
        time, cut = whole.interval * np.arange(whole.size), round(self.margin / whole.interval)
        inside, intervals = slice(cut, whole.size - cut), slice(cut, whole.size - 1 - cut)
        pressures = CubicSpline(time, whole.pressures)(time[inside] + late)
        known = whole.pressures[max(round(late / whole.interval), 0)]
        return replace(
            whole, position=whole.position[inside], pressures=pressures, late=late,
            compressed=(pressures[0, 0] / known[0], pressures[0, 1] / known[1]),
            temperatures=self.temperatures, voltages=whole.voltages[intervals], recorded=whole,
            force=None if whole.force is None else whole.force[inside],
        )  # fmt: skip

    def gas_temperatures(self, gas: Gas) -> tuple[float, float]:
        """Return those of the gas in both chambers at the first sample [K]."""
        supply = gas.supply_temperature
        power = 1.0 - 1.0 / gas.heat_capacity_ratio
        one, other = self.temperatures or (supply, supply)
        return one * self.compressed[0] ** power, other * self.compressed[1] ** power

    def read_again(self, position: Floats, pressures: Floats) -> Run:
        """Return the run with other readings."""
        return replace(self, position=position, pressures=pressures)


def positive_mean(ratio: Floats) -> Floats:
    """Return E max(y + n, 0) for values y and normal noise n of standard deviation 1."""
    near = np.clip(ratio, -40.0, 40.0)
    density = np.exp(-0.5 * near**2) / np.sqrt(2.0 * np.pi)
    mean: Floats = np.where(ratio < 40.0, near * ndtr(near) + density, ratio)
    return mean


def unclipped(means: Floats, low: float, noise: float) -> Floats:
    """Return what the means of readings are that show nothing below ``low``, shape (n,)."""
    if low <= 0.0 or noise <= 0.0:
        return means
    true = np.linspace(0.0, CLIPPED, 200)
    ratio = (means - low) / noise
    known: Floats = low + noise * np.interp(ratio, positive_mean(true), true)
    return np.where(ratio < CLIPPED, known, means)
