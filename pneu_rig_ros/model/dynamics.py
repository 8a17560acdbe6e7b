"""
The system of ordinary differential equations: Eq. 3-16 put together.

The continuous state is a flat array (indices below) followed by the states of the optional
effects. What jumps - rest or sliding, contact with an end stop, the static friction held through
a slip, the anchors of F(z) - is the memory, constant while the equations are integrated and
changed only by ``transitions``.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model import chambers, friction, hysteresis, piston, valve
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.contributions import Contributions
from pneu_rig_ros.model.effect import Signals
from pneu_rig_ros.model.parameters import (
    HELD_TO_NEXT_BREAKAWAY,
    LATCHED_AT_BREAKAWAY,
    REVISED_LUGRE_DWELL,
    Friction,
    Model,
)

Array = NDArray[np.float64]
RightHandSide = Callable[..., None]

POSITION, VELOCITY, PRESSURE_1, PRESSURE_2, DEFLECTION, FILM, GAS_MASS_1, GAS_MASS_2 = range(8)
STATE_SIZE = 8
STATE_NAMES = (
    'position', 'velocity', 'pressure_1', 'pressure_2', 'deflection', 'film', 'gas_mass_1',
    'gas_mass_2',
)  # fmt: skip

STICKING, CONTACT, REST_START, HELD_STATIC, ANCHORS = range(5)
"""Memory: at rest (0, 1), end stop touched (-1 at 0, +1 at L), time rest began [s], F_s [N]."""

(
    V_V, V_Z, V_P1, V_P2, Z_V, Z_Z, P1_V, P1_P1, P2_V, P2_P2, FREE_ACCELERATION, GROWN_STATIC
) = range(12)  # fmt: skip
"""Arrow-shaped Jacobian of (v, z, p1, p2), row_column; acceleration without a stop; Eq. 16."""
ARROW_SIZE = 12


@compiled
def static_forces(
    time: float, memory: Array, breakaway: float, coulomb: float, law: Friction
) -> tuple[float, float]:
    """
    Return F_s [N] under the chosen reading of Eq. 16, and Eq. 16 itself for the dwell so far.

    :param time: [s]
    :param breakaway: F_smax [N]
    :param coulomb: F_c [N]
    """
    if law.model != REVISED_LUGRE_DWELL:
        return breakaway, breakaway
    dwell = time - memory[REST_START] if memory[STICKING] != 0.0 else 0.0
    grown = friction.static_friction(dwell, breakaway, coulomb, law)
    if law.static_friction_reading == HELD_TO_NEXT_BREAKAWAY:
        return memory[HELD_STATIC], grown
    if law.static_friction_reading == LATCHED_AT_BREAKAWAY and memory[STICKING] == 0.0:
        return memory[HELD_STATIC], grown
    return grown, grown


@compiled
def flow_slope(flow: float, pressure: float, supply_pressure: float, model: Model) -> float:
    """
    Return roughly d(mass flow)/d(chamber pressure) [kg/(s*Pa)], for the implicit solver only.

    Exact where the flow is choked or laminar, and right to a factor of two between.
    """
    critical = valve.critical_ratio(model.gas.heat_capacity_ratio)
    laminar = 1.0 - model.valve.laminar_pressure_ratio
    outlet = model.gas.atmospheric_pressure
    if flow > 0.0:
        if pressure < critical * supply_pressure:
            return 0.0
        return -flow / max(abs(supply_pressure - pressure), laminar * supply_pressure)
    if outlet < critical * pressure:
        return flow / pressure
    return flow / max(abs(pressure - outlet), laminar * pressure)


def build_right_hand_side(contributions: Contributions) -> RightHandSide:
    """
    Return the compiled right-hand side with the given contributions of optional effects.

    ``rhs(time, state, rate, arrow, memory, voltages, model, effects)`` writes d(state)/dt into
    ``rate``, shape (n,), and the Jacobian entries into ``arrow``, shape (12,). ``voltages`` are
    u1, u2 [V], shape (2,); ``effects`` is the tuple of the effects' parameters.
    """
    add_spool = contributions.spool
    add_supply = contributions.supply
    add_mass = contributions.mass
    add_heat = contributions.heat
    add_level = contributions.level
    add_force = contributions.force

    @compiled
    def right_hand_side(
        time: float,
        state: Array,
        rate: Array,
        arrow: Array,
        memory: Array,
        voltages: Array,
        model: Model,
        effects: tuple[object, ...],
    ) -> None:
        cylinder, law, gas = model.cylinder, model.friction, model.gas
        x, v = state[POSITION], state[VELOCITY]
        p1, p2 = state[PRESSURE_1], state[PRESSURE_2]
        z, film = state[DEFLECTION], state[FILM]
        volume_1, volume_2 = chambers.volumes(x, cylinder)
        bristles, stiffness = hysteresis.bristle_force(z, memory[ANCHORS:], law)
        sticking = memory[STICKING] != 0.0
        signals = Signals(
            time, x, v, p1, p2, volume_1, volume_2, state[GAS_MASS_1], state[GAS_MASS_2],
            voltages[0], voltages[1], bristles, sticking,
        )  # fmt: skip

        # valves and chambers, Eq. 3-7
        spool_1, spool_2 = add_spool(signals, model, effects, state, rate)
        supply_1, supply_2 = add_supply(signals, model, effects, state, rate)
        leak_1, leak_2 = add_mass(signals, model, effects, state, rate)
        heat_1, heat_2 = add_heat(signals, model, effects, state, rate)
        supply = model.operation.supply_pressure
        ps1, ps2 = supply + supply_1, supply + supply_2
        flow_1 = valve.mass_flow(voltages[0] + spool_1, p1, ps1, model.valve, gas)
        flow_2 = valve.mass_flow(voltages[1] + spool_2, p2, ps2, model.valve, gas)
        a1, a2 = cylinder.cap_area, cylinder.rod_area
        total_1, total_2 = flow_1 + leak_1, flow_2 + leak_2
        rate[PRESSURE_1] = chambers.pressure_rate(p1, volume_1, a1 * v, total_1, heat_1, gas)
        rate[PRESSURE_2] = chambers.pressure_rate(p2, volume_2, -a2 * v, total_2, heat_2, gas)
        rate[GAS_MASS_1], rate[GAS_MASS_2] = total_1, total_2

        # friction, Eq. 9-16
        level_c, level_s = add_level(signals, model, effects, state, rate)
        coulomb, breakaway = law.coulomb_force + level_c, law.breakaway_force + level_s
        static, grown = static_forces(time, memory, breakaway, coulomb, law)
        level_0 = friction.static_level(film, static, coulomb, law)
        level = friction.sliding_level(v, level_0, coulomb, law)
        z_rate = friction.bristle_deflection_rate(v, bristles, level)
        steady = friction.film_steady_state(v, static, coulomb, law)
        rate[FILM] = friction.film_rate(film, steady, sticking, law)

        # motion, Eq. 8 solved for the acceleration with the fluid term of Eq. 9
        force, added_mass = add_force(signals, model, effects, state, rate)
        drive = piston.driving_force(p1, p2, cylinder, gas) + force
        mass = cylinder.moving_mass + model.operation.load_mass + added_mass
        inertia = mass + law.viscous_coefficient * friction.fluid_time(law)
        resistance = friction.friction_force(bristles, z_rate, v, 0.0, law)
        acceleration = piston.acceleration(drive, resistance, inertia)
        touching = memory[CONTACT] != 0.0
        rate[POSITION] = v
        rate[VELOCITY] = 0.0 if touching else acceleration
        rate[DEFLECTION] = 0.0 if touching else z_rate

        # Jacobian of (v, z, p1, p2)
        share, sigma_1, n = bristles / level, law.micro_viscous_coefficient, law.stribeck_exponent
        speed = abs(v)
        bend = n * (level - coulomb) * np.power(speed / law.stribeck_velocity, n)
        arrow[Z_V] = 1.0 - np.copysign(share, v) - np.copysign(share, v) * bend / level
        arrow[Z_Z] = -speed * stiffness / level
        arrow[V_V] = -(law.viscous_coefficient + sigma_1 * arrow[Z_V]) / inertia
        arrow[V_Z] = -(stiffness + sigma_1 * arrow[Z_Z]) / inertia
        arrow[V_P1], arrow[V_P2] = a1 / inertia, -a2 / inertia
        k, enthalpy = gas.heat_capacity_ratio, gas.gas_constant * gas.supply_temperature
        arrow[P1_V], arrow[P2_V] = -k * p1 * a1 / volume_1, k * p2 * a2 / volume_2
        slope_1 = enthalpy * flow_slope(flow_1, p1, ps1, model)
        slope_2 = enthalpy * flow_slope(flow_2, p2, ps2, model)
        arrow[P1_P1] = k * (slope_1 - a1 * v) / volume_1
        arrow[P2_P2] = k * (slope_2 + a2 * v) / volume_2
        if touching:  # the stop holds the piston: v and z are not coupled to anything
            arrow[V_V] = arrow[V_Z] = arrow[V_P1] = arrow[V_P2] = 0.0
            arrow[Z_V] = arrow[Z_Z] = 0.0
        arrow[FREE_ACCELERATION], arrow[GROWN_STATIC] = acceleration, grown

    return right_hand_side
