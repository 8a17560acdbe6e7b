"""Friction of the second plant along a motion that is known, sample by sample."""

import numba
import numpy as np

from . import constants as at
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

ROUNDS = 20
"""Of Newton's method on the piecewise straight force of the bristles."""


@numba.njit
def bent(
    z: float, travel: float, level: float, memory: np.ndarray, stiffness: np.ndarray,
    limit: np.ndarray,
) -> float:  # fmt: skip
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


@numba.njit
def level_at(
    t: float, y: np.ndarray, rests: bool, memory: np.ndarray, c: np.ndarray, e: np.ndarray,
    stiffness: np.ndarray, limit: np.ndarray,
) -> tuple[float, float]:  # fmt: skip
    """Return the level [N] and the film's rate [1/s]; take note of rests and slides that begin."""
    bristles = elements(y[at.Z], memory, stiffness, limit)
    coulomb, largest = levels(y, bristles, memory, c, e)
    if rests != (memory[at.STICKING] == 1.0):
        memory[at.SHARE] = share_left(t, memory, c)
        if rests:
            memory[at.REST_START] = t
        else:
            dwell = t - memory[at.REST_START]
            memory[at.HELD] = static_after(dwell, coulomb, largest, c)
            memory[at.SLIDE_START] = t
        memory[at.STICKING] = 1.0 if rests else 0.0
    static = static_force(t, coulomb, largest, memory, c)
    return stribeck(y, static, coulomb, c), film_rate(y, static, coulomb, memory, c)


@numba.njit
def friction_along(
    states: np.ndarray, sticking: np.ndarray, rest: float, interval: float,
    c: np.ndarray, e: np.ndarray, stiffness: np.ndarray, limit: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """
    Return the friction [N] that opposes the motion, shape (n,).

    :param states: positions, velocities and pressures are taken from them
    :param sticking: whether the piston rests
    :param rest: time before the run [s]
    """
    memory = np.zeros(at.ANCHORS + len(stiffness))
    memory[at.STICKING], memory[at.REST_START] = 1.0, -rest
    memory[at.HELD] = static_after(rest, c[at.F_C], c[at.F_S], c)
    y, friction = states[0].copy(), np.empty(len(states))
    z = h = warmth = 0.0
    for k in range(len(states)):
        y[:] = states[k]
        y[at.Z], y[at.H], y[at.WARMTH] = z, h, warmth
        level, film = level_at(k * interval, y, sticking[k], memory, c, e, stiffness, limit)
        new = bent(z, y[at.V] * interval, level, memory, stiffness, limit)
        bristles = elements(new, memory, stiffness, limit)
        viscous = c[at.SIGMA_2] * y[at.V]
        friction[k] = bristles + c[at.SIGMA_1] * (new - z) / interval + viscous
        h += interval * film
        work = abs(bristles * y[at.V]) + viscous * y[at.V]
        warmth += interval * (1.0 - warmth) * work / e[at.WORK]
        z = new
        drag(z, memory, stiffness, limit)
    return friction
