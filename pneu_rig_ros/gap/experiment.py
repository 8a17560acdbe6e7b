"""A measured run, prepared for comparison: its rests, its smoothed motion, its noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from pneu_rig_ros.analysis.friction import CUTOFF
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.noise import configured_noise, mean_noise, reading_noise
from pneu_rig_ros.model.parameters import Operation
from pneu_rig_ros.records import Record
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.sensors import Sensors

Floats = NDArray[np.float64]

BLOCK = 0.029
"""Length of the means that are compared [s]."""
REST_SPEED = 1.5e-3
"""A piston slower than this rests, unless the noise asks for more [m/s]."""
REST_WINDOW = 0.046
"""Length of the line fits that give the speed [s]."""
LEAST_REST = 0.1
"""A rest is at least this long [s]."""
LEAST_SLIDE, SLIDE_SPEED = 1e-3, 6e-3
"""Rests less far apart, with no faster motion between them, are one with creep in it [m, m/s]."""
SETTLING = 0.03
"""From the beginning of a rest to the readings that a restart is made of [s]."""
READING = 0.04
"""Length of the readings that a restart is made of [s]."""
FIRST_READING = 0.012
"""Length of the readings that the start is made of: the piston may move at once [s]."""
SMOOTHING = 0.017
"""Window of the cubic fits that smooth the measured position [s]."""
SATURATED = 2.0
"""A pressure this close to the zero of its sensor may be any below it [noises]."""
LEAST_DURATION = 1.0
"""A shorter run says nothing [s]."""
SLOWEST = 0.5 / CUTOFF
"""Interval of samples from which on they do not show when the piston breaks away [s]."""


@dataclass(frozen=True)
class Rest:
    """
    A stretch in which the piston rests, in samples.

    :param start: first sample
    :param end: one after the last
    :param restart: sample from which a prediction starts again
    :param readings: x, v = 0, p1, p2 there [SI]; NaN for a pressure that may be below the zero
        of its sensor
    """

    start: int
    end: int
    restart: int
    readings: tuple[float, float, float, float]


@dataclass(frozen=True)
class Experiment:
    """
    A measured run under known conditions.

    :param name: of the bag
    :param record: the signals
    :param operation: supply, load and rest before the run; where the piston starts
    :param atmospheric_pressure: [Pa]
    :param sensors: of the rig
    """

    name: str
    record: Record
    operation: Operation
    atmospheric_pressure: float
    sensors: Sensors

    @classmethod
    def of(cls, name: str, record: Record, configuration: RigConfiguration) -> Experiment:
        """
        Return the run of a record under a configuration whose conditions are those of it.

        :raises RigError: when it is too short, or sampled too slowly
        """
        _check(name, record)
        model, sensors = configuration.model, configuration.sensors
        zero = model.gas.atmospheric_pressure
        return cls(name, record, model.operation, zero, sensors).started(model.cylinder.stroke)

    def started(self, stroke: float) -> Experiment:
        """Return the run from the start that its first readings say, within the stroke [m]."""
        r, zero, sensors = self.record, self.zero, self.sensors
        first = slice(0, max(2, round(FIRST_READING / r.interval)))
        operation = self.operation._replace(
            initial_position=min(max(_line_at(r.position[first], 0), 0.0), stroke),
            initial_pressure_1=_at_start(r.pressure_1[first], zero, sensors),
            initial_pressure_2=_at_start(r.pressure_2[first], zero, sensors),
        )
        return replace(self, operation=operation)

    def calibrated(self, gains: tuple[float, float, float]) -> Experiment:
        """Return the run as sensors without errors of gain would have read it."""
        if gains == (1.0, 1.0, 1.0):
            return self
        if gains not in self._calibrated:
            self._calibrated.clear()
            self._calibrated[gains] = self._scaled(*gains)
        return self._calibrated[gains]

    @cached_property
    def _calibrated(self) -> dict[tuple[float, float, float], Experiment]:
        return {}

    def _scaled(self, x: float, p1: float, p2: float) -> Experiment:
        r, start, zero = self.record, self.operation, self.zero
        record = replace(
            r, position=r.position / x, pressure_1=zero + (r.pressure_1 - zero) / p1,
            pressure_2=zero + (r.pressure_2 - zero) / p2,
        )  # fmt: skip
        operation = start._replace(
            initial_position=start.initial_position / x,
            initial_pressure_1=zero + (start.initial_pressure_1 - zero) / p1,
            initial_pressure_2=zero + (start.initial_pressure_2 - zero) / p2,
        )
        # its end of the span is where the sensor's was
        sensors = self.sensors._replace(position_span=self.sensors.position_span / x)
        return replace(self, record=record, operation=operation, sensors=sensors)

    @property
    def interval(self) -> float:
        """Sampling interval [s]."""
        return self.record.interval

    @cached_property
    def measured(self) -> Floats:
        """Position [m], smoothed velocity [m/s], p1, p2 [Pa], shape (n, 4)."""
        r = self.record
        velocity = np.gradient(self.smooth_position, self.interval)
        return np.column_stack([r.position, velocity, r.pressure_1, r.pressure_2])

    @cached_property
    def smooth_position(self) -> Floats:
        """Position without most of its noise [m], shape (n,)."""
        size = 2 * round(0.5 * SMOOTHING * self._roughness / self.interval) + 1
        smooth: Floats = savgol_filter(self.record.position, max(size, 5), 3)
        return smooth

    @property
    def _roughness(self) -> float:
        """How much wider noise beyond the data sheet makes the windows [-]."""
        return float((self.noise[0] / configured_noise(self.sensors)[0]) ** 0.4)

    @cached_property
    def voltages(self) -> Floats:
        """u1, u2 from each sample but the last to the next [V], shape (n - 1, 2)."""
        return np.column_stack([self.record.voltage_1, self.record.voltage_2])[:-1]

    @cached_property
    def noise(self) -> tuple[float, float, float]:
        """Standard deviation of a reading of x [m], p1, p2 [Pa]."""
        position, pressure = configured_noise(self.sensors)
        r = self.record
        return (
            reading_noise(r.position, position),
            reading_noise(r.pressure_1, pressure),
            reading_noise(r.pressure_2, pressure),
        )

    @property
    def zero(self) -> float:
        """Lowest pressure that the sensors read, that of the surroundings [Pa]."""
        return self.atmospheric_pressure

    @cached_property
    def beyond_span(self) -> NDArray[np.bool_]:
        """Where the piston is farther out than its sensor reads, or just as far, shape (n,)."""
        last: NDArray[np.bool_] = self.record.position > self.sensors.position_span - self.codes[0]
        return last

    @property
    def codes(self) -> tuple[float, float, float]:
        """Step of the converter in x [m], p1, p2 [Pa]."""
        last = 2.0**self.sensors.resolution - 1.0
        pressure = self.sensors.pressure_span / last
        return self.sensors.position_span / last, pressure, pressure

    @cached_property
    def block(self) -> int:
        """Samples of the means that are compared."""
        return max(1, round(BLOCK / self.interval))

    @cached_property
    def floor(self) -> Floats:
        """Standard deviation of a block's mean of x [m], p1, p2 [Pa], shape (3,)."""
        pairs = zip(self.noise, self.codes, strict=True)
        return np.array([mean_noise(noise, step, self.block) for noise, step in pairs])

    @cached_property
    def speed(self) -> Floats:
        """|v| by line fits [m/s], shape (n,)."""
        return np.abs(velocity_of(self.record.position, self.interval, self._rest_window))

    @property
    def _rest_window(self) -> float:
        return REST_WINDOW * self._roughness

    @cached_property
    def rests(self) -> Sequence[Rest]:
        """The rests, in the order of time."""
        samples = self._rest_window / self.interval
        noise = self.noise[0] / self.interval * np.sqrt(12.0 / samples**3)
        pairs = slow_stretches(self.speed, max(REST_SPEED, 4.0 * noise))
        long = [(a, b) for a, b in pairs if b - a >= LEAST_REST / self.interval]
        return [self._rest(a, b) for a, b in self._without_creep(long)]

    def _without_creep(self, stretches: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
        """Return rests that a slide divides: creep before a breakaway belongs to the rest."""
        joined: list[tuple[int, int]] = []
        for start, end in stretches:
            if joined and not self._slides(joined[-1][1], start):
                joined[-1] = joined[-1][0], end
            else:
                joined.append((start, end))
        return joined

    def _slides(self, end: int, start: int) -> bool:
        """Return whether the piston slides from the end of a rest to the start of the next."""
        way = self.smooth_position[start] - self.smooth_position[end - 1]
        return bool(abs(way) > LEAST_SLIDE or self.speed[end:start].max() > SLIDE_SPEED)

    def _rest(self, start: int, end: int) -> Rest:
        first = 0 if start == 0 else start + round(SETTLING / self.interval)
        last = min(first + round(READING / self.interval), end)
        restart = first if start == 0 else (first + last) // 2
        window = slice(first, last)
        position = float(self.record.position[window].mean())
        pressures = (
            _line_at(signal[window], restart - first)
            for signal in (self.record.pressure_1, self.record.pressure_2)
        )
        known = [
            p if p > self.zero + SATURATED * noise else math.nan
            for p, noise in zip(pressures, self.noise[1:], strict=True)
        ]
        return Rest(start, end, restart, (position, 0.0, known[0], known[1]))


def slow_stretches(speed: Floats, limit: float) -> list[tuple[int, int]]:
    """
    Return first sample and one after the last of stretches below a speed [m/s].

    What gets faster in between than the limit, but not than twice of it, belongs to the stretch.
    """
    slow = np.flatnonzero(speed < limit)
    if not slow.size:
        return []
    broken = np.concatenate([[0], np.cumsum(speed > 2.0 * limit)])[slow]
    parts = np.split(slow, np.flatnonzero(np.diff(broken)) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _check(name: str, record: Record) -> None:
    if record.duration < LEAST_DURATION:
        raise RigError(f'{name}: {record.duration:.2f} s, at least {LEAST_DURATION:g} s needed')
    if record.interval >= SLOWEST:
        raise RigError(
            f'{name}: a sample every {1e3 * record.interval:g} ms, less than {1e3 * SLOWEST:g} ms '
            'needed to see the piston break away; a part of the rig alone may do (--part)'
        )


def _at_start(readings: Floats, outside: float, sensors: Sensors) -> float:
    """Return the pressure of the first reading [Pa]; next to that outside it is that."""
    pressure, noise = _line_at(readings, 0), configured_noise(sensors)[1]
    return outside if abs(pressure - outside) < SATURATED * noise else pressure


def _line_at(values: Floats, sample: int) -> float:
    """Return the value at a sample of the straight line through some values."""
    index = np.arange(values.size)
    slope, offset = np.polyfit(index, values, 1)
    return float(offset + slope * sample)
