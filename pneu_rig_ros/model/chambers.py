"""Chambers and piston: volumes (Eq. 7), pressure build-up (Eq. 6), driving force (Eq. 2, 8)."""

import math

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import Air
from pneu_rig_ros.model.parameters import Cylinder


@compiled
def volumes(position: float, cylinder: Cylinder) -> tuple[float, float]:
    """Return the gas volumes V1, V2 [m^3] at the piston position [m] (Eq. 7)."""
    volume_1 = cylinder.cap_dead_volume + cylinder.cap_area * position
    volume_2 = cylinder.rod_dead_volume + cylinder.rod_area * (cylinder.stroke - position)
    return volume_1, volume_2


@compiled
def pressure_rate(
    pressure: float, volume: float, volume_rate: float, flow: float, heat: float, gas: Air
) -> float:
    """
    Return dp/dt [Pa/s] of a chamber (Eq. 6).

    It is::

        dp/dt = (k R T_s m' - k p V' + (k - 1) Q') / V

    with V' = A1 v for chamber 1 and -A2 v for chamber 2. The heat flow Q' is zero in the paper;
    optional effects add to it.

    :param pressure: absolute [Pa]
    :param volume: [m^3]
    :param volume_rate: [m^3/s]
    :param flow: mass flow into the chamber [kg/s]
    :param heat: heat flow into the gas [W]
    """
    k = gas.heat_capacity_ratio
    enthalpy = gas.gas_constant * gas.supply_temperature * flow
    return (k * (enthalpy - pressure * volume_rate) + (k - 1.0) * heat) / volume


@compiled
def gas_mass(pressure: float, volume: float, temperature: float, gas: Air) -> float:
    """Return the mass of ideal gas [kg] (assumption i) at an absolute pressure [Pa]."""
    return pressure * volume / (gas.gas_constant * temperature)


@compiled
def temperature(pressure: float, volume: float, mass: float, gas: Air) -> float:
    """Return the temperature of a mass of ideal gas [K] at an absolute pressure [Pa]."""
    return pressure * volume / (mass * gas.gas_constant)


@compiled
def driving_force(pressure_1: float, pressure_2: float, cylinder: Cylinder, gas: Air) -> float:
    """
    Return the force of the gas on the piston [N], positive on the outstroke (Eq. 2 and 8).

    The atmosphere acts on the rod's cross-section, so that shut valves at atmospheric pressure
    give no force::

        p1 A1 - p2 A2 - p_atm (A1 - A2)

    :param pressure_1: absolute [Pa]
    :param pressure_2: absolute [Pa]
    """
    a1, a2 = cylinder.cap_area, cylinder.rod_area
    return pressure_1 * a1 - pressure_2 * a2 - gas.atmospheric_pressure * (a1 - a2)


@compiled
def wall_area(volume: float, area: float) -> float:
    """Return the wall [m^2] of a chamber of a volume [m^3] with a piston area [m^2]."""
    return 2.0 * area + 2.0 * volume * math.sqrt(math.pi / area)
