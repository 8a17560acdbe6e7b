"""Lines between valves and chambers: they resist the flow, so that the valve sees less of it."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime, falling_fixed_point
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import mass_flow

ACCURACY = 1e-9
"""Of the flow, as a share of that without a line [-]."""
LEAST_PRESSURE = 0.01
"""Pressure at the valve, relative to the chamber's, at least: a vacuum has no law of flow [-]."""


class Parameters(NamedTuple):
    """Resistances of each line, to turbulent and to laminar flow."""

    resistance: Annotated[
        float,
        Quantity('Pa*s/kg', 0.0, 1e10, 'root of the difference of squared pressures by flow'),
    ]
    laminar_resistance: Annotated[
        float, Quantity('Pa^2*s/kg', 0.0, 1e16, 'difference of squared pressures by flow')
    ] = 0.0


@compiled
def at_valve(flow: float, pressure: float, line: Parameters) -> float:
    """
    Return the pressure at the valve's end of a line [Pa] with a flow into the chamber [kg/s].

    Isothermal flow, turbulent and laminar: p_v^2 - p^2 = (R m') |R m'| + R_l m'.
    """
    drop = line.resistance * flow
    squares = drop * abs(drop) + line.laminar_resistance * flow
    least = LEAST_PRESSURE * pressure
    return math.sqrt(max(pressure * pressure + squares, least * least))


@compiled
def share_let_through(
    share: float,
    whole: float,
    voltage: float,
    pressure: float,
    supply: float,
    model: CompiledModel,
    line: Parameters,
) -> float:
    """Return the share [-] of the whole flow that the valve lets through, if a share flows."""
    behind = at_valve(share * whole, pressure, line)
    return mass_flow(voltage, behind, supply, model.valve, model.gas) / whole


solve_share = falling_fixed_point(share_let_through)


@compiled
def lack(
    voltage: float, pressure: float, supply: float, model: CompiledModel, line: Parameters
) -> float:
    """
    Return what the flow into a chamber lacks of that through the valve alone [kg/s].

    The flow is between none and that one, as the flow through the valve falls with the pressure
    behind it.
    """
    whole = mass_flow(voltage, pressure, supply, model.valve, model.gas)
    if whole == 0.0:
        return 0.0
    share = solve_share(1.0, ACCURACY, whole, voltage, pressure, supply, model, line)
    return (share - 1.0) * whole


@Effect(
    title='lines resist the flow between valve and chamber',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='A. H. Shapiro, The Dynamics and Thermodynamics of Compressible Fluid Flow 1, Ronald '
    'Press 1953, ch. 6 (isothermal flow with friction in a long duct), in series with the valve; '
    'laminar flow by Poiseuille',
    null=Parameters(0.0),
    strengths=('resistance', 'laminar_resistance'),
    probes=((1e8,), (3e8,), (1e9,), (0.0, 3e12), (0.0, 3e13), (1e8, 1e13)),
    needs=(Need.VALVES,),
    drivers=(),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what the flows into chamber 1 and 2 lack of those through the valves alone [kg/s]."""
    ports, gas = signals.ports, signals.gas
    lack_1 = lack(ports.voltage_1, gas.pressure_1, ports.supply_1, model, parameters)
    lack_2 = lack(ports.voltage_2, gas.pressure_2, ports.supply_2, model, parameters)
    return lack_1, lack_2
