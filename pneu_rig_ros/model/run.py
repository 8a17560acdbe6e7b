"""
The compiled run of a plant over many sampling intervals: free, or keeping to a measured run.

The plant is restarted from the measured run, or its motion or pressures are imposed. What a
measured signal imposes is no longer predicted, so that the other balances can be examined alone;
what is restarted at every rest is predicted over one stick-slip cycle only. All that cannot be
measured - film, dwell clock, states of the effects - is carried on.
"""

from collections.abc import Callable
from enum import IntFlag, auto

from pneu_rig_ros.arrays import Floats, Integers
from pneu_rig_ros.model import chambers, events
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, inner, inner_called
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.dynamics import RightHandSide
from pneu_rig_ros.model.integrator import (
    ACCELERATION,
    build_advance,
    build_evaluate,
    copy,
    cut,
    sample,
)


class Impose(IntFlag):
    """
    What to do at a sample of a measured run, to be combined.

    Compiled code takes the ``value`` of a flag, as Numba knows no flags.
    """

    RESTART = auto()
    """Restart from the measured position and pressures at rest."""
    MOTION = auto()
    """Impose the measured motion until the next sample."""
    PRESSURES = auto()
    """Impose the measured pressures at this sample."""
    HOLD = auto()
    """
    Go on from the measured position, creep and pressures, the bristle holding the piston, whatever
    the model makes of it.
    """
    BREAK = auto()
    """With HOLD: the piston has broken away meanwhile, some time ago."""
    RELEASE = auto()
    """No longer impose anything."""
    STOP = auto()
    """With RESTART: the end stop next to the measured position holds the piston."""


BALANCING_ROUNDS = 3
"""Newton steps towards the bristle deflection that holds the driving force."""
LEAST_STIFFNESS = 1e-3
"""Of the bristle, relative to inertia [1/s^2], below which nothing is balanced."""


@compiled
def set_pressures(state: Floats, p1: float, p2: float) -> None:
    """
    Set the absolute pressures [Pa] at unchanged gas temperatures; changes ``state``.

    A pressure that is not a number is not known and stays as it is.
    """
    if p1 == p1:
        state[at.GAS_MASS_1] *= p1 / state[at.PRESSURE_1]
        state[at.PRESSURE_1] = p1
    if p2 == p2:
        state[at.GAS_MASS_2] *= p2 / state[at.PRESSURE_2]
        state[at.PRESSURE_2] = p2


@compiled
def set_position(state: Floats, position: float, model: CompiledModel) -> None:
    """Move the piston to a position [m] at unchanged pressures; changes ``state``."""
    inside = min(max(position, 0.0), model.cylinder.stroke)
    old_1, old_2 = chambers.volumes(state[at.POSITION], model.cylinder)
    new_1, new_2 = chambers.volumes(inside, model.cylinder)
    state[at.GAS_MASS_1] *= new_1 / old_1
    state[at.GAS_MASS_2] *= new_2 / old_2
    state[at.POSITION] = inside


def build_balance(evaluate: Callable[..., None]) -> Callable[..., None]:
    """Return the compiled balance of a piston that does not accelerate."""

    @inner_called
    def balance(carry: at.IntegratorState, model: CompiledModel) -> None:
        """Deflect the bristle until it holds the driving force (Newton's method)."""
        for _ in range(BALANCING_ROUNDS):
            evaluate(carry, model)
            state, rate, arrow = carry.end.state, carry.end.rate, carry.end.arrow
            if arrow[at.V_Z] < -LEAST_STIFFNESS:
                state[at.DEFLECTION] -= rate[at.VELOCITY] / arrow[at.V_Z]

    return balance


def build_restart(balance: Callable[..., None]) -> Callable[..., None]:
    """Return the compiled restart from rest at a measured position and pressures."""

    @compiled
    def restart(
        carry: at.IntegratorState,
        at_stop: bool,
        measured: Floats,
        rest: float,
        model: CompiledModel,
    ) -> None:
        state, memory = carry.end.state, carry.end.memory
        position, stop = measured[0], 0.0
        slow = abs(state[at.VELOCITY]) < model.friction.start_velocity
        if at_stop:
            stop = 1.0 if position > 0.5 * model.cylinder.stroke else -1.0
            position = 0.5 * (1.0 + stop) * model.cylinder.stroke
        set_pressures(state, measured[2], measured[3])
        set_position(state, position, model)
        if slow and stop == 0.0 and memory[at.CONTACT] == 0.0:
            return  # the model slows down too: when it rests is for it to decide
        if memory[at.STICKING] == 0.0:
            events.enter_rest(rest, memory, model.friction)
        memory[at.CONTACT], state[at.VELOCITY] = stop, 0.0
        if stop == 0.0:
            balance(carry, model)

    return restart


def build_act(evaluate: Callable[..., None]) -> Callable[..., None]:
    """
    Return the compiled changes of state before an interval.

    :param evaluate: see ``integrator.build_evaluate``
    """
    balance = build_balance(evaluate)
    restart = build_restart(balance)

    @inner_called
    def act(
        carry: at.IntegratorState, action: int, measured: Floats, rest: float, model: CompiledModel
    ) -> None:
        state, memory = carry.end.state, carry.end.memory
        if action & Impose.BREAK.value and memory[at.STICKING] != 0.0:
            events.break_away(rest, memory, carry.end.arrow[at.GROWN_STATIC], model.friction)
        if action & Impose.RESTART.value:
            at_stop = action & Impose.STOP.value != 0
            restart(carry, at_stop, measured, rest, model)
        if action & Impose.HOLD.value:
            set_position(state, measured[0], model)
            set_pressures(state, measured[2], measured[3])
            state[at.VELOCITY], memory[at.CONTACT] = measured[1], 0.0
            balance(carry, model)
        if action & Impose.MOTION.value:
            set_position(state, measured[0], model)
            state[at.VELOCITY], memory[at.CONTACT] = measured[1], at.HELD
        elif memory[at.CONTACT] == at.HELD:
            memory[at.CONTACT] = 0.0
        if action & Impose.PRESSURES.value:
            set_pressures(state, measured[2], measured[3])
        evaluate(carry, model)

    return act


def build_run(right_hand_side: RightHandSide) -> Callable[..., None]:
    """
    Return the compiled run over many sampling intervals.

    ``run(carry, interval, first, voltages, actions, measured, rests, states, extras, tolerance,
    longest, model)`` holds each row of ``voltages``, shape (m, 2), for one interval [s].
    Sample number ``first + i + 1`` is at exactly that multiple of the interval; it goes to
    ``states[i]``, shape (m, n), and ``extras[i]``, shape (m, 4), see ``EXTRA_NAMES``.

    Before interval i, ``actions[i]`` is done, see ``Impose``, with ``measured[i]``, (x, v, p1, p2)
    in SI units and corrected for the sensors, and ``rests[i]``, the time at which the rest began
    [s], or with HOLD and BREAK the slide before it. Of a free run these three are empty. Where
    the motion is imposed, the acceleration in ``extras`` is the one that the forces would give a
    free piston.
    """
    evaluate = build_evaluate(right_hand_side)
    advance, act = build_advance(right_hand_side, evaluate), build_act(evaluate)

    @inner
    def run(
        carry: at.IntegratorState,
        interval: float,
        first: int,
        voltages: Floats,
        actions: Integers,
        measured: Floats,
        rests: Floats,
        states: Floats,
        extras: Floats,
        tolerance: float,
        longest: float,
        model: CompiledModel,
    ) -> None:
        held = carry.end.voltages
        for i in range(len(voltages)):
            imposed = len(actions) > 0 and actions[i] != 0
            if imposed or voltages[i, 0] != held[0] or voltages[i, 1] != held[1]:
                cut(carry)
                copy(voltages[i], held)
                evaluate(carry, model)
                if imposed:
                    act(carry, actions[i], measured[i], rests[i], model)
            # steps may reach beyond the sample, which is interpolated
            target = (first + i + 1) * interval
            while carry.clock[at.END] < target:
                advance(carry, tolerance, longest, model)
            carry.clock[at.NOW] = target
            sample(carry, target, states[i], extras[i])
            if carry.end.memory[at.CONTACT] == at.HELD:
                extras[i, ACCELERATION] = carry.end.arrow[at.FREE_ACCELERATION]

    return run
