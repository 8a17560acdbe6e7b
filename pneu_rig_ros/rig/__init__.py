"""The rig around the plant: DAC and valve drive, sensors and ADC, configuration."""

from pneu_rig_ros.rig.configuration import (
    RigConfiguration,
    configuration_from_yaml,
    load_configuration,
)
from pneu_rig_ros.rig.emulator import Rig, Sample

__all__ = ['Rig', 'RigConfiguration', 'Sample', 'configuration_from_yaml', 'load_configuration']
