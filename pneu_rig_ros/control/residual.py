"""Measured less predicted, the noise band it should stay in, and for how long it has not."""

from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

from pneu_rig_ros.control.observer import Measured
from pneu_rig_ros.model.plant import PlantState
from pneu_rig_ros.rig.sensors import Sensors, sensor_noise

SIGNALS = ('position', 'pressure_1', 'pressure_2')


class Residual(NamedTuple):
    """Measured less predicted: [m], [Pa], [Pa]."""

    position: float
    pressure_1: float
    pressure_2: float


def residual(measured: Measured, predicted: PlantState) -> Residual:
    """Return measured less predicted."""
    return Residual(
        measured.position - predicted.position,
        measured.pressure_1 - predicted.pressure_1,
        measured.pressure_2 - predicted.pressure_2,
    )


class NoiseBand:
    """
    How far a residual may be from 0 by noise, quantisation and accuracy class of the sensors.

    The class counts for what has changed since the model was restarted from the measurement.

    :param sensors: data of the sensors
    :param multiple: of the standard deviation of a reading [-]
    """

    def __init__(self, sensors: Sensors, multiple: float) -> None:
        position, pressure = sensor_noise(sensors)
        self._noise = [multiple * level for level in (position, pressure, pressure)]
        self._classes = (
            sensors.position_class, sensors.pressure_class, sensors.pressure_class
        )  # fmt: skip

    def outside(self, left: Residual, measured: Measured, origin: Measured) -> list[bool]:
        """
        Return for each signal whether its residual is outside.

        :param left: the residual
        :param measured: the sample
        :param origin: what the model was restarted from
        """
        rows = zip(left, measured, origin, self._noise, self._classes, strict=True)
        return [abs(r) > noise + share * abs(y - y0) for r, y, y0, noise, share in rows]


class Watch:
    """
    Counts for how large a share of the last samples each signal was outside.

    :param samples: how many samples count
    """

    def __init__(self, samples: int) -> None:
        self._samples = samples
        self._history: deque[list[bool]] = deque()
        self._counts = [0] * len(SIGNALS)

    def note(self, outside: list[bool]) -> None:
        """Note the next sample."""
        self._history.append(outside)
        self._add(outside, 1)
        if len(self._history) > self._samples:
            self._add(self._history.popleft(), -1)

    def _add(self, outside: list[bool], sign: int) -> None:
        for index, out in enumerate(outside):
            self._counts[index] += sign * out

    def shares(self) -> Mapping[str, float]:
        """Return signal -> share of samples outside [-], of as many as a full window has."""
        return {
            name: count / self._samples for name, count in zip(SIGNALS, self._counts, strict=True)
        }
