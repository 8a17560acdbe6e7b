"""
What is hidden contributes to each balance, as a function of time: the truth of localisation.

All of it by the second plant's equations, without noise. The contribution is what must be added to
the given model's balance, evaluated along the signals that perfect sensors with the hidden errors
would show, so that it holds: a flow of energy as gas at supply temperature [kg/s], a force [N].
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from . import constants as at
from .along import friction_along
from .gas import gas_rates
from .kept import kept
from .motion import elastic, joint_force, outer_forces
from .second_sensors import misread, present
from .sensors import lagging


class Equations(NamedTuple):
    """Numbers that the equations read, see ``constants``."""

    c: np.ndarray
    e: np.ndarray
    stiffness: np.ndarray
    limit: np.ndarray


class Seen(NamedTuple):
    """
    A run as the sensors see it, without noise.

    :param states: with position, velocity and pressures as seen, shape (n, STATES)
    :param acceleration: as seen [m/s^2]
    """

    states: np.ndarray
    acceleration: np.ndarray


@kept
def pressure_rates(
    states: np.ndarray, targets: np.ndarray, c: np.ndarray, e: np.ndarray
) -> np.ndarray:
    """Return the rates of both pressures [Pa/s] at each state, shape (n, 2)."""
    found, memory = np.empty((len(states), 2)), np.zeros(at.ANCHORS)
    for k in range(len(states)):
        rate = np.zeros(states.shape[1])
        memory[at.TARGET_1], memory[at.TARGET_2] = targets[k, 0], targets[k, 1]
        gas_rates(states[k], rate, memory, c, e)
        found[k, 0], found[k, 1] = rate[at.P1], rate[at.P2]
    return found


def volumes(states: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the volumes of both chambers [m^3], shape (n, 2)."""
    x = states[:, at.X]
    return np.stack([c[at.V10] + c[at.A1] * x, c[at.V20] + c[at.A2] * (c[at.STROKE] - x)], axis=1)


def seen(states: np.ndarray, interval: float, errors: Mapping[str, float]) -> Seen:
    """
    Return a run as sensors with hidden errors see it.

    :param errors: effect.parameter -> value, see ``sensors.SENSOR_ERRORS``
    """
    shown = states.copy()
    velocity = states[:, at.V]
    acceleration = np.gradient(velocity, interval)
    if lag := errors.get('sensor_delay.time_constant', 0.0):
        for place in (at.X, at.V):
            shown[:, place] = lagging(states[:, place], interval, lag)
        acceleration = (velocity - shown[:, at.V]) / lag
    scale = 1.0 + errors.get('position_scale.error', 0.0)
    shown[:, [at.X, at.V]] *= scale
    shown[:, at.P1] += errors.get('pressure_offset.offset_1', 0.0)
    shown[:, at.P2] += errors.get('pressure_offset.offset_2', 0.0)
    acceleration *= scale
    if present(errors):
        read, before = [at.X, at.P1, at.P2], shown[:, at.X].copy()
        shown[:, read] = misread(shown[:, read].T, interval, errors).T
        moved = shown[:, at.X] - before
        shown[:, at.V] += np.gradient(moved, interval)
        acceleration += np.gradient(np.gradient(moved, interval), interval)
    return Seen(shown, acceleration)


def gas(
    states: np.ndarray,
    shown: Seen,
    targets: np.ndarray,
    voltages: np.ndarray,
    true: Equations,
    model: Equations,
) -> np.ndarray:
    """
    Return the contribution to the balance of each gas [kg/s], shape (n, 2).

    :param targets: where the true spools are drawn to [V], shape (n, 2)
    :param voltages: of the valves [V], shape (n, 2)
    """
    c = model.c
    real = pressure_rates(states, targets, true.c, true.e)
    modelled = pressure_rates(shown.states, voltages, c, model.e)
    return volumes(shown.states, c) * (real - modelled) / (c[at.KAPPA] * c[at.R] * c[at.T_S])


def force(
    states: np.ndarray,
    shown: Seen,
    sticking: np.ndarray,
    rest: float,
    interval: float,
    true: Equations,
    model: Equations,
) -> np.ndarray:
    """
    Return the contribution to the balance of forces [N] while the piston slides, shape (n,).

    Friction is that of the own law of each side along the motion, from its own film and bristles.
    """
    acceleration = np.gradient(states[:, at.V], interval)
    sides = (
        (states, acceleration, true),
        (shown.states, shown.acceleration, model),
    )
    needed = [
        inertia(side.c, side.e) * a
        + friction_along(y, sticking, rest, interval, *side)
        - driving(y, side)
        for y, a, side in sides
    ]
    rests = np.convolve(sticking, np.ones(3), 'same') > 0.0  # beside it v has a kink
    return np.where(rests, 0.0, needed[1] - needed[0])


def inertia(c: np.ndarray, e: np.ndarray) -> float:
    """Return the mass that moves with the piston [kg], that of the fluid included."""
    fluid = c[at.SIGMA_2] * c[at.T_FLUID] if c[at.LAW] >= 2.0 else 0.0
    return float(c[at.MASS] + fluid + (0.0 if elastic(c, e) else c[at.LOAD]))


def driving(states: np.ndarray, side: Equations) -> np.ndarray:
    """Return the force along the outstroke [N] of gas, weight, springs and an elastic load."""
    c, e = side.c, side.e
    outer = np.array([outer_forces(y, c, e) for y in states])
    outer += pressure_force(states, c)
    if elastic(c, e):
        outer += np.array([joint_force(y, e) for y in states])
    return outer


def pressure_force(states: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the force of the gas on the piston along the outstroke [N], shape (n,)."""
    gauge = states[:, [at.P1, at.P2]] - c[at.P_ATM]
    return gauge @ np.array([c[at.A1], -c[at.A2]])
