"""
A run: one recording, prepared for a comparison with a model.

Of position and pressures both the readings, whose noise is known, and smoothed signals, from which
the modelled rates are computed, are kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from pneu_rig_ros.analysis.motion import Rest, Sides, breakaways, end_stops, find_rests, rest_flags
from pneu_rig_ros.analysis.velocity import CUBIC, adaptive_velocity, imposed_velocity, window_for
from pneu_rig_ros.arrays import Flags, Floats, Integers
from pneu_rig_ros.diagnosis.measured.reading import (
    CLIPPED,
    Noise,
    Span,
    first_of,
    from_when,
    smoothed,
    unclipped,
)
from pneu_rig_ros.model import along
from pneu_rig_ros.model.parameters import Gas, Operation
from pneu_rig_ros.rig.sensors import near_zero

IMPACT = 0.1
"""Before it rests at an end stop the piston bounces, and its velocity is smeared [s]."""
SMEARED = 0.046
"""The fits of the velocity smear it after a breakaway and before a rest [s]."""
LARGEST_DELAY = 3.0
"""Largest delay of the pressures that is considered [standard deviations]."""


@dataclass(frozen=True)
class Run:
    """
    Signals of n samples of one recording.

    :param name: of the recording
    :param interval: [s]
    :param position: readings [m], shape (n,)
    :param pressures: readings of p1, p2, absolute [Pa], shape (n, 2)
    :param voltages: u1, u2 in each interval [V], shape (n - 1, 2)
    :param operation: conditions of the recording
    :param atmospheric_pressure: [Pa]
    :param stroke: [m]
    :param areas: of the piston at the cap and the rod end [m^2]
    :param noise: of the readings
    :param span: of the sensors
    :param missing: balance -> what is missing to compare it, '' where it is open
    :param force: of a bench that moves the piston, along the outstroke [N], shape (n,); None for a
        free piston
    :param force_zero_sd: standard deviation of the zero of that force [N]
    :param delay_sd: standard deviation of the delay of the pressures [s], 0 without one
    :param temperature_sd: standard deviation of the initial gas temperature [K]
    :param repeatability: balance -> standard deviation by which recordings of the system differ
        from its model [unit of the balance]
    :param level_sd: standard deviation of the level of friction in either direction [N]
    :param delay: by which the pressures were shifted [s]
    :param temperatures: of the gas in both chambers when the recording began [K], None for the
        supply's
    :param compression: pressures at the first sample relative to those when the recording began
        [-]: in so short a time the gas takes no heat
    :param original: the whole run with its pressures as recorded, None where it is this one
    :param notes: remarks for the user
    """

    name: str
    interval: float
    position: Floats
    pressures: Floats
    voltages: Floats
    operation: Operation
    atmospheric_pressure: float
    stroke: float
    areas: tuple[float, float]
    noise: Noise
    span: Span
    missing: Mapping[str, str]
    force: Floats | None = None
    force_zero_sd: float = 0.0
    delay_sd: float = 0.0
    temperature_sd: float = 0.0
    repeatability: Mapping[str, float] = field(default_factory=dict)
    level_sd: float = 0.0
    delay: float = 0.0
    temperatures: tuple[float, float] | None = None
    compression: tuple[float, float] = (1.0, 1.0)
    original: Run | None = None
    notes: tuple[str, ...] = ()

    @property
    def balances(self) -> frozenset[str]:
        """Open balances, of gas_1, gas_2, force."""
        return frozenset(name for name, missing in self.missing.items() if not missing)

    @property
    def chambers(self) -> list[int]:
        """Chambers whose balance of gas is open, of 0 and 1."""
        return [i for i in (0, 1) if f'gas_{i + 1}' in self.balances]

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.position.size

    @property
    def time(self) -> Floats:
        """Middles of the intervals [s], shape (n - 1,)."""
        return (np.arange(self.size - 1, dtype=np.float64) + 0.5) * self.interval

    @cached_property
    def rests(self) -> list[Rest]:
        """The rests, in the order of time."""
        noise = self.noise.position
        if noise <= 0.0:  # a fixed piston
            return [Rest(0, self.size)]
        return find_rests(self.position, self.interval, noise)

    @cached_property
    def resting(self) -> Flags:
        """Whether the piston rests throughout an interval, shape (n - 1,)."""
        return at_both_ends(rest_flags(self.rests, self.size))

    @cached_property
    def velocity(self) -> Floats:
        """Velocity in each interval [m/s], 0 where a free piston rests, shape (n - 1,)."""
        noise = self.noise.position
        if noise <= 0.0:
            return np.zeros(self.size - 1)
        if self.force is not None:  # however slow a bench is, it deflects the seal
            return imposed_velocity(self.position, self.interval, noise)
        # slow sampling leaves fewer samples in that window than a cubic needs to smooth them
        shortest = max(window_for(self.interval, noise), (CUBIC + 2) * self.interval)
        velocity = adaptive_velocity(self.position, self.interval, shortest, noise, CUBIC)
        return np.where(self.resting, 0.0, 0.5 * (velocity[1:] + velocity[:-1]))

    @cached_property
    def smooth(self) -> Floats:
        """Position [m] and pressures [Pa] without most of their noise, shape (n, 3)."""
        columns = smoothed(np.column_stack([self.position, self.pressures]), self.interval)
        for rest in self.rests if self.force is None else ():
            columns[rest.first : rest.end, 0] = self.position[rest.first : rest.end].mean()
        for column, noise in enumerate(self.noise.pressures, start=1):
            columns[:, column] = unclipped(columns[:, column], self.span.low, noise)
        return columns

    @cached_property
    def sides(self) -> Sides:
        """
        The end stop that holds a free piston, see ``motion.end_stops``, shape (n,).

        By the pressures as recorded, so that their delay changes none. A fixed piston is held as
        by a stop, not by its seal.
        """
        if self.noise.position <= 0.0:
            return np.full(self.size, -1, dtype=np.int8)
        if self.original is not None:
            cut = round(self.begin / self.interval)
            return self.original.sides[cut : cut + self.size]
        gauge, (cap, rod) = self.pressures - self.atmospheric_pressure, self.areas
        push = gauge @ [cap, -rod] if 'force' in self.balances else None
        stroke = min(self.stroke, self.span.position)
        return end_stops(self.position, stroke, self.interval, push, self.noise.position)

    @cached_property
    def breakaways(self) -> list[Rest]:
        """The rests that end with a breakaway, in the order of time; a bench has none."""
        return breakaways(self.rests, self.sides, self.interval) if self.force is None else []

    @cached_property
    def contacts(self) -> Integers:
        """State of motion in each interval, see ``model.along``, shape (n - 1,)."""
        if self.force is not None:  # the bench holds the piston, not the seal
            return np.full(self.size - 1, along.MOVES, dtype=np.int64)
        first, last = self.sides[:-1], self.sides[1:]
        held = np.array([along.AT_INNER_STOP, along.RESTS, along.AT_OUTER_STOP])
        return np.where(self.resting, held[1 + np.where(first == last, first, 0)], along.MOVES)

    @cached_property
    def position_valid(self) -> Flags:
        """Intervals in which the position is within its sensor's span, shape (n - 1,)."""
        return at_both_ends(self.position < self.span.position - CLIPPED * self.noise.position)

    def pressure_valid(self, chamber: int) -> Flags:
        """Return the intervals in which the span cuts off no noise, shape (n - 1,)."""
        margin = CLIPPED * self.noise.pressures[chamber - 1]
        values = self.pressures[:, chamber - 1]
        return at_both_ends((values > self.span.low + margin) & (values < self.span.high - margin))

    @cached_property
    def vacuum(self) -> Flags:
        """
        Intervals in which a pressure may be any below its sensor's zero, shape (n - 1,).

        That is from when a chamber expands there until its pressure is read again. A bench says
        what moves the piston.
        """
        flags = np.zeros(self.size - 1, dtype=np.bool_)
        if self.force is not None:
            return flags
        for chamber, expanding in ((1, self.velocity > 0.0), (2, self.velocity < 0.0)):
            unread = ~self.pressure_valid(chamber)
            unread &= self.smooth[1:, chamber] < self.span.high / 2.0
            flags |= from_when(expanding, unread)
        return flags

    @cached_property
    def sliding(self) -> Flags:
        """Intervals in which the piston moves, and not onto an end stop, shape (n - 1,)."""
        moves: Flags = np.equal(self.contacts, along.MOVES)
        if self.force is not None:
            return moves
        smeared, impact = (round(time / self.interval) for time in (SMEARED, IMPACT))
        for rest in self.rests:
            before = impact if self.sides[rest.first : rest.end].any() else smeared
            moves[max(rest.first - before, 0) : rest.end + smeared] = False
        return moves

    @property
    def initial_operation(self) -> Operation:
        """
        The conditions with the state in which the run begins, within the stroke.

        What a sensor reads near its zero is a vented chamber: a few pascals more there are noise,
        and would move every later slip. The seal yields by some tenths of a millimetre during
        the first rest, so that the mean position in it is not where it began.
        """
        x = first_of(self.position, self.interval)
        p1, p2 = (
            self.span.low if self.near_zero(chamber, pressure) else pressure
            for chamber, pressure in enumerate(self.smooth[0, 1:].tolist(), start=1)
        )
        return self.operation._replace(
            initial_position=min(max(x, 0.0), self.stroke),
            initial_pressure_1=p1,
            initial_pressure_2=p2,
        )

    def near_zero(self, chamber: int, pressure: float) -> bool:
        """Return whether a pressure [Pa] is so near the zero of its sensor that noise hides it."""
        low = self.span.low  # a smoothed reading may be below
        return near_zero(max(pressure, low), low, self.noise.pressures[chamber - 1])

    @property
    def has_nuisances(self) -> bool:
        """Whether the clock of the pressures or the initial temperature may be off."""
        return self.delay_sd > 0.0 or self.temperature_sd > 0.0

    @property
    def margin(self) -> float:
        """Duration at either end where pressures that are late may not be recorded [s]."""
        return LARGEST_DELAY * self.delay_sd

    @property
    def begin(self) -> float:
        """Time of the first sample in the recording [s]."""
        return 0.0 if self.original is None else round(self.margin / self.interval) * self.interval

    def with_delay(self, delay: float) -> Run:
        """
        Return the run with its pressures shifted by a delay [s], without ``margin`` at its ends.

        Its size does not depend on the delay.
        """
        whole = self.original or self
        time, cut = whole.interval * np.arange(whole.size), round(self.margin / whole.interval)
        inside = slice(cut, whole.size - cut)
        pressures = CubicSpline(time, whole.pressures)(time[inside] + delay)
        first = whole.pressures[max(round(delay / whole.interval), 0)]
        return replace(
            whole,
            position=whole.position[inside],
            pressures=pressures,
            voltages=whole.voltages[cut : whole.size - 1 - cut],
            force=None if whole.force is None else whole.force[inside],
            delay=delay,
            temperatures=self.temperatures,
            compression=(pressures[0, 0] / first[0], pressures[0, 1] / first[1]),
            original=whole,
        )

    def gas_temperatures(self, gas: Gas) -> tuple[float, float]:
        """Return the gas temperatures of both chambers at the first sample [K]."""
        supply = gas.supply_temperature
        power = 1.0 - 1.0 / gas.heat_capacity_ratio
        first, second = self.temperatures or (supply, supply)
        return first * self.compression[0] ** power, second * self.compression[1] ** power

    def with_gains(self, gains: Sequence[float], offsets: Sequence[float]) -> Run:
        """
        Return the run as sensors without these errors read it.

        :param gains: slopes of the sensors of x, p1, p2 [-], shape (3,)
        :param offsets: what they read too much [m, Pa, Pa], shape (3,)
        """
        zero = np.array([0.0, self.atmospheric_pressure, self.atmospheric_pressure])
        read = zero + np.array(offsets)
        columns = zero + (np.column_stack([self.position, self.pressures]) - read) / gains
        scaled = self.with_readings(columns[:, 0], columns[:, 1:])
        # smoothing is linear, and rests are rests in any unit: neither is recomputed
        scaled.__dict__.update(rests=self.rests, smooth=zero + (self.smooth - read) / gains)
        return scaled

    def with_readings(self, position: Floats, pressures: Floats) -> Run:
        """Return the run with other readings."""
        return replace(self, position=position, pressures=pressures)


def at_both_ends(samples: Flags) -> Flags:
    """Return the intervals at both ends of which samples are flagged, shape (n - 1,)."""
    return samples[1:] & samples[:-1]
