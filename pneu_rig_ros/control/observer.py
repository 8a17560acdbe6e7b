"""
A model that runs beside a rig with the same valve voltages, and its prediction errors.

It is reset to the measurement when the measured piston comes to rest, and after each ``horizon``
of sliding; docs/shadow.md says why, and which states are set. What cannot be measured - film,
dwell clock, states of the effects - is carried on. Measurements are averaged over 50 ms, so that
noise is not fed into the model.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.motion import REST_SPEED
from pneu_rig_ros.analysis.velocity import NOISE, WINDOW, window_for
from pneu_rig_ros.model.plant import Plant, PlantState
from pneu_rig_ros.model.run import Impose
from pneu_rig_ros.rig.configuration import RigConfiguration, override
from pneu_rig_ros.rig.sensors import Sensors, sensor_noise

HORIZON = 1.0
"""Default longest prediction of a piston that does not come to rest [s]."""

MEAN = 0.05
"""Length of each of the two means with the noise of the rig's sensor [s]."""

MOTION = 3.0
"""A piston faster than this multiple of the speed of rest moves [-]."""


class RestDetector:
    """
    Detects rest and breakaway, sample by sample; the piston counts as resting until it moves.

    The only causal detector, as ``analysis.motion`` is the only one that knows what comes next. At
    an end stop the piston rests like anywhere else: no live part asks what holds it.

    The speed is the difference of two successive means of the position. Motion needs three times
    the speed of rest, so that noise ends no rest.

    :param interval: sampling interval [s]
    :param noise: standard deviation of a measured position [m]; with more than the rig's the means
        get longer
    """

    def __init__(self, interval: float, noise: float = NOISE) -> None:
        self.size = max(2, round(MEAN * window_for(interval, noise) / WINDOW / interval))
        self._interval = interval
        self._positions: deque[float] = deque(maxlen=2 * self.size)
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self._positions.clear()
        self._older = self._newer = 0.0
        self.resting = True
        self.broke_away = False
        """Whether a rest ended with the last sample."""

    def push(self, position: float) -> float | None:
        """Take the next position [m]; return the speed [m/s] as soon as both means are full."""
        positions, size = self._positions, self.size
        if len(positions) == 2 * size:
            self._older += positions[size] - positions[0]
            self._newer += position - positions[size]
            positions.append(position)
        else:
            positions.append(position)
            if len(positions) < 2 * size:
                return None
            self._older = sum(list(positions)[:size])
            self._newer = sum(list(positions)[size:])
        rested = self.resting
        speed = abs(self._newer - self._older) / (size * size * self._interval)
        if speed < REST_SPEED:
            self.resting = True
        elif speed > MOTION * REST_SPEED:
            self.resting = False
        self.broke_away = rested and not self.resting
        return speed


class Measured(NamedTuple):
    """Position [m] and absolute pressures [Pa] of one sample, or of the difference of two."""

    position: float
    pressure_1: float
    pressure_2: float


class Observer:
    """
    The model beside the rig.

    :param configuration: the model; its sensors give the noise of the measurements
    :param horizon: longest prediction of a piston that does not come to rest [s]
    """

    def __init__(self, configuration: RigConfiguration, horizon: float = HORIZON) -> None:
        self.configuration = configuration
        self.restarts = 0
        self._interval = configuration.interval_ns * 1e-9
        self._horizon = horizon
        self._plant = Plant(configuration.model, configuration.effects)
        self._rest = RestDetector(self._interval, sensor_noise(configuration.sensors)[0])
        self._samples: deque[Measured] = deque(maxlen=self._rest.size)
        ages = self._interval * np.arange(1 - self._rest.size, 1)
        self._line_fit = np.linalg.pinv(np.column_stack([np.ones_like(ages), ages]))
        self.reset()
        # The first step loads compiled code: it is made before time counts.
        self._advance((0.0, 0.0))
        self._plant.reset()
        self.reset()

    def reset(self) -> None:
        """Forget the rig: wait for its next rest."""
        self._rest.reset()
        self._samples.clear()
        self.running = False
        """Whether there is a prediction."""
        self._fastest = 0.0
        self._sliding = math.inf
        self._held = math.inf
        self._slide = 0.0
        self._since_restart = 0.0
        self._action = 0
        self.origin = (0.0, 0.0, 0.0, 0.0)
        """What the model was restarted from last: x [m], v [m/s], p1, p2 [Pa]."""

    def change_operation(self, **changes: float) -> None:
        """Change supply pressure [Pa] or load [kg]; RigError when out of range."""
        self.configuration = override(self.configuration, changes)
        self._plant.change_operation(**changes)

    def push(self, voltages: tuple[float, float], measured: Measured) -> PlantState | None:
        """
        Take the next sample; return the model's state at the same time, if it runs.

        :param voltages: u1, u2 [V] held since the sample before
        """
        state = self._advance(voltages) if self.running else None
        rested = self._rest.resting
        self._samples.append(measured)
        speed = self._rest.push(measured.position)
        if speed is not None:
            self._compare(speed, rested)
        return state

    def _advance(self, voltages: tuple[float, float]) -> PlantState:
        """Simulate one sampling interval, from the measured state where one is imposed."""
        self._plant.run_imposed(
            np.array([voltages]),
            self._interval,
            np.array([self._action]),
            np.array([self.origin]),
            np.array([self._slide]),
        )
        self._action = Impose.RELEASE if self._action & Impose.MOTION else 0
        self._since_restart += self._interval
        state = self._plant.state
        self._held = self._held + self._interval if state.sticking else 0.0
        return state

    def _compare(self, speed: float, rested: bool) -> None:
        """Decide whether the model restarts; ``rested``: the piston did before this sample."""
        came_to_rest = speed < REST_SPEED and not (rested and self.running)
        if self._rest.broke_away:
            self._fastest, self._sliding = speed, 0.0
        self._fastest = max(speed, self._fastest)
        self._sliding += self._interval
        if came_to_rest:
            slipped = self._fastest > self.configuration.model.friction.start_velocity
            missed = slipped and self._held > self._sliding
            self._slide = self._plant.state.time - self._sliding if missed else 0.0
            self._restart(Impose.HOLD | (Impose.BREAK if missed else 0))
        elif (
            self.running
            and not self._rest.resting
            and min(self._sliding, self._since_restart) >= self._horizon
        ):
            self._restart(Impose.MOTION | Impose.PRESSURES)

    def _restart(self, action: int) -> None:
        """Impose the measured state on the next step: with little noise, by line fits."""
        (x, p1, p2), (v, _, _) = (self._line_fit @ np.array(self._samples)).tolist()
        self.origin = x, v, p1, p2
        self._action, self.running, self._since_restart = action, True, 0.0
        self.restarts += 1


def residual(measured: Measured, predicted: PlantState) -> Measured:
    """Return measured minus predicted."""
    return Measured(
        measured.position - predicted.position,
        measured.pressure_1 - predicted.pressure_1,
        measured.pressure_2 - predicted.pressure_2,
    )


class NoiseBand:
    """
    Largest residual explained by noise, quantisation and accuracy class of the sensors.

    The accuracy class applies to the change since the model was reset to the measurement.

    :param multiple: of the standard deviation of a reading [-]
    """

    def __init__(self, sensors: Sensors, multiple: float) -> None:
        position, pressure = sensor_noise(sensors)
        self._noise = [multiple * level for level in (position, pressure, pressure)]
        self._classes = (sensors.position_class, sensors.pressure_class, sensors.pressure_class)

    def outside(self, left: Measured, measured: Measured, origin: Measured) -> list[bool]:
        """
        Return for each signal whether its residual is outside.

        :param left: the residual
        :param measured: the sample
        :param origin: what the model was restarted from
        """
        rows = zip(left, measured, origin, self._noise, self._classes, strict=True)
        return [abs(r) > noise + share * abs(y - y0) for r, y, y0, noise, share in rows]


class Watch:
    """Share of the last ``samples`` samples in which each signal was outside its noise band."""

    def __init__(self, samples: int) -> None:
        self._outside = np.zeros((samples, len(Measured._fields)), dtype=np.bool_)
        self._next = 0

    def note(self, outside: list[bool]) -> None:
        """Note the next sample in the place of the oldest."""
        self._outside[self._next] = outside
        self._next = (self._next + 1) % len(self._outside)

    def shares(self) -> dict[str, float]:
        """Return signal -> share of samples outside [-], of as many as a full window has."""
        return dict(zip(Measured._fields, self._outside.mean(axis=0).tolist(), strict=True))
