"""
Eq. 3-16 and the effects put together: the system of differential equations, and the readings.

Readings are what the sensors make of a state: the true values and the contributions of the sensor
effects. Noise, quantisation and calibration come after it, see ``rig.sensors``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import friction
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, in_turn, inner
from pneu_rig_ros.model.compiled_model import (
    CompiledModel,
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
    parts: dict[Balance, list[Part]] = {balance: [] for balance in Balance}
    ends = accumulate((len(effect.states) for effect in effects), initial=first_state)
    states = list(pairwise(ends))
    for index in sorted(range(len(effects)), key=lambda i: effects[i].stage):
        effect = effects[index]
        parts[effect.balance].append(Part(effect, index, *states[index]))
    return {balance: _sum(balance, own) for balance, own in parts.items()}


@dataclass(frozen=True)
class Part:
    """
    An effect in the sum of its balance.

    :param index: among the effects
    :param start, end: first and end index of its states
    """

    effect: Effect
    index: int
    start: int
    end: int

    @property
    def call(self) -> str:
        """Statement that assigns the contributions to a and b."""
        values = range(VALUES, VALUES + len(self.effect.null))
        own = f'own_{self.index}({", ".join(f"row[{i}]" for i in values)})'
        states = ''
        if self.effect.as_array:
            own = f'row[{values.start}:{values.stop}]'
        if self.effect.takes_states:
            states = f', state[{self.start}:{self.end}], rate[{self.start}:{self.end}]'
        return f'a, b = contribution_{self.index}(seen, model, {own}{states})'


def _sum(balance: Balance, parts: Sequence[Part]) -> Contribution:
    """
    Return the sum over the effects of one balance, in the order of their stages.

    An effect that does not act costs next to nothing. All are written out in one function, as each
    function of its own takes time to compile.
    """
    blocks: dict[str, Any] = {'factors': factors}
    seen = 'signals'
    if balance in CHAINS:
        blocks['behind'], seen = CHAINS[balance], 'behind(signals, total[0], total[1])'
    steps = []
    for part in parts:
        blocks[f'own_{part.index}'] = part.effect.parameters
        blocks[f'contribution_{part.index}'] = part.effect.contribution
        steps += [
            f'row = model.effects[{part.index}]',
            f'if row[{ACTS}] != 0.0:',
            f'    seen = {seen}',
            f'    {part.call}',
            f'    if row[{COUNT}] != 0.0:',
            '        factor_1, factor_2 = factors(row, seen, model.gas)',
            '        a, b = factor_1 * a, factor_2 * b',
            '    total = total[0] + a, total[1] + b',
        ]
    given = 'signals, model, state, rate'
    return inner(in_turn(f'sum_{balance.name}', given, 'total = 0.0, 0.0', steps, blocks))


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
