"""
What the systems other than a whole rig have in common.

A system is drawn in its sizes, something is hidden in it, and its recordings are made by the
second plant's equations under motions, pressures and voltages that are drawn too.
"""

import zlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.scenarios.hidden import LAWS, Secret, hide

from . import constants as at
from .constants import HIDDEN
from .imposed import CENTRE, Path, gas_run
from .runs import Noise, Run, equations
from .sensors import LEVELS
from .settings import Settings, changed, operation

FIT, VERIFY = 3, 2
"""Recordings of each kind."""
PRESSURE_SPAN, ATMOSPHERE = 1e6, 1e5
"""Of the pressure sensors, gauge, and what they count from [Pa]."""
PRESSURE_NOISE = 150.0
"""Standard deviation [Pa]."""
NOISE_OF_SPAN = 7e-5
"""Standard deviation of a position sensor, share of its span [-]."""


class Sensor(NamedTuple):
    """A sensor with a 12-bit converter: reads from ``zero`` on over its span."""

    zero: float
    span: float
    noise: float

    @property
    def deviation(self) -> float:
        """Standard deviation of a reading, rounding included."""
        return float(np.hypot(self.noise, self.span / LEVELS / 12.0**0.5))

    def read(self, true: np.ndarray, random: Generator) -> np.ndarray:
        """Return the readings of a signal."""
        noisy = true - self.zero + self.noise * random.standard_normal(true.shape)
        step = self.span / LEVELS
        return self.zero + np.round(np.clip(noisy, 0.0, self.span) / step) * step


PRESSURE = Sensor(ATMOSPHERE, PRESSURE_SPAN, PRESSURE_NOISE)


def wrong(name: str, grade: float, model: Settings) -> Secret:
    """Return the secret that a parameter of the model is 10 to 30 % too small, by its grade."""
    section, key = name.split('.')
    return Secret({}, {name: (1.1 + 0.1 * grade) * model[section][key]}, {})


class System(NamedTuple):
    """
    A kind of system.

    :param balances: that are open
    :param hidden: what can be hidden in it: effects, or parameters as section.name
    :param sizes: draws the settings of its model
    :param strengths: (grade 0 to 2, settings of the model) -> effect -> its parameters
    :param runs: (settings of the truth, of the model, what is hidden, random) -> recordings;
        what is drawn hangs on the model alone
    :param sensors: settings -> signal that is recorded -> its sensor
    :param keys: section -> keys of the settings that the model file has
    :param more: what else the model file has
    :param bag: whether it is recorded in bags, not in text tables
    :param wrong: (name, grade, settings of the model) -> what hides a wrong parameter
    """

    name: str
    balances: tuple[str, ...]
    hidden: tuple[str, ...]
    sizes: Callable[[Generator], Settings]
    strengths: Callable[[float, Settings], dict[str, dict[str, float]]]
    runs: Callable[[Settings, Settings, Mapping[str, float], Generator], list[Run]]
    sensors: Callable[[Settings], dict[str, Sensor]]
    keys: Mapping[str, tuple[str, ...]]
    more: Mapping[str, Any]
    bag: bool = False
    wrong: Callable[[str, float, Settings], Secret] = wrong

    def hide(self, name: str, grade: float, model: Settings) -> Secret:
        """Return what is hidden: an effect, or a wrong parameter, at a grade from 0 to 2."""
        if '.' in name:
            return self.wrong(name, grade, model)
        if name in LAWS:
            return hide(name, 'cylinder_1', grade, model['friction'])
        return Secret({name: self.strengths(grade, model)[name]}, {}, {})


GAS_KEYS = ('atmospheric_pressure', 'supply_temperature', 'heat_capacity_ratio', 'gas_constant')
CYLINDER_KEYS = ('cap_area', 'rod_area', 'cap_dead_volume', 'rod_dead_volume', 'stroke')


def stream(key: str, number: int) -> Generator:
    """Return a source of random numbers of a trial; each number another one."""
    return np.random.default_rng([zlib.crc32(key.encode()), number])


def log_graded(grade: float, weak: float, strong: float) -> float:
    """Return a strength between weak, at 0, and strong, at 2, on a logarithmic scale."""
    return float(weak * (strong / weak) ** (0.5 * grade))


def log_uniform(random: Generator, low: float, high: float) -> float:
    """Draw a size."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def names() -> list[str]:
    """Return what the recordings of a system are called."""
    return [f'fit_{i + 1}' for i in range(FIT)] + [f'verify_{i + 1}' for i in range(VERIFY)]


def gas_recording(
    name: str,
    true: Settings,
    model: Settings,
    hidden: Mapping[str, float],
    path: Path,
    start: dict[str, float],
    duration: float,
    rate: float,
    temperature: float | None = None,
    voltages: np.ndarray | None = None,
) -> Run:
    """Return a recording of gas behind a piston on a path, with the valves shut if not said."""
    prepared = [changed(one, operation(start)) for one in (true, model)]
    inside = {name: value for name, value in hidden.items() if name in HIDDEN}
    errors = {name: value for name, value in hidden.items() if name not in HIDDEN}
    if voltages is None:
        voltages = np.full((round(duration * rate), 2), CENTRE)
    states = gas_run(prepared[0], inside, path, voltages, 1.0 / rate, temperature)
    moves = bool(np.ptp(states[:, at.X]))
    noise = Noise(moves * position_sensor(model).deviation, PRESSURE.deviation)
    return Run(
        name,
        1.0 / rate,
        states,
        np.ones(len(states), dtype=bool),
        np.vstack([voltages, voltages[-1:]]),
        equations(prepared[0], inside),
        equations(prepared[1], {}),
        errors,
        noise,
    )


def position_sensor(model: Settings) -> Sensor:
    """Return a sensor that spans the stroke."""
    stroke = model['cylinder']['stroke']
    return Sensor(0.0, stroke, NOISE_OF_SPAN * stroke)
