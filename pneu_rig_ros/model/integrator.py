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

from pneu_rig_ros.model import events
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.dynamics import (
    CONTACT,
    DEFLECTION,
    REST_START,
    STICKING,
    VELOCITY,
    Array,
    RightHandSide,
)
from pneu_rig_ros.model.rosenbrock import ORDER, build_step

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


class Carry(NamedTuple):
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
    :param work: scratch, shape (7, n), and for the arrow
    """

    clock: Array
    counts: np.ndarray[tuple[int], np.dtype[np.int64]]
    y0: Array
    f0: Array
    y1: Array
    f1: Array
    arrow: Array
    memory: Array
    voltages: Array
    scale: Array
    work: Array
    work_arrow: Array


@compiled
def copy(source: Array, target: Array) -> None:
    """Write one array into another of the same length."""
    for i in range(len(source)):
        target[i] = source[i]


@compiled
def interpolate(carry: Carry, time: float, out: Array) -> None:
    """Write the state at ``time`` [s] within the present step into ``out``, shape (n,)."""
    start, end = carry.clock[START], carry.clock[END]
    if time >= end:
        copy(carry.y1, out)
        return
    h = end - start
    share = (time - start) / h
    rest = 1.0 - share
    across = share * rest
    for i in range(len(out)):
        rise = carry.y1[i] - carry.y0[i]
        bend = (h * carry.f0[i] - rise) * rest - (h * carry.f1[i] - rise) * share
        out[i] = carry.y0[i] + share * rise + across * bend


@compiled
def interpolate_acceleration(carry: Carry, time: float) -> float:
    """Return dv/dt [m/s^2] at ``time`` [s]: linear within the present step."""
    start, end = carry.clock[START], carry.clock[END]
    share = 1.0 if time >= end else (time - start) / (end - start)
    before, after = float(carry.f0[VELOCITY]), float(carry.f1[VELOCITY])
    return before + share * (after - before)


@compiled
def error_norm(error: Array, scale: Array, tolerance: float) -> float:
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


def build_start(right_hand_side: RightHandSide) -> Callable[..., None]:
    """Return the compiled evaluation of the rates where the present step ends."""
    rhs = right_hand_side

    @compiled
    def start(carry: Carry, model: CompiledModel, effects: tuple[object, ...]) -> None:
        rhs(
            carry.clock[END], carry.y1, carry.f1, carry.arrow, carry.memory, carry.voltages,
            model, effects,
        )  # fmt: skip
        carry.counts[EVALUATIONS] += 1

    return start


def build_cut(start: Callable[..., None]) -> Callable[..., None]:
    """Return the compiled change of voltages: the step under way ends at the present time."""

    @compiled
    def cut(
        carry: Carry, voltages: Array, model: CompiledModel, effects: tuple[object, ...]
    ) -> None:
        now = carry.clock[NOW]
        if now < carry.clock[END]:
            interpolate(carry, now, carry.work[0])
            copy(carry.work[0], carry.y1)
            carry.clock[END] = now
            carry.counts[PENDING] = events.NONE
        copy(voltages, carry.voltages)
        start(carry, model, effects)

    return cut


def build_advance(
    right_hand_side: RightHandSide, start: Callable[..., None]
) -> Callable[..., None]:
    """Return the compiled step that is accepted: short enough, and not beyond an event."""
    try_step = build_step(right_hand_side)

    @compiled
    def jump(carry: Carry, model: CompiledModel, effects: tuple[object, ...]) -> None:
        time, code = carry.clock[END], carry.counts[PENDING]
        events.apply(code, time, carry.y1, carry.memory, carry.arrow, model)
        carry.counts[PENDING] = events.NONE
        carry.counts[EVENTS] += 1
        carry.clock[SUGGESTED] = min(carry.clock[SUGGESTED], AFTER_EVENT)
        start(carry, model, effects)

    @compiled
    def advance(
        carry: Carry, tolerance: float, longest: float, model: CompiledModel,
        effects: tuple[object, ...],
    ) -> None:  # fmt: skip
        clock, counts, error = carry.clock, carry.counts, carry.work[6]
        if counts[PENDING] != events.NONE:
            jump(carry, model, effects)
        copy(carry.y1, carry.y0)
        copy(carry.f1, carry.f0)
        copy(carry.arrow, carry.work_arrow)
        time, h, aims = clock[END], min(clock[SUGGESTED], longest), 0
        backlash = BACKLASH * tolerance * carry.scale[DEFLECTION]
        while True:
            try_step(
                time, h, carry.y0, carry.f0, carry.work_arrow, carry.y1, carry.f1, carry.arrow,
                error, carry.work, carry.memory, carry.voltages, model, effects,
            )  # fmt: skip
            counts[EVALUATIONS] += 4
            ratio = error_norm(error, carry.scale, tolerance)
            if ratio > 1.0 and h > SHORTEST:
                h, aims = max(h * step_factor(ratio), SHORTEST), 0
            else:
                code, share, met = events.find(
                    h,
                    carry.y0,
                    carry.f0,
                    carry.y1,
                    carry.f1,
                    carry.work_arrow,
                    carry.arrow,
                    carry.memory,
                    backlash,
                    model,
                )
                if code == events.NONE or met or h <= SHORTEST:
                    break
                aims += 1  # an aim that keeps missing by little is replaced by halving
                h = max(h * share * (1.0 if aims <= MOST_AIMS else 0.5), SHORTEST)
            counts[REJECTED] += 1
        counts[STEPS] += 1
        lost = ratio == LARGEST_ERROR  # not a number: there is nowhere to go on from
        clock[START], clock[END] = time, math.inf if lost else time + h
        counts[PENDING] = code if code != events.REVERSAL else events.NONE
        events.remember(carry.y1, carry.memory, model)
        if aims == 0:
            clock[SUGGESTED] = h * step_factor(ratio)
        else:
            clock[SUGGESTED] = min(clock[SUGGESTED], max(LARGEST_FACTOR * h, AFTER_EVENT))

    return advance


@compiled
def sample(carry: Carry, time: float, state: Array, extra: Array) -> None:
    """Write the state and its extras at ``time`` [s] within the present step."""
    interpolate(carry, time, state)
    extra[0] = interpolate_acceleration(carry, time)
    extra[1] = carry.memory[STICKING]
    extra[2] = carry.memory[CONTACT]
    extra[3] = carry.memory[REST_START]


def build_run(cut: Callable[..., None], advance: Callable[..., None]) -> Callable[..., None]:
    """
    Return the compiled run over many sampling intervals.

    ``run(carry, interval, first, voltages, states, extras, tolerance, longest, model, effects)``
    holds each row of ``voltages``, shape (m, 2), for one interval [s]. Sample number
    ``first + i + 1`` is at exactly that multiple of the interval; it goes to ``states[i]``, shape
    (m, n), and ``extras[i]``, shape (m, 4), see ``EXTRA_NAMES``.
    """

    @compiled
    def run(
        carry: Carry,
        interval: float,
        first: int,
        voltages: Array,
        states: Array,
        extras: Array,
        tolerance: float,
        longest: float,
        model: CompiledModel,
        effects: tuple[object, ...],
    ) -> None:
        clock, held = carry.clock, carry.voltages
        for i in range(len(voltages)):
            if voltages[i, 0] != held[0] or voltages[i, 1] != held[1]:
                cut(carry, voltages[i], model, effects)
            target = (first + i + 1) * interval
            while clock[END] < target:
                advance(carry, tolerance, longest, model, effects)
            clock[NOW] = target
            sample(carry, target, states[i], extras[i])

    return run
