"""Friction of the second plant along a motion that is known, sample by sample."""

import numpy as np

from . import constants as at
from .foreign_force import slipped
from .kept import block, kept
from .motion import (
    drag,
    elements,
    film_rate,
    levels,
    share_left,
    static_after,
    static_force,
    stribeck,
)
from .second_force import sums_elements, viscous

ROUNDS = 20
"""Of Newton's method on the piecewise straight force of the bristles."""


@block
def bent(
    z: float,
    travel: float,
    level: float,
    memory: np.ndarray,
    stiffness: np.ndarray,
    limit: np.ndarray,
) -> float:
    """Return the deflection [m] after a travel [m] at a friction level [N], backward Euler."""
    way, new = abs(travel), z
    for _ in range(ROUNDS):
        slope = stiffness[-1]
        for i in range(len(limit)):
            if abs(stiffness[i] * (new - memory[at.ANCHORS + i])) < limit[i]:
                slope += stiffness[i]
        rest = new - z - travel + way * elements(new, memory, stiffness, limit) / level
        new -= rest / (1.0 + way * slope / level)
        if abs(rest) < 1e-15:
            break
    return new


@block
def level_at(
    t: float,
    y: np.ndarray,
    rests: bool,
    memory: np.ndarray,
    c: np.ndarray,
    e: np.ndarray,
    stiffness: np.ndarray,
    limit: np.ndarray,
) -> tuple[float, float]:
    """Return the level [N] and the film's rate [1/s]; take note of rests and slides that begin."""
    bristles = elements(y[at.Z], memory, stiffness, limit)
    coulomb, largest = levels(y, bristles, memory, c, e)
    if rests != (memory[at.STICKING] == 1.0):
        memory[at.SHARE] = share_left(t, memory, c, e)
        if rests:
            memory[at.REST_START] = t
        else:
            dwell = t - memory[at.REST_START]
            memory[at.HELD] = static_after(dwell, coulomb, largest, c, e)
            memory[at.SLIDE_START] = t
        memory[at.STICKING] = 1.0 if rests else 0.0
    static = static_force(t, coulomb, largest, memory, c, e)
    film = film_rate(y, static, coulomb, memory, c, e)
    return stribeck(y, static, coulomb, c, e), film


@kept
def friction_along(
    states: np.ndarray,
    sticking: np.ndarray,
    rest: float,
    interval: float,
    c: np.ndarray,
    e: np.ndarray,
    stiffness: np.ndarray,
    limit: np.ndarray,
) -> np.ndarray:
    """
    Return the friction [N] that opposes the motion, shape (n,).

    :param states: positions, velocities and pressures are taken from them
    :param sticking: whether the piston rests
    :param rest: time before the run [s]
    """
    memory = np.zeros(at.ANCHORS + len(stiffness))
    memory[at.STICKING], memory[at.REST_START] = 1.0, -rest
    memory[at.HELD] = static_after(rest, c[at.F_C], c[at.F_S], c, e)
    y, friction = states[0].copy(), np.empty(len(states))
    z = h = warmth = 0.0
    for k in range(len(states)):
        y[:] = states[k]
        y[at.Z], y[at.H], y[at.WARMTH] = z, h, warmth
        level, film = level_at(k * interval, y, sticking[k], memory, c, e, stiffness, limit)
        travel = y[at.V] * interval
        if e.size > at.FOREIGN and e[at.AT_BRISTLE] > 0.0:
            new = slipped(z, travel, level, stiffness, memory, limit, e)
        else:
            new = bent(z, travel, level, memory, stiffness, limit)
        bristles = elements(new, memory, stiffness, limit)
        drag_force = c[at.SIGMA_2] * y[at.V]
        friction[k] = bristles + c[at.SIGMA_1] * (new - z) / interval + drag_force
        if e.size > at.FOREIGN:
            friction[k] += viscous(y, c, e)
            if sums_elements(e):
                friction[k] += y[at.ELEMENT_1 : at.ELEMENT_3 + 1].sum()
        h += interval * film
        work = abs(bristles * y[at.V]) + drag_force * y[at.V]
        warmth += interval * (1.0 - warmth) * work / e[at.WORK]
        z = new
        drag(z, memory, stiffness, limit)
    return friction
