"""Lines between valves and chambers: the flow reaches the chamber with a lag."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime, integrated_lag
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import mass_flow

FLOW_UNIT = 1e-4
"""Unit of the states [kg/s], so that the integrator's tolerance is a small flow."""


class Parameters(NamedTuple):
    """Time constant of both lines."""

    time_constant: Annotated[float, Quantity('s', 0.0, 0.1, 'time constant of the lines')]


@compiled
def held_back(flow: float, pressure: float, atmosphere: float) -> float:
    """Return how much of a flow out of a chamber [kg/s, negative] its pressure does not give."""
    return -min(flow, 0.0) * max(1.0 - pressure / atmosphere, 0.0)


@Effect(
    title='lines delay the flow between valve and chamber',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='E. Richer, Y. Hurmuzlu, A High Performance Pneumatic Force Actuator System: Part I, '
    'J. Dyn. Sys., Meas., Control 122 (2000) (delay in the lines), here of first order',
    null=Parameters(0.0),
    probes=((0.005,), (0.02,), (0.06,)),
    states=('line_flow_1', 'line_flow_2'),
    needs=(Need.VALVES,),
    drivers=(),  # a factor would lose or make the gas that the lines hold
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what the flows into chamber 1 and 2 lack of the flows through the valves [kg/s].

    The states are the flows out of the lines. No gas is lost: the lines hold the time constant
    times the flow. Below atmospheric pressure they draw less from the chamber, in proportion to
    its pressure, or they would empty it and more.
    """
    if parameters.time_constant <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    s, valve, gas = signals, model.valve, model.gas
    flow_1 = mass_flow(s.ports.voltage_1, s.gas.pressure_1, s.ports.supply_1, valve, gas)
    flow_2 = mass_flow(s.ports.voltage_2, s.gas.pressure_2, s.ports.supply_2, valve, gas)
    lack_1, lack_2 = FLOW_UNIT * state[0] - flow_1, FLOW_UNIT * state[1] - flow_2
    time, share = integrated_lag(parameters.time_constant)
    rate[0], rate[1] = -lack_1 / (FLOW_UNIT * time), -lack_2 / (FLOW_UNIT * time)
    held_1 = held_back(FLOW_UNIT * state[0], s.gas.pressure_1, gas.atmospheric_pressure)
    held_2 = held_back(FLOW_UNIT * state[1], s.gas.pressure_2, gas.atmospheric_pressure)
    return share * (lack_1 + held_1), share * (lack_2 + held_2)
