"""Heat exchange between the gas and the cylinder wall by natural convection."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity

REFERENCE = 10.0
"""Difference of temperature at which the conductance is as stated [K]."""
SMALLEST = 1e-6
"""Least difference of temperature that drives the gas, as a share of it [-]: a power needs one."""


class Parameters(NamedTuple):
    """
    Conductance at 10 K between gas and wall, and the power of the difference with which it grows.

    The wall is at supply temperature. The power is that of Rayleigh's number in Nusselt's: 1/4 in
    laminar and 1/3 in turbulent convection, about 0.2 where it hardly begins. The growth of that
    number with the square of the gas's density is omitted.
    """

    conductance_1: Annotated[
        float, Quantity('W/K', 0.0, 100.0, 'conductance of chamber 1 at a difference of 10 K')
    ]
    conductance_2: Annotated[
        float, Quantity('W/K', 0.0, 100.0, 'conductance of chamber 2 at a difference of 10 K')
    ]
    exponent: Annotated[float, Quantity('-', 0.15, 0.4, 'power of the difference of temperature')]


@compiled
def heat(colder: float, conductance: float, exponent: float) -> float:
    """
    Return the heat flow [W] into a gas.

    :param colder: by how much the gas is colder than the wall [K]
    :param conductance: at a difference of 10 K [W/K]
    """
    size = max(abs(colder) / REFERENCE, SMALLEST)
    return conductance * math.pow(size, exponent) * colder


@Effect(
    title='natural convection of the gas carries heat to and from the chamber walls',
    balance=Balance.HEAT,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='W. H. McAdams, Heat Transmission, McGraw-Hill 1954; S. W. Churchill, H. H. S. Chu, '
    'Correlating Equations for Laminar and Turbulent Free Convection From a Vertical Plate, Int. '
    'J. Heat Mass Transfer 18 (1975)',
    null=Parameters(0.0, 0.0, 0.25),
    probes=((0.05, 0.05, 0.25), (0.2, 0.0, 0.25), (0.0, 0.2, 0.25), (0.6, 0.6, 0.33)),
    drivers=('pressure', 'position', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the heat flows [W] into the gas of chamber 1 and 2."""
    gas, power = signals.gas, parameters.exponent
    wall = model.gas.supply_temperature
    gas_1 = chambers.temperature(gas.pressure_1, gas.volume_1, gas.gas_mass_1, model.gas)
    gas_2 = chambers.temperature(gas.pressure_2, gas.volume_2, gas.gas_mass_2, model.gas)
    heat_1 = heat(wall - gas_1, parameters.conductance_1, power)
    return heat_1, heat(wall - gas_2, parameters.conductance_2, power)
