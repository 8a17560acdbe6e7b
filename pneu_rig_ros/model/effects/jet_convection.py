"""Heat exchange between the gas and the cylinder wall while jets of the inflow stir the gas."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.chambers import wall_area
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime, integrated_lag
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import mass_flow

REFERENCE = 1e-4
"""Inflow at which the coefficient is as stated, and unit of the states [kg/s]."""
POWER = 0.67
"""Power of the Reynolds number of the inflow in that of Nusselt [-], see the source."""


class Parameters(NamedTuple):
    """
    Coefficient of heat transfer, and how long the gas stays in motion.

    The wall is at supply temperature.
    """

    coefficient: Annotated[
        float, Quantity('W/(m^2*K)', 0.0, 1e4, 'coefficient of heat transfer at 1e-4 kg/s')
    ]
    decay_time: Annotated[
        float, Quantity('s', 0.0, 10.0, 'time constant with which the gas calms down')
    ]


@compiled
def heat(
    pressure: float,
    volume: float,
    mass: float,
    area: float,
    stirred: float,
    model: CompiledModel,
    coefficient: float,
) -> float:
    """
    Return the heat flow [W] into the gas of a chamber with a piston area [m^2].

    :param stirred: inflow that stirs the gas as much as it is stirred, over ``REFERENCE`` [-]
    """
    colder = model.gas.supply_temperature - chambers.temperature(pressure, volume, mass, model.gas)
    return coefficient * math.pow(max(stirred, 0.0), POWER) * wall_area(volume, area) * colder


@Effect(
    title='jets of the inflow stir the gas, which carries heat to and from the chamber walls',
    balance=Balance.HEAT,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='P. L. Woodfield, M. Monde, Y. Mitsutake, Measurement of Averaged Heat Transfer '
    'Coefficients in High-Pressure Vessel during Charging, J. Therm. Sci. Technol. 2 (2007), here '
    'with a motion of the gas that decays',
    null=Parameters(0.0, 0.1),
    probes=tuple((coefficient, time) for coefficient in (5.0, 20.0, 80.0) for time in (0.1, 0.6)),
    states=('stirred_1', 'stirred_2'),
    needs=(Need.VALVES,),
    drivers=('pressure', 'temperature', 'position'),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return the heat flows [W] into the gas of chamber 1 and 2.

    The states are the inflows through the valves, behind a lag, over ``REFERENCE``.
    """
    if parameters.coefficient <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    g, ports, cylinder = signals.gas, signals.ports, model.cylinder
    flow_1 = mass_flow(ports.voltage_1, g.pressure_1, ports.supply_1, model.valve, model.gas)
    flow_2 = mass_flow(ports.voltage_2, g.pressure_2, ports.supply_2, model.valve, model.gas)
    time, _ = integrated_lag(parameters.decay_time)
    rate[0] = (max(flow_1, 0.0) / REFERENCE - state[0]) / time
    rate[1] = (max(flow_2, 0.0) / REFERENCE - state[1]) / time
    size = parameters.coefficient
    heat_1 = heat(g.pressure_1, g.volume_1, g.gas_mass_1, cylinder.cap_area, state[0], model, size)
    heat_2 = heat(g.pressure_2, g.volume_2, g.gas_mass_2, cylinder.rod_area, state[1], model, size)
    return heat_1, heat_2
