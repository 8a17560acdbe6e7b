"""
General-purpose solvers on the plant's own compiled right-hand side.

SciPy's LSODA and Radau and SUNDIALS CVODE integrate the smooth stretches; between them the events
are located by the solver's own root finding and carried out here, independently of the package's
integrator; only what the seal remembers is noted by the model's own functions. Radau at 1e-10 is
the reference of the accuracy figures and of the tests.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import events
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled_model import CompiledModel, compiled_model
from pneu_rig_ros.model.plant import Plant

Into = Callable[[float, Floats, Floats, Floats], None]
"""Takes time, state, where the values go, and memory."""
Stretch = tuple[Floats, Floats, float, Floats, int]
"""Times and states of the samples up to an event, its time, state and number; -1 is none."""
Solve = Callable[['Problem', float, Floats, Floats], Stretch]

BREAKAWAY, ARREST, TOUCH, RELEASE = range(4)


class Problem(NamedTuple):
    """A stroke at constant voltages, with compiled callbacks; ``memory`` changes under way."""

    model: CompiledModel
    memory: Floats
    resting: Floats
    initial: Floats
    scale: Floats
    rates: Into
    signs: Into
    auxiliary: Callable[[float, Floats, Floats], Floats]


def problem(plant: Plant, voltages: tuple[float, float]) -> Problem:
    """Return the stroke of a plant from rest, without effects and with one bristle element."""
    carry = plant.initial_integrator_state()
    model, memory = compiled_model(plant.model), carry.end.memory
    callbacks = _callbacks(plant.right_hand_side, model, voltages)
    return Problem(model, memory, memory.copy(), carry.end.state.copy(), carry.scale, *callbacks)


def _callbacks(rhs: Callable[..., None], model: CompiledModel, voltages: Any) -> Any:
    """Bind the model as a constant: unpacking it in every call would burden the peers."""
    held = np.array(voltages)
    stroke, stop = model.cylinder.stroke, model.friction.stop_velocity
    start = model.friction.start_velocity

    @njit(error_model='numpy')
    def rates(t, y, rate, memory):  # type: ignore[no-untyped-def]
        rhs(t, at.Point(y, rate, np.empty(at.ARROW_SIZE), memory, held), model)

    @njit(error_model='numpy')
    def auxiliary(t, y, memory):  # type: ignore[no-untyped-def]
        arrow = np.empty(at.ARROW_SIZE)
        rhs(t, at.Point(y, np.empty(at.STATE_SIZE), arrow, memory, held), model)
        return arrow

    @njit(error_model='numpy')
    def signs(t, y, values, memory):  # type: ignore[no-untyped-def]
        """Each value falls through zero at its event and is one while it cannot happen."""
        x, speed = y[at.POSITION], abs(y[at.VELOCITY])
        values[:] = 1.0
        if memory[at.CONTACT] != 0.0:
            arrow = auxiliary(t, y, memory)
            values[RELEASE] = memory[at.CONTACT] * arrow[at.FREE_ACCELERATION]
        else:
            if memory[at.STICKING] != 0.0:
                values[BREAKAWAY] = start - speed
            else:
                values[ARREST] = speed - stop
            values[TOUCH] = (
                min(x, stroke - x) if y[at.VELOCITY] * (x - 0.5 * stroke) > 0.0 else 1.0
            )

    return rates, signs, auxiliary


def carry_out(event: int, t: float, y: Floats, task: Problem) -> None:
    """Change state and memory at an event."""
    memory = task.memory
    resting = memory[at.STICKING] != 0.0
    if event == BREAKAWAY:
        grown = float(task.auxiliary(t, y, memory)[at.GROWN_STATIC])
        events.break_away(t, memory, grown, task.model.friction)
    elif event == ARREST or (event == TOUCH and not resting):
        events.enter_rest(t, memory, task.model.friction)
    if event == TOUCH:
        outer = y[at.POSITION] > 0.5 * task.model.cylinder.stroke
        y[at.POSITION], y[at.VELOCITY] = (task.model.cylinder.stroke if outer else 0.0), 0.0
        memory[at.CONTACT] = 1.0 if outer else -1.0
    elif event == RELEASE:
        memory[at.CONTACT] = 0.0


def scipy_solver(method: str, tolerance: float) -> Solve:
    """Return SciPy's ``solve_ivp`` with the method; its events end each stretch."""
    return partial(_solve_by_scipy, method, tolerance)


def _solve_by_scipy(
    method: str, tolerance: float, task: Problem, t: float, y: Floats, samples: Floats
) -> Stretch:
    def rates(time: float, state: Floats) -> Floats:
        rate = np.empty(len(state))
        task.rates(time, state, rate, task.memory)
        return rate

    def guard(index: int) -> Any:
        def value(time: float, state: Floats) -> float:
            values = np.empty(4)
            task.signs(time, state, values, task.memory)
            return float(values[index])

        value.terminal, value.direction = True, -1.0  # type: ignore[attr-defined]
        return value

    # SciPy's step for the numerical Jacobian overflows harmlessly where a column is zero
    with np.errstate(over='ignore'):
        solution = solve_ivp(
            rates,
            (t, samples[-1]),
            y,
            method=method,
            t_eval=samples,
            rtol=tolerance,
            atol=tolerance * task.scale,
            events=[guard(i) for i in range(4)],
        )
    # an empty list where an event comes before the first sample
    states = np.array(solution.y).reshape(len(y), -1).T
    for index, times in enumerate(solution.t_events or ()):
        if len(times):
            return solution.t, states, times[0], solution.y_events[index][0], index
    return solution.t, states, samples[-1], states[-1], -1


def cvode_solver(tolerance: float) -> Solve:
    """Return SUNDIALS CVODE (BDF); its root finding ends each stretch."""
    return partial(_solve_by_cvode, tolerance)


def _solve_by_cvode(
    tolerance: float, task: Problem, t: float, y: Floats, samples: Floats
) -> Stretch:
    def rates(time: float, state: Floats, rate: Floats) -> None:
        task.rates(time, state, rate, task.memory)

    def signs(time: float, state: Floats, values: Floats) -> None:
        task.signs(time, state, values, task.memory)

    signs.terminal, signs.direction = [True] * 4, [-1] * 4  # type: ignore[attr-defined]
    solver = CVODE(
        rates,
        rtol=tolerance,
        atol=tolerance * task.scale,
        eventsfn=signs,
        num_events=4,
        max_num_steps=1_000_000,
    )
    solution = solver.solve(np.concatenate([[t], samples]), y)
    kept = (solution.t > t) & np.isin(solution.t, samples)
    if solution.i_events is not None and len(solution.i_events):
        index = int(np.flatnonzero(solution.i_events[-1])[0])
        time, state = solution.t_events[-1], solution.y_events[-1].copy()
        return solution.t[kept], solution.y[kept], time, state, index
    return solution.t[kept], solution.y[kept], samples[-1], solution.y[-1].copy(), -1


def run(task: Problem, solve: Solve, samples: Floats) -> Floats:
    """
    Return the states at the sample times, shape (m, n), integrated from event to event.

    :param samples: times [s], shape (m,), all > 0
    """
    task.memory[:] = task.resting
    out = np.empty((len(samples), len(task.initial)))
    t, y, done = 0.0, task.initial.copy(), 0
    while done < len(samples):
        times, states, t, y, event = solve(task, t, y, samples[done:])
        out[done : done + len(times)] = states
        done += len(times)
        if event < 0:
            break
        carry_out(event, t, y, task)
    return out
