"""The compiled run of a plant over many sampling intervals, freely or along a measured run."""

from collections.abc import Callable

from pneu_rig_ros.arrays import Floats, Integers
from pneu_rig_ros.model.compiled import inner
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.dynamics import CONTACT, FREE_ACCELERATION, HELD, RightHandSide
from pneu_rig_ros.model.imposed import build_act
from pneu_rig_ros.model.integrator import (
    ACCELERATION,
    END,
    NOW,
    IntegratorState,
    build_advance,
    build_evaluate,
    copy,
    cut,
    sample,
)


def build_run(right_hand_side: RightHandSide) -> Callable[..., None]:
    """
    Return the compiled run over many sampling intervals.

    ``run(carry, interval, first, voltages, actions, measured, rests, states, extras, tolerance,
    longest, model, effects)`` holds each row of ``voltages``, shape (m, 2), for one interval [s].
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
        carry: IntegratorState,
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
        effects: tuple[object, ...],
    ) -> None:
        held = carry.voltages
        for i in range(len(voltages)):
            imposed = len(actions) > 0 and actions[i] != 0
            if imposed or voltages[i, 0] != held[0] or voltages[i, 1] != held[1]:
                cut(carry)
                copy(voltages[i], held)
                evaluate(carry, model, effects)
                if imposed:
                    act(carry, actions[i], measured[i], rests[i], model, effects)
            # steps may reach beyond the sample, which is interpolated
            target = (first + i + 1) * interval
            while carry.clock[END] < target:
                advance(carry, tolerance, longest, model, effects)
            carry.clock[NOW] = target
            sample(carry, target, states[i], extras[i])
            if carry.memory[CONTACT] == HELD:
                extras[i, ACCELERATION] = carry.arrow[FREE_ACCELERATION]

    return run
