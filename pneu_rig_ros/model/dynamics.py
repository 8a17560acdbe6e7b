"""The rates of gas, seal and piston by Eq. 3-16."""

from collections.abc import Callable

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import chambers, friction, valve
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import (
    ChamberGas,
    CompiledModel,
    Motion,
    Pair,
    Ports,
    Seal,
    Signals,
    behind_spools,
    behind_supply,
)
from pneu_rig_ros.model.effect import Balance
from pneu_rig_ros.model.parameters import (
    FADES_WHILE_SLIDING,
    HELD_TO_NEXT_BREAKAWAY,
    LATCHED_AT_BREAKAWAY,
    REVISED_LUGRE_DWELL,
    Friction,
)

RightHandSide = Callable[[float, at.Point, CompiledModel], None]
Contribution = Callable[[Signals, CompiledModel, Floats, Floats], Pair]
Contributions = dict[Balance, Contribution]
"""One compiled function a balance, the sum over the effects; units as in :class:`Balance`."""

SIGN_SMOOTHING_SPEED = 1e-5
"""Speed below which the Jacobian, and only that, ignores the sign of the velocity [m/s]."""
LEAST_SHARE = 0.01
"""Share of F_c and F_smax that remains whatever the effects take away: friction never drives."""


@compiled
def signals_of(
    time: float, state: Floats, ports: Ports, seal: Seal, model: CompiledModel
) -> Signals:
    """Return the signals of the contributions in a state at ``time`` [s]."""
    volume_1, volume_2 = chambers.volumes(state[at.POSITION], model.cylinder)
    p1, p2 = state[at.PRESSURE_1], state[at.PRESSURE_2]
    mass_1, mass_2 = state[at.GAS_MASS_1], state[at.GAS_MASS_2]
    gas = ChamberGas(p1, p2, volume_1, volume_2, mass_1, mass_2)
    return Signals(time, Motion(state[at.POSITION], state[at.VELOCITY]), gas, ports, seal)


@compiled
def dwell_clock(time: float, memory: Floats, law: Friction) -> float:
    """
    Return the dwell [s] at which the clock of Eq. 16 stands at ``time`` [s].

    It runs while the piston rests. Sliding sets it back: to zero at once, or, where F_s fades,
    to the dwell that has given what is left of F_s.
    """
    if memory[at.STICKING] != 0.0:
        return max(float(memory[at.REST_AGE] + (time - memory[at.REST_START])), 0.0)
    if law.static_friction_reading == FADES_WHILE_SLIDING:
        return friction.faded_dwell(memory[at.HELD_DWELL], time - memory[at.SLIDE_START], law)
    return 0.0


@compiled
def held_static(memory: Floats, law: Friction) -> bool:
    """Return whether F_s is that of the last breakaway, under the chosen reading of Eq. 16."""
    if law.static_friction_reading == LATCHED_AT_BREAKAWAY:
        return bool(memory[at.STICKING] == 0.0)
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
    return (memory[at.HELD_STATIC] if held_static(memory, law) else grown), grown


@compiled
def counted_dwell(time: float, memory: Floats, law: Friction) -> float:
    """Return the dwell [s] that F_s stands for at ``time`` [s], under the reading of Eq. 16."""
    if held_static(memory, law):
        return float(memory[at.HELD_DWELL])
    return dwell_clock(time, memory, law)


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
    def gas_rates(s: Signals, point: at.Point, model: CompiledModel) -> None:
        state, rate, arrow, _, _ = point
        gas, a1, a2 = model.gas, model.cylinder.cap_area, model.cylinder.rod_area
        spool_1, spool_2 = add_spool(s, model, state, rate)
        at_spools = behind_spools(s, spool_1, spool_2)
        supply_1, supply_2 = add_supply(at_spools, model, state, rate)
        at_ports = behind_supply(at_spools, supply_1, supply_2)
        leak_1, leak_2 = add_mass(at_ports, model, state, rate)
        heat_1, heat_2 = add_heat(at_ports, model, state, rate)
        u1, u2, ps1, ps2 = at_ports.ports
        p1, p2, v1, v2 = s.gas.pressure_1, s.gas.pressure_2, s.gas.volume_1, s.gas.volume_2
        flow_1 = valve.mass_flow(u1, p1, ps1, model.valve, gas)
        flow_2 = valve.mass_flow(u2, p2, ps2, model.valve, gas)
        total_1, total_2 = flow_1 + leak_1, flow_2 + leak_2
        swept_1, swept_2 = a1 * s.motion.velocity, -a2 * s.motion.velocity
        rate[at.PRESSURE_1] = chambers.pressure_rate(p1, v1, swept_1, total_1, heat_1, gas)
        rate[at.PRESSURE_2] = chambers.pressure_rate(p2, v2, swept_2, total_2, heat_2, gas)
        rate[at.GAS_MASS_1], rate[at.GAS_MASS_2] = total_1, total_2

        k, enthalpy = gas.heat_capacity_ratio, gas.gas_constant * gas.supply_temperature
        slope_1 = enthalpy * flow_slope(flow_1, p1, ps1, model)
        slope_2 = enthalpy * flow_slope(flow_2, p2, ps2, model)
        arrow[at.P1_V], arrow[at.P2_V] = -k * p1 * a1 / v1, k * p2 * a2 / v2
        arrow[at.P1_P1] = k * (slope_1 - swept_1) / v1
        arrow[at.P2_P2] = k * (slope_2 - swept_2) / v2

    return gas_rates


def build_seal_rates(contributions: Contributions) -> Callable[..., None]:
    """Return the compiled rates of bristle and film (Eq. 10-16), and their Jacobian."""
    add_level, add_film = contributions[Balance.LEVEL], contributions[Balance.FILM]

    @inner
    def seal_rates(s: Signals, stiffness: float, point: at.Point, model: CompiledModel) -> None:
        state, rate, arrow, memory, _ = point
        law, film = model.friction, state[at.FILM]
        v, bristles = s.motion.velocity, s.seal.bristle_force
        level_c, level_s = add_level(s, model, state, rate)
        coulomb = max(law.coulomb_force + level_c, LEAST_SHARE * law.coulomb_force)
        breakaway = max(law.breakaway_force + level_s, LEAST_SHARE * law.breakaway_force)
        static, grown = static_forces(s.time, memory, breakaway, coulomb, law)
        level_at_rest = friction.static_level(film, static, coulomb, law)
        share, _ = add_film(s, model, state, rate)
        level_at_rest -= min(share, 1.0) * (level_at_rest - coulomb)
        power = friction.stribeck_power(v, law)
        level = friction.sliding_level(power, level_at_rest, coulomb)
        steady = friction.film_steady_state(v, static, coulomb, law)
        rate[at.DEFLECTION] = friction.bristle_deflection_rate(v, bristles, level)
        resting = friction.film_rests(v, s.seal.sticking, law)
        rate[at.FILM] = friction.film_rate(film, steady, resting, law)

        # near rest the slope of |v| is taken as zero: between its two sides, a stiff step settles
        slope = bristles / level * v / (abs(v) + SIGN_SMOOTHING_SPEED)
        bend = law.stribeck_exponent * power * (level - coulomb) / level
        arrow[at.Z_V] = 1.0 - slope - slope * bend
        arrow[at.Z_Z] = -abs(v) * stiffness / level
        arrow[at.GROWN_STATIC] = grown

    return seal_rates


def build_piston_rates(contributions: Contributions) -> Callable[..., None]:
    """Return the compiled rates of position and velocity (Eq. 8 and 9), and their Jacobian."""
    add_force = contributions[Balance.FORCE]

    @inner
    def piston_rates(s: Signals, stiffness: float, point: at.Point, model: CompiledModel) -> None:
        state, rate, arrow, memory, _ = point
        cylinder, law, v = model.cylinder, model.friction, s.motion.velocity
        force, added_mass = add_force(s, model, state, rate)
        p1, p2 = s.gas.pressure_1, s.gas.pressure_2
        drive = chambers.driving_force(p1, p2, cylinder, model.gas) + force
        mass = cylinder.moving_mass + model.operation.load_mass + added_mass
        # the fluid term of Eq. 9 is solved for the acceleration: it acts like a mass
        inertia = mass + law.viscous_coefficient * friction.fluid_time(law)
        z_rate = rate[at.DEFLECTION]
        resistance = friction.friction_force(s.seal.bristle_force, z_rate, v, 0.0, law)
        acceleration = (drive - resistance) / inertia
        rate[at.POSITION], rate[at.VELOCITY] = v, acceleration
        arrow[at.FREE_ACCELERATION] = acceleration

        sigma_1 = law.micro_viscous_coefficient
        arrow[at.V_V] = -(law.viscous_coefficient + sigma_1 * arrow[at.Z_V]) / inertia
        arrow[at.V_Z] = -(stiffness + sigma_1 * arrow[at.Z_Z]) / inertia
        arrow[at.V_P1], arrow[at.V_P2] = cylinder.cap_area / inertia, -cylinder.rod_area / inertia
        if memory[at.CONTACT] != 0.0:  # the stop holds the piston, whatever pushes it there
            rate[at.VELOCITY] = 0.0
            arrow[at.V_V] = arrow[at.V_Z] = arrow[at.V_P1] = arrow[at.V_P2] = 0.0
            if memory[at.CONTACT] != at.HELD:
                rate[at.DEFLECTION] = arrow[at.Z_V] = arrow[at.Z_Z] = 0.0

    return piston_rates
