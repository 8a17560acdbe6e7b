"""
The rig around the plant: DAC and valve drive, sensors and ADC, configuration.

`Rig` is the whole: valve voltages in, what the data acquisition reads out, sample by sample.
"""

import math
from dataclasses import dataclass

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.plant import Plant, PlantState
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE, FULL_VOLTAGE, control_voltages
from pneu_rig_ros.rig.configuration import (
    RigConfiguration,
    configuration_from_yaml,
    load_configuration,
    override,
)
from pneu_rig_ros.rig.sensors import SensorSet

__all__ = [
    'DAC_STEP',
    'LARGEST_COMMAND',
    'Rig',
    'RigConfiguration',
    'Sample',
    'checked_command',
    'configuration_from_yaml',
    'load_configuration',
    'valve_voltages',
    'voltages_of',
]

DAC_STEP = FULL_VOLTAGE / 4095
"""Step of the 12-bit DAC [V]."""

LARGEST_COMMAND = 1000.0
"""
Largest |u| that a controller can mean [V].

2.5 V open a valve fully, and a stiff controller asks for some hundred, which saturate. More than
this is an overflow or another unit.
"""


def checked_command(u: float) -> float:
    """Return the command u [V]; ValueError unless finite and at most ``LARGEST_COMMAND``."""
    valve_voltages(u)
    if abs(u) > LARGEST_COMMAND:
        limit = f'{LARGEST_COMMAND:g}'
        raise ValueError(f'u is {u:g} V, allowed are -{limit} to {limit} V')
    return u


def valve_voltages(u: float) -> tuple[float, float]:
    """
    Return u1, u2 [V] for the command u [V]: Eq. 1, saturated to 0-5 V, in steps of the DAC.

    :raises ValueError: unless u is finite
    """
    if not math.isfinite(u):
        raise ValueError(f'u is {u}, allowed are finite voltages')
    voltage_1, voltage_2 = control_voltages(u)
    return _dac(voltage_1), _dac(voltage_2)


def _dac(voltage: float) -> float:
    saturated = min(max(voltage, 0.0), FULL_VOLTAGE)
    return round(saturated / DAC_STEP) * DAC_STEP


def voltages_of(u: Floats) -> tuple[Floats, Floats]:
    """Return u1, u2 as ``valve_voltages`` for each of many finite u [V], shape (n,) each."""
    saturated = np.clip([CENTRE_VOLTAGE + u, CENTRE_VOLTAGE - u], 0.0, FULL_VOLTAGE)
    voltage_1, voltage_2 = np.round(saturated / DAC_STEP) * DAC_STEP
    return voltage_1, voltage_2


@dataclass(frozen=True, slots=True)
class Sample:
    """What the data acquisition reads at one sampling instant; absolute pressures."""

    index: int
    position: float
    velocity: float
    pressure_1: float
    pressure_2: float


class Rig:
    """
    Plant and sensors, stepped at the sampling interval.

    :param configuration: what the rig is
    """

    def __init__(self, configuration: RigConfiguration) -> None:
        self.configuration = configuration
        self.interval = configuration.interval_ns * 1e-9
        self._plant = Plant(configuration.model, configuration.effects)
        gas = configuration.model.gas
        self.sensors = SensorSet(
            configuration.sensors, gas.atmospheric_pressure, self.interval, configuration.seed
        )
        self.reset()

    def reset(self) -> Sample:
        """Go back to rest and restart the noise; return the sample of index 0."""
        self.sensors.reset()
        return self._measure(0, self._plant.reset())

    def warm_up(self) -> None:
        """Make one step before time counts: the first one compiles the plant, or loads it."""
        self.step(CENTRE_VOLTAGE, CENTRE_VOLTAGE)
        self.reset()

    def step(self, voltage_1: float, voltage_2: float) -> Sample:
        """Hold the valve voltages [V] for one interval; return the sample after it."""
        state = self._plant.step(voltage_1, voltage_2, self.interval)
        return self._measure(self.sample.index + 1, state)

    def change_operation(self, **changes: float) -> None:
        """Change supply pressure [Pa] or load [kg]; RigError when out of range."""
        self.configuration = override(self.configuration, changes)
        self._plant.change_operation(**changes)

    def _measure(self, index: int, state: PlantState) -> Sample:
        self.state = state
        """The true state at the present sample."""
        readings = self.sensors.read(
            state.position_reading,
            state.velocity_reading,
            state.pressure_1_reading,
            state.pressure_2_reading,
        )
        self.sample = Sample(index, *readings)
        """The present sample."""
        return self.sample
