"""Proportional valves: command (Eq. 1), mass flow (Eq. 3) and flow coefficients (Eq. 4-5)."""

import math

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import Air, CompiledModel, Signals
from pneu_rig_ros.model.parameters import Valve

CENTRE_VOLTAGE = 2.5
"""Voltage at which both ports are shut [V]."""
FULL_VOLTAGE = 5.0
"""Largest control voltage of a valve [V]."""


@compiled
def control_voltages(u: float) -> tuple[float, float]:
    """
    Return the voltages u1, u2 [V] of both valves for the command u [V] (Eq. 1).

    >>> control_voltages(0.5)
    (3.0, 2.0)
    """
    return CENTRE_VOLTAGE + u, CENTRE_VOLTAGE - u


@compiled
def flow_coefficient(ratio: float, laminar_ratio: float, gas: Air) -> float:
    """
    Return the dimensionless flow coefficient gamma_ib or gamma_ie [-] (Eq. 4 and 5).

    The choked value is the exact one, so that the coefficient is continuous. Above
    ``laminar_ratio`` it falls linearly to zero at ratio 1, where Eq. 4 has an infinite slope.

    :param ratio: downstream over upstream absolute pressure [-], 0 to 1
    :param laminar_ratio: ratio [-] above which the flow is linear in the pressure difference
    """
    if ratio <= gas.critical_ratio:
        return gas.choked_coefficient
    k = gas.heat_capacity_ratio
    inner = min(ratio, laminar_ratio)
    # ratio^((k+1)/2k) * sqrt(ratio^((1-k)/k) - 1) with one power instead of two
    power = math.pow(inner, 1.0 / k)
    coefficient = math.sqrt(2.0 / (k - 1.0) * (power * power - power * inner))
    if ratio > laminar_ratio:
        coefficient *= (1.0 - ratio) / (1.0 - laminar_ratio)
    return coefficient


@compiled
def port_flow(inlet: float, outlet: float, opening: float, valve: Valve, gas: Air) -> float:
    """
    Return the mass flow [kg/s] through one port, positive from inlet to outlet (Eq. 3).

    With the outlet above the inlet pressure the two are swapped and the flow is negative.

    :param inlet: absolute pressure [Pa]
    :param outlet: absolute pressure [Pa]
    :param opening: K_V (u - u_overlap), effective area [m^2]
    """
    upstream, downstream = max(inlet, outlet), min(inlet, outlet)
    coefficient = flow_coefficient(downstream / upstream, valve.laminar_pressure_ratio, gas)
    flow = coefficient * upstream * gas.flow_scale * opening
    return flow if inlet >= outlet else -flow


@compiled
def mass_flow(
    voltage: float, pressure: float, supply_pressure: float, valve: Valve, gas: Air
) -> float:
    """
    Return the mass flow [kg/s] into a chamber (Eq. 3), negative when it is exhausted.

    The exhaust is open below u_n. Its opening counts from ``exhaust_zero_voltage``: with u_m, as
    printed, it jumps at u_n; with u_n the flow is continuous.

    :param voltage: control voltage u_i [V], 0 to 5
    :param pressure: chamber pressure p_i, absolute [Pa]
    :param supply_pressure: p_s, absolute [Pa]
    """
    if voltage > valve.intake_voltage:
        opening = valve.intake_coefficient * (voltage - valve.intake_voltage)
        return port_flow(supply_pressure, pressure, opening, valve, gas)
    if voltage < valve.exhaust_voltage:
        opening = valve.exhaust_coefficient * (valve.exhaust_zero_voltage - voltage)
        return -port_flow(pressure, gas.atmospheric_pressure, opening, valve, gas)
    return 0.0


@compiled
def mass_flow_drawn(
    voltage: float, pressure: float, supply_pressure: float, valve: Valve, gas: Air
) -> float:
    """Return the mass flow [kg/s] that a valve draws from the supply; back flow is none."""
    if voltage <= valve.intake_voltage or pressure >= supply_pressure:
        return 0.0
    return mass_flow(voltage, pressure, supply_pressure, valve, gas)


@compiled
def mass_flow_of_both(signals: Signals, model: CompiledModel, supply_pressure: float) -> float:
    """Return the mass flow [kg/s] that both valves draw at a supply pressure [Pa]."""
    ports, gas, valve, air = signals.ports, signals.gas, model.valve, model.gas
    flow_1 = mass_flow_drawn(ports.voltage_1, gas.pressure_1, supply_pressure, valve, air)
    return flow_1 + mass_flow_drawn(ports.voltage_2, gas.pressure_2, supply_pressure, valve, air)
