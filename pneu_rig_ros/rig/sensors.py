"""Sensors of the rig: accuracy class, noise, 12-bit ADC, and the velocity made from positions."""

import math
from collections.abc import Iterable
from typing import Annotated, NamedTuple

import numpy as np

from pneu_rig_ros.model.quantity import Choice, Quantity

RIG, IDEAL = range(2)

LARGEST_CUTOFF = 0.45
"""Largest cutoff of a low-pass as a share of the sampling rate; half is the Nyquist limit [-]."""
NEAR_ZERO = 2.0
"""A pressure this close to its sensor's zero may be zero, or any below [standard deviations]."""


class Sensors(NamedTuple):
    """Position sensor, two pressure sensors and the converter (section 2.1 of the paper)."""

    kind: Annotated[int, Choice(('rig', 'ideal'), 'emulated sensors or the true values')]
    resolution: Annotated[float, Quantity('bit', 4.0, 32.0, 'resolution of the ADC')]
    position_span: Annotated[float, Quantity('m', 1e-3, 10.0, 'full scale, from 0')]
    position_class: Annotated[float, Quantity('-', 0.0, 0.1, 'accuracy, share of full scale')]
    position_noise: Annotated[float, Quantity('m', 0.0, 1e-2, 'standard deviation')]
    pressure_span: Annotated[float, Quantity('Pa', 1e4, 1e8, 'full scale, gauge, from 0')]
    pressure_class: Annotated[float, Quantity('-', 0.0, 0.1, 'accuracy, share of full scale')]
    pressure_noise: Annotated[float, Quantity('Pa', 0.0, 1e5, 'standard deviation')]
    velocity_cutoff: Annotated[float, Quantity('Hz', 0.1, 430.0, 'low-pass of the velocity')]


class Channel:
    """
    One analogue channel: gain error, noise, saturation, quantisation.

    The sensors are zeroed before an experiment, so that the accuracy class is an error of gain.

    :param span: full scale [unit of the signal]
    :param levels: number of codes of the converter
    :param noise: standard deviation [unit]
    :param gain: true slope of the sensor [-]
    """

    def __init__(self, span: float, levels: float, noise: float, gain: float = 1.0) -> None:
        self._span, self._gain, self._noise = span, gain, noise
        self._code = span / (levels - 1.0)
        self.variance = noise**2 + self._code**2 / 12.0
        self.saturated = False

    def read(self, value: float, noise: float) -> float:
        """Return the reading; ``noise`` is a standard normal deviate."""
        signal = self._gain * value + self._noise * noise
        inside = min(max(signal, 0.0), self._span)
        self.saturated = abs(signal - inside) > 4.0 * self._noise + self._code
        return round(inside / self._code) * self._code


def sensor_noise(sensors: Sensors) -> tuple[float, float]:
    """Return the standard deviation of a reading of position [m] and pressure [Pa]: data sheet."""
    position, pressure, _ = make_channels(sensors, (1.0, 1.0, 1.0))
    return math.sqrt(position.variance), math.sqrt(pressure.variance)


def make_channels(sensors: Sensors, gains: Iterable[float]) -> list[Channel]:
    """Return the channels of position, p1 and p2."""
    levels = 2.0**sensors.resolution
    position = sensors.position_span, levels, sensors.position_noise
    pressure = sensors.pressure_span, levels, sensors.pressure_noise
    sheets = position, pressure, pressure
    return [Channel(*sheet, gain) for sheet, gain in zip(sheets, gains, strict=True)]


def near_zero(pressure: float, zero: float, noise: float) -> bool:
    """Return whether noise may hide that a pressure is at the zero of its sensor, all in [Pa]."""
    return abs(pressure - zero) <= NEAR_ZERO * noise


def can_filter(cutoff: float, interval: float) -> bool:
    """Return whether a low-pass [Hz] is possible at a sampling interval [s]."""
    return cutoff * interval < LARGEST_CUTOFF


class SensorSet:
    """
    The rig's sensors, with the noise and the calibration that a seed stands for.

    The velocity is the differentiated position through a low-pass, without it where the sampling
    is too slow for one.

    :param atmospheric_pressure: the pressure sensors' zero [Pa]
    :param interval: sampling interval [s]
    """

    def __init__(
        self, sensors: Sensors, atmospheric_pressure: float, interval: float, seed: int
    ) -> None:
        self._ideal = sensors.kind == IDEAL
        self._zero = atmospheric_pressure
        self._seed = seed
        self._interval = interval
        self._filters = can_filter(sensors.velocity_cutoff, interval)
        # first-order low-pass by the bilinear transform, with a zero at half the sampling rate
        warped = math.tan(math.pi * sensors.velocity_cutoff * interval)
        self._pole = (1.0 - warped) / (1.0 + warped)
        calibration = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, 3)
        classes = sensors.position_class, sensors.pressure_class, sensors.pressure_class
        gains = (1.0 + c * u for c, u in zip(classes, calibration, strict=True))
        self._channels = make_channels(sensors, gains)
        self.reset()

    def reset(self) -> None:
        """Start the noise again from the seed."""
        self._noise = np.random.default_rng([self._seed, 2])
        self._block: list[list[float]] = []
        self._last_position: float | None = None
        self._last_slope = 0.0
        self._velocity = 0.0

    @property
    def pressure_variance(self) -> float:
        """Variance of a pressure reading [Pa^2]: noise and quantisation."""
        return 0.0 if self._ideal else self._channels[1].variance

    @property
    def saturated(self) -> bool:
        """Whether a sensor was out of its range at the last reading."""
        return any(channel.saturated for channel in self._channels)

    def read(
        self, position: float, velocity: float, pressure_1: float, pressure_2: float
    ) -> tuple[float, float, float, float]:
        """Return the readings of position, velocity, p1, p2 for their true values (SI)."""
        if self._ideal:
            return position, velocity, pressure_1, pressure_2
        if not self._block:
            self._block = self._noise.standard_normal((256, 3)).tolist()[::-1]
        values = position, pressure_1 - self._zero, pressure_2 - self._zero
        triples = zip(self._channels, values, self._block.pop(), strict=True)
        x, p1, p2 = (channel.read(value, noise) for channel, value, noise in triples)
        return x, self._differentiate(x), self._zero + p1, self._zero + p2

    def _differentiate(self, position: float) -> float:
        if self._last_position is None:
            self._last_position = position
        slope = (position - self._last_position) / self._interval
        if not self._filters:
            self._last_position = position
            return slope
        weight = 0.5 * (1.0 - self._pole)
        self._velocity = self._pole * self._velocity + weight * (slope + self._last_slope)
        self._last_position, self._last_slope = position, slope
        return self._velocity
