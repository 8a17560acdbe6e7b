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
    y, z, friction = states[0].copy(), 0.0, np.empty(len(states))
    h = warmth = 0.0
    for k in range(len(states)):
        t = k * interval
        y[:] = states[k]
        y[at.H], y[at.WARMTH] = h, warmth
        bristles = elements(z, memory, stiffness, limit)
        coulomb, largest = levels(y, bristles, memory, c, e)
        now = 1.0 if sticking[k] else 0.0
        if now != memory[at.STICKING]:
            dwell = t - memory[at.REST_START]
            memory[at.SHARE] = share_left(t, memory, c)
            if now == 0.0:
                memory[at.HELD] = static_after(dwell, coulomb, largest, c)
                memory[at.SLIDE_START] = t
            else:
                memory[at.REST_START] = t
            memory[at.STICKING] = now
        static = static_force(t, coulomb, largest, memory, c)
        level = stribeck(y, static, coulomb, c)
        new = bent(z, y[at.V] * interval, level, memory, stiffness, limit)
        bristles = elements(new, memory, stiffness, limit)
        friction[k] = bristles + c[at.SIGMA_1] * (new - z) / interval + c[at.SIGMA_2] * y[at.V]
        h += interval * film_rate(y, static, coulomb, memory, c)
        work = abs(bristles * y[at.V]) + c[at.SIGMA_2] * y[at.V] ** 2
        warmth += interval * (1.0 - warmth) * work / e[at.WORK]
        z = new
        drag(z, memory, stiffness, limit)
    return friction
