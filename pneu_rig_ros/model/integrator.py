"""
Adaptive integration of the hybrid system, with dense output.

Steps are as long as the tolerance allows and may reach beyond the time asked for; the state there
is interpolated. When the voltages change, the step under way is cut at that time. A run is
therefore the same to the last bit, whether it is advanced sample by sample or in one call.
"""

import math
from collections.abc import Callable

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import chambers, events, friction
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, inner, inner_called
from pneu_rig_ros.model.compiled_model import CompiledModel, air
from pneu_rig_ros.model.dynamics import RightHandSide
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.rosenbrock import ORDER, build_step
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

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


@compiled
def copy(source: Floats, target: Floats) -> None:
    """Write one array into another of the same length."""
    for i in range(len(source)):
        target[i] = source[i]


@compiled
def interpolate(carry: at.IntegratorState, time: float, out: Floats) -> None:
    """Write the state at ``time`` [s] within the present step into ``out``, shape (n,)."""
    start, end = carry.clock[at.START], carry.clock[at.END]
    if time >= end:
        copy(carry.end.state, out)
        return
    h = end - start
    share = (time - start) / h
    y0, f0, y1, f1 = carry.y0, carry.f0, carry.end.state, carry.end.rate
    for i in range(len(out)):
        out[i] = events.hermite(y0[i], h * f0[i], y1[i], h * f1[i], share)


@compiled
def interpolate_acceleration(carry: at.IntegratorState, time: float) -> float:
    """Return dv/dt [m/s^2] at ``time`` [s]: linear within the present step."""
    start, end = carry.clock[at.START], carry.clock[at.END]
    share = 1.0 if time >= end else (time - start) / (end - start)
    before, after = float(carry.f0[at.VELOCITY]), float(carry.end.rate[at.VELOCITY])
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
    def evaluate(carry: at.IntegratorState, model: CompiledModel) -> None:
        right_hand_side(carry.clock[at.END], carry.end, model)
        carry.counts[at.EVALUATIONS] += 1

    return evaluate


@compiled
def cut(carry: at.IntegratorState) -> None:
    """End the step under way at the present time; the rates there must be evaluated again."""
    now = carry.clock[at.NOW]
    if now < carry.clock[at.END]:
        interpolate(carry, now, carry.work[0])
        copy(carry.work[0], carry.end.state)
        carry.clock[at.END] = now
        carry.counts[at.PENDING] = events.NONE  # what would have happened beyond it does not


def build_advance(
    right_hand_side: RightHandSide, evaluate: Callable[..., None]
) -> Callable[..., None]:
    """Return the compiled step that is accepted: short enough, and not beyond an event."""
    try_step = build_step(right_hand_side)

    @inner
    def advance(
        carry: at.IntegratorState, tolerance: float, longest: float, model: CompiledModel
    ) -> None:
        clock, counts, end = carry.clock, carry.counts, carry.end
        if counts[at.PENDING] != events.NONE:
            events.apply_event(counts[at.PENDING], clock[at.END], end, model)
            counts[at.PENDING] = events.NONE
            counts[at.EVENTS] += 1
            clock[at.SUGGESTED] = min(clock[at.SUGGESTED], AFTER_EVENT)
            evaluate(carry, model)
        copy(end.state, carry.y0)
        copy(end.rate, carry.f0)
        copy(end.arrow, carry.arrow_0)
        time, h, aims = clock[at.END], min(clock[at.SUGGESTED], longest), 0
        backlash = BACKLASH * tolerance * carry.scale[at.DEFLECTION]
        while True:
            try_step(time, h, carry, model)
            counts[at.EVALUATIONS] += 4
            ratio = error_norm(carry.work[4], carry.scale, tolerance)
            if ratio > 1.0 and h > SHORTEST:
                h, aims = max(h * step_factor(ratio), SHORTEST), 0
            else:
                code, share, met = events.locate_event(h, carry, backlash, model)
                if code == events.NONE or met or h <= SHORTEST:
                    break
                # Interpolation aims at the event; a few aims meet it, unless the step is not as
                # smooth as the cubic through its ends. Then halving closes in on it.
                aims += 1
                h = max(h * share * (1.0 if aims <= MOST_AIMS else 0.5), SHORTEST)
            counts[at.REJECTED] += 1
        counts[at.STEPS] += 1
        lost = ratio == LARGEST_ERROR  # non-finite state: the run ends here
        clock[at.START], clock[at.END] = time, math.inf if lost else time + h
        counts[at.PENDING] = code if code != events.REVERSAL else events.NONE
        events.update_anchors(end, model)
        if aims == 0:
            clock[at.SUGGESTED] = h * step_factor(ratio)
        else:  # cut for the event, so its error does not limit the next step
            clock[at.SUGGESTED] = min(clock[at.SUGGESTED], max(LARGEST_FACTOR * h, AFTER_EVENT))

    return advance


@compiled
def sample(carry: at.IntegratorState, time: float, state: Floats, extra: Floats) -> None:
    """Write the state and its extras at ``time`` [s] within the present step."""
    interpolate(carry, time, state)
    extra[0] = interpolate_acceleration(carry, time)
    extra[1] = carry.end.memory[at.STICKING]
    extra[2] = carry.end.memory[at.CONTACT]
    extra[3] = carry.end.memory[at.REST_START]


def initial_state(
    model: Model, arguments: CompiledModel, size: int, temperatures: tuple[float, float]
) -> at.IntegratorState:
    """
    Return the carry of a piston that has rested for ``rest_time`` at its initial position.

    :param temperatures: of the gas in both chambers [K]
    """
    operation, law = model.operation, model.friction
    volumes = chambers.volumes(operation.initial_position, model.cylinder)
    pressures = operation.initial_pressure_1, operation.initial_pressure_2
    y1 = np.zeros(size)
    y1[at.POSITION] = operation.initial_position
    for i in range(2):
        mass = chambers.gas_mass(pressures[i], volumes[i], temperatures[i], arguments.gas)
        y1[at.PRESSURE_1 + i], y1[at.GAS_MASS_1 + i] = pressures[i], mass
    memory = np.zeros(at.ANCHORS + len(law.element_stiffness))
    memory[at.STICKING], memory[at.REST_START] = 1.0, -operation.rest_time
    memory[at.HELD_DWELL] = operation.rest_time
    memory[at.HELD_STATIC] = friction.static_friction(
        operation.rest_time, law.breakaway_force, law.coulomb_force, arguments.friction
    )
    voltages = np.full(2, CENTRE_VOLTAGE)
    return at.IntegratorState(
        clock=np.array([0.0, 0.0, AFTER_EVENT, 0.0]),
        counts=np.zeros(5, dtype=np.int64),
        y0=y1.copy(),
        f0=np.zeros(size),
        arrow_0=np.zeros(at.ARROW_SIZE),
        end=at.Point(y1, np.zeros(size), np.zeros(at.ARROW_SIZE), memory, voltages),
        scale=full_scale(model, size),
        work=np.zeros((5, size)),
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
