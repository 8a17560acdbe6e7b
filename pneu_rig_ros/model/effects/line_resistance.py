"""Lines between valves and chambers: they resist the flow, so that the valve sees less of it."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime, Signals
from pneu_rig_ros.model.false_position import MOST_ROUNDS, Bracket, narrowed, secant
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import mass_flow

ACCURACY = 1e-9
"""Of the flow, as a share of that without a line [-]."""
LEAST_PRESSURE = 0.01
"""Pressure at the valve, relative to the chamber's, at least: a vacuum has no law of flow [-]."""


class Parameters(NamedTuple):
    """Resistance of each line."""

    resistance: Annotated[
        float,
        Quantity('Pa*s/kg', 0.0, 1e10, 'root of the difference of squared pressures by flow'),
    ]


@compiled
def at_valve(flow: float, pressure: float, resistance: float) -> float:
    """
    Return the pressure at the valve's end of a line [Pa] with a flow into the chamber [kg/s].

    Turbulent flow, isothermal: p_v^2 - p^2 = (R m') |R m'|.
    """
    drop = resistance * flow
    least = LEAST_PRESSURE * pressure
    return math.sqrt(max(pressure * pressure + drop * abs(drop), least * least))


@compiled
def through_line(
    voltage: float, pressure: float, supply: float, model: CompiledModel, resistance: float
) -> float:
    """
    Return the flow into a chamber [kg/s] through valve and line, by false position.

    It is between none and that without a line, as the flow through the valve falls with the
    pressure behind it.
    """
    valve, gas = model.valve, model.gas
    whole = mass_flow(voltage, pressure, supply, valve, gas)
    if whole == 0.0:
        return 0.0
    behind = at_valve(whole, pressure, resistance)
    most = 1.0 - mass_flow(voltage, behind, supply, valve, gas) / whole
    bracket = Bracket(0.0, -1.0, 1.0, most, 0)  # shares of the flow without a line
    for _ in range(MOST_ROUNDS):
        if bracket.high - bracket.low <= ACCURACY or bracket.at_high <= 0.0:
            break
        share = secant(bracket)
        behind = at_valve(share * whole, pressure, resistance)
        excess = share - mass_flow(voltage, behind, supply, valve, gas) / whole
        if abs(excess) <= ACCURACY:
            return share * whole
        bracket = narrowed(bracket, share, excess)
    return bracket.high * whole


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """Return what the flows into chamber 1 and 2 lack of those through the valves alone [kg/s]."""
    ports, gas, resistance = signals.ports, signals.gas, parameters.resistance
    valve, air = model.valve, model.gas
    whole_1 = mass_flow(ports.voltage_1, gas.pressure_1, ports.supply_1, valve, air)
    whole_2 = mass_flow(ports.voltage_2, gas.pressure_2, ports.supply_2, valve, air)
    flow_1 = through_line(ports.voltage_1, gas.pressure_1, ports.supply_1, model, resistance)
    flow_2 = through_line(ports.voltage_2, gas.pressure_2, ports.supply_2, model, resistance)
    return flow_1 - whole_1, flow_2 - whole_2


EFFECT = Effect(
    title='lines resist the flow between valve and chamber',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='P. Beater, Pneumatic Drives, 2007, ch. 5 (turbulent isothermal flow in tubes); in '
    'series with the valve as ISO 6358-3:2014',
    null=Parameters(0.0),
    contribution=contribution,
    probes=(Parameters(1e8), Parameters(3e8), Parameters(1e9)),
    needs=(Need.VALVES,),
    drivers=(),
)
