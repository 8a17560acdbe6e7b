"""
Adaptive integration of the hybrid system, with dense output.

Steps are as long as the tolerance allows and may reach beyond the time asked for; the state there
is interpolated. When the voltages change, the step under way is cut at that time. A run is
therefore the same to the last bit, whether it is advanced sample by sample or in one call.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats, Integers
from pneu_rig_ros.model import chambers, events, friction
from pneu_rig_ros.model.compiled import compiled, inner, inner_called
from pneu_rig_ros.model.compiled_model import CompiledEffects, CompiledModel, air
from pneu_rig_ros.model.dynamics import (
    ANCHORS,
    ARROW_SIZE,
    CONTACT,
    DEFLECTION,
    GAS_MASS_1,
    HELD_DWELL,
    HELD_STATIC,
    POSITION,
    PRESSURE_1,
    REST_START,
    STICKING,
    VELOCITY,
    RightHandSide,
)
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.rosenbrock import ORDER, build_step
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

START, END, SUGGESTED, NOW = range(4)
STEPS, REJECTED, EVALUATIONS, EVENTS, PENDING = range(5)

LARGEST_ERROR = 1e12
"""Stands for any larger error, and for one that is not a number [-]."""
SAFETY, SMALLEST_FACTOR, LARGEST_FACTOR = 0.85, 0.2, 4.0
AFTER_EVENT = 1e-4
"""Longest step tried right after something jumped [s]."""
SHORTEST = 1e-10
"""A step this short is accepted whatever its error [s]; jumps of the level g need it."""

BACKLASH = 10.0
"""Way that the bristle may go back unnoticed, in local errors of its deflection [-]."""
MOST_AIMS = 4
"""How often a step is aimed at an event before it is halved instead."""

EXTRA_NAMES = ('acceleration', 'sticking', 'contact', 'rest_start')
ACCELERATION = 0


class IntegratorState(NamedTuple):
    """
    Everything an integration under way consists of.

    :param clock: start and end of the present step, next step, present time [s], shape (4,); a
        step that ends at infinity has led to states that are not numbers
    :param counts: steps, rejected steps, evaluations, events, pending event code, shape (5,)
    :param y0, f0, y1, f1: state and rate at both ends of the present step, shape (n,)
    :param arrow: Jacobian entries and auxiliary output at the end
    :param memory: what jumps, see ``dynamics``
    :param voltages: u1, u2 [V] of the present step
    :param scale: error weights, full scale of each state, shape (n,)
    :param work: scratch, shape (5, n), and for the arrow
    """

    clock: Floats
    counts: Integers
    y0: Floats
    f0: Floats
    y1: Floats
    f1: Floats
    arrow: Floats
    memory: Floats
    voltages: Floats
    scale: Floats
    work: Floats
    work_arrow: Floats


@compiled
def copy(source: Floats, target: Floats) -> None:
    """Write one array into another of the same length."""
    for i in range(len(source)):
        target[i] = source[i]


@compiled
def interpolate(carry: IntegratorState, time: float, out: Floats) -> None:
    """Write the state at ``time`` [s] within the present step into ``out``, shape (n,)."""
    start, end = carry.clock[START], carry.clock[END]
    if time >= end:
        copy(carry.y1, out)
        return
    h = end - start
    share = (time - start) / h
    y0, f0, y1, f1 = carry.y0, carry.f0, carry.y1, carry.f1
    for i in range(len(out)):
        out[i] = events.hermite(y0[i], h * f0[i], y1[i], h * f1[i], share)


@compiled
def interpolate_acceleration(carry: IntegratorState, time: float) -> float:
    """Return dv/dt [m/s^2] at ``time`` [s]: linear within the present step."""
    start, end = carry.clock[START], carry.clock[END]
    share = 1.0 if time >= end else (time - start) / (end - start)
    before, after = float(carry.f0[VELOCITY]), float(carry.f1[VELOCITY])
    return before + share * (after - before)


@compiled
def error_norm(error: Floats, scale: Floats, tolerance: float) -> float:
    """Return the largest local error in multiples of the tolerance [-]."""
    largest = 0.0
    for i in range(len(error)):
        ratio = abs(error[i]) / (tolerance * scale[i])
        if not ratio <= largest:  # also true for NaN
            largest = ratio if ratio < LARGEST_ERROR else LARGEST_ERROR
    return largest


@compiled
def step_factor(ratio: float) -> float:
    """Return how much longer the next step may be [-] after an error of ``ratio`` tolerances."""
    if ratio < 1e-6:
        return LARGEST_FACTOR
    factor = SAFETY * math.pow(ratio, -1.0 / ORDER)
    return min(max(factor, SMALLEST_FACTOR), LARGEST_FACTOR)


def build_evaluate(right_hand_side: RightHandSide) -> Callable[..., None]:
    """Return the compiled evaluation of the rates where the present step ends."""

    @inner_called
    def evaluate(carry: IntegratorState, model: CompiledModel, effects: CompiledEffects) -> None:
        y1, f1, arrow, memory = carry.y1, carry.f1, carry.arrow, carry.memory
        right_hand_side(carry.clock[END], y1, f1, arrow, memory, carry.voltages, model, effects)
        carry.counts[EVALUATIONS] += 1

    return evaluate


@compiled
def cut(carry: IntegratorState) -> None:
    """End the step under way at the present time; the rates there must be evaluated again."""
    now = carry.clock[NOW]
    if now < carry.clock[END]:
        interpolate(carry, now, carry.work[0])
        copy(carry.work[0], carry.y1)
        carry.clock[END] = now
        carry.counts[PENDING] = events.NONE  # what would have happened beyond it does not


def build_advance(
    right_hand_side: RightHandSide, evaluate: Callable[..., None]
) -> Callable[..., None]:
    """Return the compiled step that is accepted: short enough, and not beyond an event."""
    try_step = build_step(right_hand_side)

    @inner
    def advance(
        carry: IntegratorState,
        tolerance: float,
        longest: float,
        model: CompiledModel,
        effects: CompiledEffects,
    ) -> None:
        clock, counts, memory, error = carry.clock, carry.counts, carry.memory, carry.work[4]
        y0, f0, before = carry.y0, carry.f0, carry.work_arrow
        y1, f1, arrow = carry.y1, carry.f1, carry.arrow
        work, held = carry.work, carry.voltages
        if counts[PENDING] != events.NONE:
            events.apply_event(counts[PENDING], clock[END], y1, memory, arrow, model)
            counts[PENDING] = events.NONE
            counts[EVENTS] += 1
            clock[SUGGESTED] = min(clock[SUGGESTED], AFTER_EVENT)
            evaluate(carry, model, effects)
        copy(y1, y0)
        copy(f1, f0)
        copy(arrow, before)
        time, h, aims = clock[END], min(clock[SUGGESTED], longest), 0
        backlash = BACKLASH * tolerance * carry.scale[DEFLECTION]
        while True:
            try_step(
                time, h, y0, f0, before, y1, f1, arrow, error, work, memory, held, model, effects
            )
            counts[EVALUATIONS] += 4
            ratio = error_norm(error, carry.scale, tolerance)
            if ratio > 1.0 and h > SHORTEST:
                h, aims = max(h * step_factor(ratio), SHORTEST), 0
            else:
                code, share, met = events.locate_event(
                    h, y0, f0, y1, f1, before, arrow, memory, backlash, model
                )
                if code == events.NONE or met or h <= SHORTEST:
                    break
                # Interpolation aims at the event; a few aims meet it, unless the step is not as
                # smooth as the cubic through its ends. Then halving closes in on it.
                aims += 1
                h = max(h * share * (1.0 if aims <= MOST_AIMS else 0.5), SHORTEST)
            counts[REJECTED] += 1
        counts[STEPS] += 1
        lost = ratio == LARGEST_ERROR  # non-finite state: the run ends here
        clock[START], clock[END] = time, math.inf if lost else time + h
        counts[PENDING] = code if code != events.REVERSAL else events.NONE
        events.update_anchors(y1, memory, model)
        if aims == 0:
            clock[SUGGESTED] = h * step_factor(ratio)
        else:  # cut for the event, so its error does not limit the next step
            clock[SUGGESTED] = min(clock[SUGGESTED], max(LARGEST_FACTOR * h, AFTER_EVENT))

    return advance


@compiled
def sample(carry: IntegratorState, time: float, state: Floats, extra: Floats) -> None:
    """Write the state and its extras at ``time`` [s] within the present step."""
    interpolate(carry, time, state)
    extra[0] = interpolate_acceleration(carry, time)
    extra[1] = carry.memory[STICKING]
    extra[2] = carry.memory[CONTACT]
    extra[3] = carry.memory[REST_START]


def initial_state(
    model: Model, arguments: CompiledModel, size: int, temperatures: tuple[float, float]
) -> IntegratorState:
    """
    Return the carry of a piston that has rested for ``rest_time`` at its initial position.

    :param temperatures: of the gas in both chambers [K]
    """
    operation, law = model.operation, model.friction
    volumes = chambers.volumes(operation.initial_position, model.cylinder)
    pressures = operation.initial_pressure_1, operation.initial_pressure_2
    y1 = np.zeros(size)
    y1[POSITION] = operation.initial_position
    for i in range(2):
        mass = chambers.gas_mass(pressures[i], volumes[i], temperatures[i], arguments.gas)
        y1[PRESSURE_1 + i], y1[GAS_MASS_1 + i] = pressures[i], mass
    memory = np.zeros(ANCHORS + len(law.element_stiffness))
    memory[STICKING], memory[REST_START] = 1.0, -operation.rest_time
    memory[HELD_DWELL] = operation.rest_time
    memory[HELD_STATIC] = friction.static_friction(
        operation.rest_time, law.breakaway_force, law.coulomb_force, arguments.friction
    )
    return IntegratorState(
        clock=np.array([0.0, 0.0, AFTER_EVENT, 0.0]),
        counts=np.zeros(5, dtype=np.int64),
        y0=y1.copy(),
        f0=np.zeros(size),
        y1=y1,
        f1=np.zeros(size),
        arrow=np.zeros(ARROW_SIZE),
        memory=memory,
        voltages=np.full(2, CENTRE_VOLTAGE),
        scale=full_scale(model, size),
        work=np.zeros((5, size)),
        work_arrow=np.zeros(ARROW_SIZE),
    )


def full_scale(model: Model, size: int) -> Floats:
    """Return the full scale of each state, the unit of the local error, shape (size,)."""
    pressure = model.operation.supply_pressure
    stiffness = sum(model.friction.element_stiffness)
    level = max(model.friction.breakaway_force, model.friction.coulomb_force)
    cylinder = model.cylinder
    volume = cylinder.cap_dead_volume + cylinder.cap_area * cylinder.stroke
    mass = chambers.gas_mass(pressure, volume, model.gas.supply_temperature, air(model.gas))
    scale = np.ones(size)
    scale[:8] = cylinder.stroke, 1.0, pressure, pressure, level / stiffness, 1.0, mass, mass
    return scale
