"""
The modelled rates along a measured run: nothing of what was measured is integrated.

Position, velocity and pressures are those measured; only what cannot be measured is carried on
from sample to sample - bristle, film, dwell clock, gas masses, states of the effects. So no error
grows, and every sample says by itself what the measured rates differ by. Between two samples the
rates are those at the middle, where the voltages have no jump.
"""

from collections.abc import Callable

import numpy as np

from pneu_rig_ros.arrays import Floats, Integers
from pneu_rig_ros.model import chambers, events
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.integrator import copy
from pneu_rig_ros.model.run import BALANCING_ROUNDS, LEAST_STIFFNESS

SOURCE_1, SOURCE_2, FORCE, INERTIA, LOADING = range(5)
"""
Columns of the rates: gas sources of chamber 1 and 2 [kg/s], the force that accelerates a free
piston and what it accelerates [N, kg], and how far the seal of a piston at rest is loaded [-], 1
where it is about to break away; NaN where a column does not apply.
"""
COLUMNS = 5

MOVES, RESTS, AT_INNER_STOP, AT_OUTER_STOP = range(4)
"""What the piston does in an interval."""

SLOWEST_CREEP = 1e-7
"""Speed at which g(v, h) is that at rest [m/s]."""
BALANCED = 3e-3
"""Newton's last step to the deflection that holds the drive; its square is the error [-]."""
FASTEST_CREEP = 1e-3
"""A piston at rest is slower: the speed between rest and motion, see ``analysis`` [m/s]."""


@compiled
def set_measured(state: Floats, before: Floats, after: Floats, velocity: float) -> None:
    """Set position, velocity and pressures to those between two samples; changes ``state``."""
    state[at.POSITION] = 0.5 * (before[0] + after[0])
    state[at.VELOCITY] = velocity
    state[at.PRESSURE_1] = 0.5 * (before[1] + after[1])
    state[at.PRESSURE_2] = 0.5 * (before[2] + after[2])


@compiled
def gas_source(
    rate: float, swept: float, pressure: float, volume: float, model: CompiledModel
) -> float:
    """
    Return the gas source (V dp/dt + k p V')/(k R T_s) [kg/s]: flow, and heat as if it were one.

    Of changes in place of the rates it returns the gain [kg].

    :param rate: dp/dt [Pa/s]
    :param swept: dV/dt [m^3/s]
    """
    gas = model.gas
    enthalpy = gas.heat_capacity_ratio * gas.gas_constant * gas.supply_temperature
    return float((volume * rate + gas.heat_capacity_ratio * pressure * swept) / enthalpy)


@compiled
def switch(
    time: float, contact: int, state: Floats, memory: Floats, grown: float, model: CompiledModel
) -> None:
    """Let the piston break away or come to rest at ``time`` [s]; changes ``memory``."""
    law = model.friction
    speed = abs(state[at.VELOCITY]) if contact == MOVES else 0.0
    if memory[at.STICKING] != 0.0 and speed > events.breakaway_velocity(law):
        events.break_away(time, memory, grown, law)
    elif memory[at.STICKING] == 0.0 and speed < law.stop_velocity:
        events.enter_rest(time, memory, law)
    memory[at.CONTACT] = 0.0
    if contact == AT_INNER_STOP:
        memory[at.CONTACT] = -1.0
    elif contact == AT_OUTER_STOP:
        memory[at.CONTACT] = 1.0


@compiled
def slide(half: float, point: at.Point, model: CompiledModel) -> float:
    """
    Carry the bristle on by the implicit midpoint rule; return its change to the middle [m].

    :param half: time to the middle [s]
    """
    change = float(half * point.rate[at.DEFLECTION] / (1.0 - half * point.arrow[at.Z_Z]))
    point.state[at.DEFLECTION] += 2.0 * change
    events.update_anchors(point, model)
    return change


@compiled
def measured_gains(
    before: Floats, after: Floats, state: Floats, model: CompiledModel
) -> tuple[float, float]:
    """
    Return what the gas of both chambers gained between two samples [kg]: mass, and heat as mass.

    :param state: at the middle
    """
    v1, v2 = chambers.volumes(state[at.POSITION], model.cylinder)
    first_1, first_2 = chambers.volumes(before[0], model.cylinder)
    last_1, last_2 = chambers.volumes(after[0], model.cylinder)
    rise_1, rise_2 = after[1] - before[1], after[2] - before[2]
    gain_1 = gas_source(rise_1, last_1 - first_1, state[at.PRESSURE_1], v1, model)
    return gain_1, gas_source(rise_2, last_2 - first_2, state[at.PRESSURE_2], v2, model)


def build_rest(mechanics: Callable[..., object]) -> Callable[..., float]:
    """Return the compiled balance of a piston at rest."""

    @inner
    def rest(time: float, interval: float, point: at.Point, model: CompiledModel) -> float:
        """
        Deflect the bristle until it holds the driving force; return how far the seal is loaded.

        What deflects it is creep, dz/dt = v (1 - F(z)/g(0, h)), which the film feels; too slow to
        be measured, so it is the model's own. The piston breaks away at the fastest creep.
        """
        state, rate, arrow, _, _ = point
        old, side = state[at.DEFLECTION], 1.0
        for _ in range(BALANCING_ROUNDS + 1):
            side = 1.0 if state[at.DEFLECTION] > 0.0 else -1.0
            state[at.VELOCITY] = side * SLOWEST_CREEP
            mechanics(time, point, model)
            if arrow[at.V_Z] > -LEAST_STIFFNESS:
                break
            step = -rate[at.VELOCITY] / arrow[at.V_Z]
            state[at.DEFLECTION] += step
            rate[at.DEFLECTION] += arrow[at.Z_Z] * step
            events.update_anchors(point, model)
            if abs(step) <= BALANCED * abs(state[at.DEFLECTION]):
                break
        share = 1.0 - side * rate[at.DEFLECTION] / SLOWEST_CREEP
        bent = side * (state[at.DEFLECTION] - old) / interval
        loaded = share + max(bent, 0.0) / FASTEST_CREEP
        state[at.VELOCITY] = 0.0
        if loaded >= 1.0:
            state[at.VELOCITY] = side * FASTEST_CREEP
        elif bent > 0.0:
            state[at.VELOCITY] = side * bent / (1.0 - share)
        return float(loaded)

    return rest


def build_along(
    right_hand_side: Callable[..., None], mechanics: Callable[..., object]
) -> Callable[..., None]:
    """
    Return the compiled rates along a measured run.

    ``along(interval, measured, velocity, contacts, voltages, out, states, carry, model)`` writes
    into ``out``, shape (n - 1, 5), see ``SOURCE_1``, and the states at the middle of each interval
    into ``states``, shape (n - 1, size) or (0, size). ``measured`` holds x, p1, p2 of n samples
    [SI]; ``velocity``, ``contacts`` and ``voltages`` are those of the n - 1 intervals. ``carry``
    is that of a plant at rest; it is changed.
    """
    rest = build_rest(mechanics)

    @inner
    def along(
        interval: float,
        measured: Floats,
        velocity: Floats,
        contacts: Integers,
        voltages: Floats,
        out: Floats,
        states: Floats,
        carry: at.IntegratorState,
        model: CompiledModel,
    ) -> None:
        start, point = carry.y0, carry.end
        state, rate, arrow, memory, held = point
        cylinder, grown, half = model.cylinder, 0.0, 0.5 * interval
        heats = carry.f0  # at GAS_MASS_1 and _2: that of the walls in an interval, as mass [kg]
        heats[at.GAS_MASS_1] = heats[at.GAS_MASS_2] = 0.0
        for i in range(len(contacts)):
            time, contact = (i + 0.5) * interval, contacts[i]
            before, after = measured[i], measured[i + 1]
            copy(voltages[i], held)
            set_measured(state, before, after, velocity[i])
            switch(time, contact, state, memory, grown, model)
            copy(state, start)
            gains = measured_gains(before, after, state, model)
            for j in range(2):  # to the middle, by what was measured and the heat before it
                state[at.GAS_MASS_1 + j] += 0.5 * (gains[j] - heats[at.GAS_MASS_1 + j])
            state[at.FILM] += half * rate[at.FILM]
            for j in range(at.STATE_SIZE, len(state)):
                state[j] += half * rate[j]
            out[i, FORCE] = out[i, INERTIA] = out[i, LOADING] = np.nan
            if contact == RESTS:
                out[i, LOADING] = rest(time, interval, point, model)
            right_hand_side(time, point, model)
            grown = arrow[at.GROWN_STATIC]
            if i < len(states):
                copy(state, states[i])
            if contact == MOVES:
                change = slide(half, point, model)
                bent = arrow[at.FREE_ACCELERATION] + arrow[at.V_Z] * change
                out[i, INERTIA] = cylinder.cap_area / arrow[at.V_P1]
                out[i, FORCE] = out[i, INERTIA] * bent
            volumes = chambers.volumes(state[at.POSITION], cylinder)
            for j in range(2):
                swept = state[at.VELOCITY] * (cylinder.cap_area if j == 0 else -cylinder.rod_area)
                out[i, SOURCE_1 + j] = gas_source(
                    rate[at.PRESSURE_1 + j], swept, state[at.PRESSURE_1 + j], volumes[j], model
                )
                mass = at.GAS_MASS_1 + j
                heats[mass] = interval * (out[i, SOURCE_1 + j] - rate[mass])
                state[mass] = start[mass] + gains[j] - heats[mass]
            state[at.FILM] = start[at.FILM] + interval * rate[at.FILM]
            for j in range(at.STATE_SIZE, len(state)):
                state[j] = start[j] + interval * rate[j]

    return along
