"""Heat exchange between the gas and the cylinder wall by turbulent flow of the gas."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.chambers import wall_area
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity

REFERENCE = 3e5
"""Pressure at which the coefficient is as stated [Pa]."""


class Parameters(NamedTuple):
    """
    Coefficient of heat transfer at 3 bar, and the power of the pressure with which it grows.

    The wall is at supply temperature. The power is that of Reynolds' number in Nusselt's: 0.8 in a
    turbulent flow, 0.5 in a laminar one. The speed of the gas is taken to be the same throughout:
    the jets of the ports stir it more than the piston does.
    """

    coefficient: Annotated[
        float, Quantity('W/(m^2*K)', 0.0, 1e4, 'coefficient of heat transfer at 3 bar')
    ]
    exponent: Annotated[float, Quantity('-', 0.0, 1.0, 'power of the pressure')]


@compiled
def heat(
    pressure: float, volume: float, mass: float, area: float, model: CompiledModel, law: Parameters
) -> float:
    """Return the heat flow [W] into the gas of a chamber with a piston area [m^2]."""
    colder = model.gas.supply_temperature - chambers.temperature(pressure, volume, mass, model.gas)
    coefficient = law.coefficient * math.pow(max(pressure, 0.0) / REFERENCE, law.exponent)
    return coefficient * wall_area(volume, area) * colder


@Effect(
    title='turbulent flow of the gas carries heat to and from the chamber walls',
    balance=Balance.HEAT,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='F. W. Dittus, L. M. K. Boelter, Heat Transfer in Automobile Radiators of the Tubular '
    'Type, Univ. Calif. Publ. Eng. 2 (1930); G. Woschni, SAE Technical Paper 670931 (1967)',
    null=Parameters(0.0, 0.8),
    probes=((5.0, 0.8), (20.0, 0.8), (20.0, 0.4), (80.0, 0.8)),
    drivers=('speed', 'temperature', 'position'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the heat flows [W] into the gas of chamber 1 and 2."""
    g, cylinder = signals.gas, model.cylinder
    heat_1 = heat(g.pressure_1, g.volume_1, g.gas_mass_1, cylinder.cap_area, model, parameters)
    heat_2 = heat(g.pressure_2, g.volume_2, g.gas_mass_2, cylinder.rod_area, model, parameters)
    return heat_1, heat_2
