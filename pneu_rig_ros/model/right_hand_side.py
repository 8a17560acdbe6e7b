"""
Eq. 3-16 and the effects put together: the system of differential equations, and the readings.

Readings are what the sensors make of a state: the true values and the contributions of the sensor
effects. Noise, quantisation and calibration come after it, see ``rig.sensors``.
"""

from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import friction
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, in_turn, inner
from pneu_rig_ros.model.compiled_model import (
    CompiledModel,
    Pair,
    Ports,
    Seal,
    Signals,
    behind_bristles,
    behind_levels,
    behind_spools,
)
from pneu_rig_ros.model.dynamics import (
    Contribution,
    Contributions,
    RightHandSide,
    build_gas_rates,
    build_piston_rates,
    build_seal_rates,
    counted_dwell,
    signals_of,
)
from pneu_rig_ros.model.effect import Balance, Effect
from pneu_rig_ros.model.shape import ACTS, COUNT, VALUES, factors

CHAINS = {Balance.SPOOL: behind_spools, Balance.LEVEL: behind_levels}
"""Balance -> what the later stages see of the earlier ones."""


def collect(effects: Sequence[Effect], first_state: int) -> Contributions:
    """
    Return the sums over the effects.

    :param effects: in the order of their parameters
    :param first_state: index of the first effect state in the state array
    """
    parts: dict[Balance, list[Callable[..., Any]]] = {balance: [] for balance in Balance}
    ends = accumulate((len(effect.states) for effect in effects), initial=first_state)
    states = list(pairwise(ends))
    for index in sorted(range(len(effects)), key=lambda i: effects[i].stage):
        effect = effects[index]
        parts[effect.balance].append(_added(effect, index, *states[index]))
    return {balance: _sum(balance, own) for balance, own in parts.items()}


def _sum(balance: Balance, parts: Sequence[Callable[..., Any]]) -> Contribution:
    """Return the sum over the effects of one balance, in the order of their stages."""
    blocks = {f'add_{i}': part for i, part in enumerate(parts)}
    given = 'signals, model, state, rate'
    steps = [f'total = {name}(total, {given})' for name in blocks]
    return inner(in_turn(f'sum_{balance.name}', given, 'total = 0.0, 0.0', steps, blocks))


@compiled
def _as_without_them(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals that an effect sees where those before it add so much: the same."""
    return signals


def _added(effect: Effect, index: int, start: int, end: int) -> Callable[..., Any]:
    """
    Return what adds both contributions of an effect to those before it, behind which it sees.

    While the effect does not act, it costs next to nothing. It is one function of all that
    belongs to an effect, as each function of its own takes time to compile.

    :param index: among the effects
    :param start, end: first and end index of its states
    """
    contribution, behind = effect.contribution, CHAINS.get(effect.balance, _as_without_them)
    as_array, takes_states = effect.as_array, effect.takes_states
    parameters, count = effect.parameters, len(effect.null)

    @inner
    def added(
        total: Pair, signals: Signals, model: CompiledModel, state: Floats, rate: Floats
    ) -> Pair:
        row = model.effects[index]
        if row[ACTS] == 0.0:
            return total
        seen, own = behind(signals, total[0], total[1]), row[VALUES : VALUES + count]
        memory, change = state[start:end], rate[start:end]
        # which of these it is, is decided when this is compiled
        if as_array:
            a, b = contribution(seen, model, own, memory, change)
        elif takes_states:  # only ``to_fixed_tuple`` makes a tuple of an array in compiled code
            named = parameters(*to_fixed_tuple(own, count))
            a, b = contribution(seen, model, named, memory, change)
        else:
            a, b = contribution(seen, model, parameters(*to_fixed_tuple(own, count)))
        if row[COUNT] != 0.0:
            factor_1, factor_2 = factors(row, seen, model.gas)
            a, b = factor_1 * a, factor_2 * b
        return total[0] + a, total[1] + b

    return added


def build_mechanics(contributions: Contributions) -> Callable[..., Signals]:
    """Return the compiled rates of seal and piston (Eq. 8-16), which also returns the signals."""
    seal_rates = build_seal_rates(contributions)
    piston_rates = build_piston_rates(contributions)
    add_bristle = contributions[Balance.BRISTLE]

    @inner
    def mechanics(time: float, point: at.Point, model: CompiledModel) -> Signals:
        state, rate, _, memory, voltages = point
        z, law, supply = state[at.DEFLECTION], model.friction, model.operation.supply_pressure
        bristles, stiffness = friction.bristle_force(z, memory[at.ANCHORS :], law)
        sticking, dwell = memory[at.STICKING] != 0.0, counted_dwell(time, memory, law)
        seal = Seal(z, bristles, sticking, dwell, law.coulomb_force, law.breakaway_force)
        ports = Ports(voltages[0], voltages[1], supply, supply)
        elastic = signals_of(time, state, ports, seal, model)
        more_force, more_stiffness = add_bristle(elastic, model, state, rate)
        stiffness += more_stiffness
        signals = behind_bristles(elastic, more_force)
        seal_rates(signals, stiffness, point, model)
        piston_rates(signals, stiffness, point, model)
        return signals

    return mechanics


def build_right_hand_side(
    contributions: Contributions, mechanics: Callable[..., Signals]
) -> RightHandSide:
    """
    Return the compiled right-hand side with the given contributions of optional effects.

    ``rhs(time, point, model)`` writes d(state)/dt and the Jacobian entries of a point into it.
    """
    gas_rates = build_gas_rates(contributions)
    motion_reading = contributions[Balance.MOTION_READING]
    pressure_reading = contributions[Balance.PRESSURE_READING]

    @inner
    def right_hand_side(time: float, point: at.Point, model: CompiledModel) -> None:
        signals = mechanics(time, point, model)
        gas_rates(signals, point, model)
        motion_reading(signals, model, point.state, point.rate)  # only the rates of their states
        pressure_reading(signals, model, point.state, point.rate)

    return right_hand_side


@compiled
def visible(time: float, state: Floats, model: CompiledModel) -> Signals:
    """Return the signals that follow from time [s] and state alone; the others are NaN."""
    supply = model.operation.supply_pressure
    ports = Ports(np.nan, np.nan, supply, supply)
    seal = Seal(state[at.DEFLECTION], np.nan, False, np.nan, np.nan, np.nan)
    return signals_of(time, state, ports, seal, model)


def build_readings(contributions: Contributions) -> Callable[..., None]:
    """
    Return the compiled readings.

    ``readings(times, states, out, scratch, model)`` writes the readings of x [m], v [m/s], p1 and
    p2 [Pa, absolute] at each of ``times`` [s], shape (m,), and row of ``states``, shape (m, n),
    into ``out``, shape (m, 4), and rates that are not needed into ``scratch``, shape (n,).
    """
    add_motion = contributions[Balance.MOTION_READING]
    add_pressure = contributions[Balance.PRESSURE_READING]

    @inner
    def readings(
        times: Floats, states: Floats, out: Floats, scratch: Floats, model: CompiledModel
    ) -> None:
        for i in range(len(states)):
            state = states[i]
            signals = visible(times[i], state, model)
            position, velocity = add_motion(signals, model, state, scratch)
            pressure_1, pressure_2 = add_pressure(signals, model, state, scratch)
            out[i, 0], out[i, 1] = state[at.POSITION] + position, state[at.VELOCITY] + velocity
            out[i, 2] = state[at.PRESSURE_1] + pressure_1
            out[i, 3] = state[at.PRESSURE_2] + pressure_2

    return readings
