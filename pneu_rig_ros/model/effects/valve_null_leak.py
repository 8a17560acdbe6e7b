"""Leakage of the valves past the lands of their spools."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import port_flow

LEAST_OVERLAP = 1e-3
"""Overlap over which the leak falls, at least [V]; a valve may have none."""


class Parameters(NamedTuple):
    """Effective areas of a port that is just shut, the same in both valves."""

    intake_area: Annotated[
        float, Quantity('m^2', 0.0, 1e-7, 'leak area of the intake at its edge')
    ]
    exhaust_area: Annotated[
        float, Quantity('m^2', 0.0, 1e-7, 'leak area of the exhaust at its edge')
    ]


@compiled
def leak_into(
    voltage: float, pressure: float, supply: float, model: CompiledModel, edges: Parameters
) -> float:
    """
    Return the mass flow [kg/s] that leaks into the chamber of one valve.

    The gap between land and sleeve is as long as the land overlaps its port, and its resistance
    grows with its length. At an edge and beyond it the leak is the area given; half of the
    valve's overlap away from the edge, where the spool is centred, it is half of that.

    :param voltage: where the spool stands [V]
    :param pressure: of the chamber, absolute [Pa]
    :param supply: pressure at the valve, absolute [Pa]
    """
    valve, gas = model.valve, model.gas
    scale = max(0.5 * (valve.intake_voltage - valve.exhaust_voltage), LEAST_OVERLAP)
    intake_gap = max(valve.intake_voltage - voltage, 0.0)
    exhaust_gap = max(voltage - valve.exhaust_voltage, 0.0)
    intake = edges.intake_area * scale / (scale + intake_gap)
    exhaust = edges.exhaust_area * scale / (scale + exhaust_gap)
    supplied = port_flow(supply, pressure, intake, valve, gas)
    return supplied - port_flow(pressure, gas.atmospheric_pressure, exhaust, valve, gas)


@Effect(
    title='valves leak past their spools, most near the centre',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967 (null leakage of spool valves), '
    'with the port flow of Eq. 3',
    null=Parameters(0.0, 0.0),
    probes=((1e-9, 0.0), (0.0, 1e-9), (3e-9, 3e-9), (6e-9, 6e-9)),
    needs=(Need.VALVES,),
    drivers=('opening', 'pressure'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the mass flows [kg/s] that leak into chamber 1 and 2."""
    s = signals
    leak_1 = leak_into(s.ports.voltage_1, s.gas.pressure_1, s.ports.supply_1, model, parameters)
    leak_2 = leak_into(s.ports.voltage_2, s.gas.pressure_2, s.ports.supply_2, model, parameters)
    return leak_1, leak_2
