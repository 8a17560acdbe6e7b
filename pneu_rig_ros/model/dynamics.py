"""
The rates of gas, seal and piston by Eq. 3-16, and the state that they change.

The continuous state is a flat array (indices below) followed by the states of the optional
effects. What jumps - rest or sliding, contact with an end stop, the static friction held through
a slip, the anchors of F(z) - is the memory, constant while the equations are integrated and
changed only by ``events``.
"""

from collections.abc import Callable

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import chambers, friction, valve
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import CompiledEffects, CompiledModel
from pneu_rig_ros.model.effect import (
    Balance,
    ChamberGas,
    Motion,
    Ports,
    Seal,
    Signals,
    behind_spools,
    behind_supply,
)
from pneu_rig_ros.model.parameters import (
    FADES_WHILE_SLIDING,
    HELD_TO_NEXT_BREAKAWAY,
    LATCHED_AT_BREAKAWAY,
    REVISED_LUGRE_DWELL,
    Friction,
)

RightHandSide = Callable[..., None]
Contribution = Callable[
    [Signals, CompiledModel, CompiledEffects, Floats, Floats], tuple[float, float]
]
Contributions = dict[Balance, Contribution]
"""One compiled function a balance, the sum over the effects; units as in :class:`Balance`."""

POSITION, VELOCITY, PRESSURE_1, PRESSURE_2, DEFLECTION, FILM, GAS_MASS_1, GAS_MASS_2 = range(8)
STATE_SIZE = 8

(STICKING, CONTACT, REST_START, REST_AGE, SLIDE_START, HELD_STATIC, HELD_DWELL, ANCHORS) = range(8)
"""
Memory: at rest (0, 1), end stop touched (-1 at 0, +1 at L), time rest began [s] and the dwell that
F_s stood for then [s]; time sliding began [s]; F_s [N] and dwell [s] at the last breakaway; the
anchors of F(z) [m].
"""
HELD = 2.0
"""In place of a contact: the motion is imposed from outside, see ``run``."""

(V_V, V_Z, V_P1, V_P2, Z_V, Z_Z, P1_V, P1_P1, P2_V, P2_P2, FREE_ACCELERATION, GROWN_STATIC) = (
    range(12)
)
"""Arrow-shaped Jacobian of (v, z, p1, p2), row_column; acceleration without a stop; Eq. 16."""
ARROW_SIZE = 12

SIGN_SMOOTHING_SPEED = 1e-5
"""Speed below which the Jacobian, and only that, ignores the sign of the velocity [m/s]."""
LEAST_SHARE = 0.01
"""Share of F_c and F_smax that remains whatever the effects take away: friction never drives."""


@compiled
def signals_of(
    time: float, state: Floats, ports: Ports, seal: Seal, model: CompiledModel
) -> Signals:
    """Return the signals of the contributions in a state at ``time`` [s]."""
    volume_1, volume_2 = chambers.volumes(state[POSITION], model.cylinder)
    mass_1, mass_2 = state[GAS_MASS_1], state[GAS_MASS_2]
    gas = ChamberGas(state[PRESSURE_1], state[PRESSURE_2], volume_1, volume_2, mass_1, mass_2)
    return Signals(time, Motion(state[POSITION], state[VELOCITY]), gas, ports, seal)


@compiled
def dwell_clock(time: float, memory: Floats, law: Friction) -> float:
    """
    Return the dwell [s] at which the clock of Eq. 16 stands at ``time`` [s].

    It runs while the piston rests. Sliding sets it back: to zero at once, or, where F_s fades,
    to the dwell that has given what is left of F_s.
    """
    if memory[STICKING] != 0.0:
        return max(float(memory[REST_AGE] + (time - memory[REST_START])), 0.0)
    if law.static_friction_reading == FADES_WHILE_SLIDING:
        return friction.faded_dwell(memory[HELD_DWELL], time - memory[SLIDE_START], law)
    return 0.0


@compiled
def held_static(memory: Floats, law: Friction) -> bool:
    """Return whether F_s is that of the last breakaway, under the chosen reading of Eq. 16."""
    if law.static_friction_reading == LATCHED_AT_BREAKAWAY:
        return bool(memory[STICKING] == 0.0)
    return law.static_friction_reading == HELD_TO_NEXT_BREAKAWAY


@compiled
def static_forces(
    time: float, memory: Floats, breakaway: float, coulomb: float, law: Friction
) -> tuple[float, float]:
    """
    Return F_s [N] under the chosen reading of Eq. 16, and Eq. 16 itself for the dwell so far.

    :param time: [s]
    :param breakaway: F_smax [N]
    :param coulomb: F_c [N]
    """
    if law.model != REVISED_LUGRE_DWELL:
        return breakaway, breakaway
    grown = friction.static_friction(dwell_clock(time, memory, law), breakaway, coulomb, law)
    return (memory[HELD_STATIC] if held_static(memory, law) else grown), grown


@compiled
def counted_dwell(time: float, memory: Floats, law: Friction) -> float:
    """Return the dwell [s] that F_s stands for at ``time`` [s], under the reading of Eq. 16."""
    return (
        float(memory[HELD_DWELL]) if held_static(memory, law) else dwell_clock(time, memory, law)
    )


@compiled
def flow_slope(
    flow: float, pressure: float, supply_pressure: float, model: CompiledModel
) -> float:
    """
    Return roughly d(mass flow)/d(chamber pressure) [kg/(s*Pa)], for the implicit solver only.

    Exact where the flow is choked or laminar, and right to a factor of two between.
    """
    critical = model.gas.critical_ratio
    laminar = 1.0 - model.valve.laminar_pressure_ratio
    outlet = model.gas.atmospheric_pressure
    if flow > 0.0:
        if pressure < critical * supply_pressure:
            return 0.0
        return -flow / max(abs(supply_pressure - pressure), laminar * supply_pressure)
    if outlet < critical * pressure:
        return flow / pressure
    return flow / max(abs(pressure - outlet), laminar * pressure)


def build_gas_rates(contributions: Contributions) -> Callable[..., None]:
    """Return the compiled rates of pressures and gas masses (Eq. 3-7), and their Jacobian."""
    add_spool, add_supply = contributions[Balance.SPOOL], contributions[Balance.SUPPLY]
    add_mass, add_heat = contributions[Balance.MASS], contributions[Balance.HEAT]

    @inner
    def gas_rates(
        s: Signals,
        state: Floats,
        rate: Floats,
        arrow: Floats,
        model: CompiledModel,
        effects: CompiledEffects,
    ) -> None:
        gas, a1, a2 = model.gas, model.cylinder.cap_area, model.cylinder.rod_area
        spool_1, spool_2 = add_spool(s, model, effects, state, rate)
        at_spools = behind_spools(s, spool_1, spool_2)
        supply_1, supply_2 = add_supply(at_spools, model, effects, state, rate)
        at_ports = behind_supply(at_spools, supply_1, supply_2)
        leak_1, leak_2 = add_mass(at_ports, model, effects, state, rate)
        heat_1, heat_2 = add_heat(s, model, effects, state, rate)
        u1, u2, ps1, ps2 = at_ports.ports
        p1, p2, v1, v2 = s.gas.pressure_1, s.gas.pressure_2, s.gas.volume_1, s.gas.volume_2
        flow_1 = valve.mass_flow(u1, p1, ps1, model.valve, gas)
        flow_2 = valve.mass_flow(u2, p2, ps2, model.valve, gas)
        total_1, total_2 = flow_1 + leak_1, flow_2 + leak_2
        swept_1, swept_2 = a1 * s.motion.velocity, -a2 * s.motion.velocity
        rate[PRESSURE_1] = chambers.pressure_rate(p1, v1, swept_1, total_1, heat_1, gas)
        rate[PRESSURE_2] = chambers.pressure_rate(p2, v2, swept_2, total_2, heat_2, gas)
        rate[GAS_MASS_1], rate[GAS_MASS_2] = total_1, total_2

        k, enthalpy = gas.heat_capacity_ratio, gas.gas_constant * gas.supply_temperature
        slope_1 = enthalpy * flow_slope(flow_1, p1, ps1, model)
        slope_2 = enthalpy * flow_slope(flow_2, p2, ps2, model)
        arrow[P1_V], arrow[P2_V] = -k * p1 * a1 / v1, k * p2 * a2 / v2
        arrow[P1_P1] = k * (slope_1 - swept_1) / v1
        arrow[P2_P2] = k * (slope_2 - swept_2) / v2

    return gas_rates


def build_seal_rates(contributions: Contributions) -> Callable[..., None]:
    """Return the compiled rates of bristle and film (Eq. 10-16), and their Jacobian."""
    add_level, add_film = contributions[Balance.LEVEL], contributions[Balance.FILM]

    @inner
    def seal_rates(
        s: Signals,
        stiffness: float,
        state: Floats,
        rate: Floats,
        arrow: Floats,
        memory: Floats,
        model: CompiledModel,
        effects: CompiledEffects,
    ) -> None:
        law, film = model.friction, state[FILM]
        v, bristles = s.motion.velocity, s.seal.bristle_force
        level_c, level_s = add_level(s, model, effects, state, rate)
        coulomb = max(law.coulomb_force + level_c, LEAST_SHARE * law.coulomb_force)
        breakaway = max(law.breakaway_force + level_s, LEAST_SHARE * law.breakaway_force)
        static, grown = static_forces(s.time, memory, breakaway, coulomb, law)
        level_at_rest = friction.static_level(film, static, coulomb, law)
        share, _ = add_film(s, model, effects, state, rate)
        level_at_rest -= min(share, 1.0) * (level_at_rest - coulomb)
        power = friction.stribeck_power(v, law)
        level = friction.sliding_level(power, level_at_rest, coulomb)
        steady = friction.film_steady_state(v, static, coulomb, law)
        rate[DEFLECTION] = friction.bristle_deflection_rate(v, bristles, level)
        resting = friction.film_rests(v, s.seal.sticking, law)
        rate[FILM] = friction.film_rate(film, steady, resting, law)

        # near rest the slope of |v| is taken as zero: between its two sides, a stiff step settles
        slope = bristles / level * v / (abs(v) + SIGN_SMOOTHING_SPEED)
        bend = law.stribeck_exponent * power * (level - coulomb) / level
        arrow[Z_V] = 1.0 - slope - slope * bend
        arrow[Z_Z] = -abs(v) * stiffness / level
        arrow[GROWN_STATIC] = grown

    return seal_rates


def build_piston_rates(contributions: Contributions) -> Callable[..., None]:
    """Return the compiled rates of position and velocity (Eq. 8 and 9), and their Jacobian."""
    add_force = contributions[Balance.FORCE]

    @inner
    def piston_rates(
        s: Signals,
        stiffness: float,
        state: Floats,
        rate: Floats,
        arrow: Floats,
        memory: Floats,
        model: CompiledModel,
        effects: CompiledEffects,
    ) -> None:
        cylinder, law, v = model.cylinder, model.friction, s.motion.velocity
        force, added_mass = add_force(s, model, effects, state, rate)
        p1, p2 = s.gas.pressure_1, s.gas.pressure_2
        drive = chambers.driving_force(p1, p2, cylinder, model.gas) + force
        mass = cylinder.moving_mass + model.operation.load_mass + added_mass
        # the fluid term of Eq. 9 is solved for the acceleration: it acts like a mass
        inertia = mass + law.viscous_coefficient * friction.fluid_time(law)
        z_rate = rate[DEFLECTION]
        resistance = friction.friction_force(s.seal.bristle_force, z_rate, v, 0.0, law)
        acceleration = (drive - resistance) / inertia
        rate[POSITION], rate[VELOCITY] = v, acceleration
        arrow[FREE_ACCELERATION] = acceleration

        sigma_1 = law.micro_viscous_coefficient
        arrow[V_V] = -(law.viscous_coefficient + sigma_1 * arrow[Z_V]) / inertia
        arrow[V_Z] = -(stiffness + sigma_1 * arrow[Z_Z]) / inertia
        arrow[V_P1], arrow[V_P2] = cylinder.cap_area / inertia, -cylinder.rod_area / inertia
        if memory[CONTACT] != 0.0:  # the stop holds the piston, whatever pushes it there
            rate[VELOCITY] = 0.0
            arrow[V_V] = arrow[V_Z] = arrow[V_P1] = arrow[V_P2] = 0.0
            if memory[CONTACT] != HELD:
                rate[DEFLECTION] = arrow[Z_V] = arrow[Z_Z] = 0.0

    return piston_rates
