"""
The rig around the plant: DAC and valve drive, sensors and ADC, configuration.

`Rig` is the whole: valve voltages in, what the data acquisition reads out, sample by sample.
"""

from dataclasses import dataclass

from pneu_rig_ros.model.plant import Plant, PlantState
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE
from pneu_rig_ros.rig.configuration import (
    RigConfiguration,
    configuration_from_yaml,
    load_configuration,
    override,
)
from pneu_rig_ros.rig.sensors import SensorSet

__all__ = ['Rig', 'RigConfiguration', 'Sample', 'configuration_from_yaml', 'load_configuration']


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
