"""Piston: driving force and equation of motion (Eq. 8)."""

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import Air
from pneu_rig_ros.model.parameters import Cylinder


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
def acceleration(driving: float, friction: float, mass: float) -> float:
    """
    Return dv/dt [m/s^2] (Eq. 8).

    :param driving: :func:`driving_force` and further forces along the outstroke [N]
    :param friction: F_r without its share in dv/dt [N]
    :param mass: M, and sigma_2 T of Eq. 9, which acts like a mass [kg]
    """
    return (driving - friction) / mass
