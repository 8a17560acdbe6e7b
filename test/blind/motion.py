"""
The piston of the second plant: Eq. 8-16, written anew, with what can be hidden in it.

Arguments as in ``gas``; ``stiffness`` and ``limit`` are those of the elements of F(z).
"""

import math

import numba
import numpy as np

from . import foreign_force as foreign
from . import second_force as second
from .constants import (
    A1,
    A2,
    ALPHA,
    ANCHORS,
    ANGLE,
    ASYMMETRY,
    AT_BRISTLE,
    AT_DWELL,
    AT_FILM,
    AT_JOINT,
    AT_PAD,
    BELL,
    BELL_PLACE,
    BELL_WIDTH,
    COMPLIANCE,
    CONTACT,
    CUSHION,
    CUSHION_D,
    CUSHION_K,
    DRAG,
    DRAG_ONE_SIDE,
    DROP,
    ELAPSED,
    F_C,
    F_S,
    FILM,
    FILM_REST,
    FOREIGN,
    GAMMA,
    GRADIENT,
    HELD,
    JOINT_D,
    LAW,
    LIP,
    LIP_POWER,
    LOAD,
    LOAD_V,
    LOST,
    LOST_GAMMA,
    LOST_POWER,
    MASS,
    ONE_SIDE,
    P1,
    P2,
    P_ATM,
    PRELOAD,
    READING,
    REST_START,
    SEAL,
    SEAL_LIMIT,
    SEAL_REACH,
    SHARE,
    SIGMA_1,
    SIGMA_2,
    SLIDE_START,
    SLOPE,
    SPRING,
    STATIC_ASYMMETRY,
    STATIC_ONE_SIDE,
    STICKING,
    STRETCH,
    STROKE,
    T_FLUID,
    TAPER,
    TAU_0,
    TAU_M,
    TAU_P,
    TAU_S,
    TIME_LIMIT,
    TIME_RATE,
    TRAVEL,
    TRAVEL_LIMIT,
    TRAVEL_RATE,
    V_B,
    V_FILM,
    V_S,
    WARMTH,
    WORK,
    H,
    N,
    V,
    X,
    Z,
)

GRAVITY = 9.80665


@numba.njit
def elements(z: float, memory: np.ndarray, stiffness: np.ndarray, limit: np.ndarray) -> float:
    """F(z) [N]: springs, each but the last behind a slider."""
    total = 0.0
    for i in range(len(stiffness)):
        force = stiffness[i] * (z - memory[ANCHORS + i])
        if i < len(limit):
            force = max(-limit[i], min(limit[i], force))
        total += force
    return total


@numba.njit
def drag(z: float, memory: np.ndarray, stiffness: np.ndarray, limit: np.ndarray) -> None:
    """Let the sliders that slip take their springs along."""
    for i in range(len(limit)):
        reach = limit[i] / stiffness[i]
        memory[ANCHORS + i] = max(z - reach, min(z + reach, memory[ANCHORS + i]))


@numba.njit
def drifted(rate: float, limit: float, progress: float) -> float:
    """Share [-] by which a level has drifted: at a rate at first, towards a limit."""
    if rate == 0.0:
        return 0.0
    share = limit * (1.0 - math.exp(-abs(rate) * progress / limit))
    return share if rate > 0.0 else -min(share, 0.9)


@numba.njit
def pressed(pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """Friction [N] of a lip that a pressure [Pa] presses on: a power of its bars."""
    return e[LIP] * max(1e-5 * (pressure - c[P_ATM]), 0.0) ** e[LIP_POWER]


@numba.njit
def levels(
    y: np.ndarray, bristles: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> tuple[float, float]:
    """F_c and F_smax [N] with what hidden effects add to them."""
    share = e[GRADIENT] * (y[X] / c[STROKE] - 0.5) - e[DROP] * y[WARMTH]
    share += e[BELL] * math.exp(-(((y[X] / c[STROKE] - e[BELL_PLACE]) / e[BELL_WIDTH]) ** 2))
    side = 1.0 if y[V] > 0.0 else -1.0
    if memory[STICKING] == 1.0:
        side = max(-1.0, min(1.0, 2.0 * bristles / c[F_C]))
    share += e[ASYMMETRY] * (side + e[ONE_SIDE])
    share += drifted(e[TRAVEL_RATE], e[TRAVEL_LIMIT], y[TRAVEL])
    share += drifted(e[TIME_RATE], e[TIME_LIMIT], y[ELAPSED])
    added = e[SLOPE] * max(y[P1] + y[P2] - 2.0 * c[P_ATM], 0.0)
    added += pressed(y[P1], c, e) + pressed(y[P2], c, e)
    if e.size > FOREIGN:
        more, most = second.added_levels(y, bristles, memory, c, e)
        coulomb = max((1.0 + share) * c[F_C] + added + more, 0.01 * c[F_C])
        return coulomb, max((1.0 + share) * c[F_S] + added + most, 0.01 * c[F_S])
    coulomb = max((1.0 + share) * c[F_C] + added, 0.01 * c[F_C])
    largest = max((1.0 + share) * c[F_S] + added, 0.01 * c[F_S])
    excess = e[STATIC_ASYMMETRY] * (side + e[STATIC_ONE_SIDE])
    return coulomb, largest + excess * max(largest - coulomb, 0.0)


@numba.njit
def growth(c: np.ndarray, e: np.ndarray) -> tuple[float, float, float]:
    """Share of F_smax - F_c that is not there without a dwell, gamma, alpha; 0 without growth."""
    if e[LOST] > 0.0:
        return e[LOST], e[LOST_GAMMA], e[LOST_POWER]
    return (1.0 if c[LAW] == 3.0 else 0.0), c[GAMMA], c[ALPHA]


@numba.njit
def static_after(
    dwell: float, coulomb: float, largest: float, c: np.ndarray, e: np.ndarray
) -> float:
    """F_s [N] after a dwell time [s], Eq. 16; the largest where the law has none."""
    if e.size > FOREIGN and e[AT_DWELL] > 0.0:
        return coulomb + (largest - coulomb) * second.dwell_share(dwell, e)
    lost, gamma, alpha = growth(c, e)
    if lost == 0.0:
        return largest
    return largest - lost * (largest - coulomb) * math.exp(-gamma * dwell**alpha)


@numba.njit
def share_left(t: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """
    Share that F_s has of what a dwell adds to it, if that fades while sliding.

    Sliding it decays; at rest it grows by Eq. 16, from where that has the share it began with.
    """
    share = memory[SHARE]
    if memory[STICKING] == 0.0:
        return share * math.exp((memory[SLIDE_START] - t) / c[TAU_S])
    _, gamma, alpha = growth(c, e)
    if gamma == 0.0:
        return 0.0
    grown = -math.log(max(1.0 - share, 1e-300))
    before = (grown / gamma) ** (1.0 / alpha)
    return 1.0 - math.exp(-gamma * (before + (t - memory[REST_START])) ** alpha)


@numba.njit
def static_force(
    t: float, coulomb: float, largest: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> float:
    """F_s [N] under the chosen reading of Eq. 16; a foreign one is kept from breakaway on."""
    if e.size > FOREIGN and e[AT_DWELL] > 0.0 and memory[STICKING] == 0.0:
        return memory[HELD]
    lost = growth(c, e)[0]
    if lost > 0.0 and (c[READING] == 2.0 or (c[READING] == 1.0 and memory[STICKING] == 0.0)):
        return memory[HELD]
    if lost > 0.0 and c[READING] == 3.0:
        return largest - lost * (largest - coulomb) * (1.0 - share_left(t, memory, c, e))
    dwell = t - memory[REST_START] if memory[STICKING] == 1.0 else 0.0
    return static_after(dwell, coulomb, largest, c, e)


@numba.njit
def stribeck(y: np.ndarray, static: float, coulomb: float, c: np.ndarray, e: np.ndarray) -> float:
    """g(v, h) [N], Eq. 11."""
    if c[LAW] == 0.0:
        if e.size > FOREIGN:
            return coulomb + second.stribeck_excess(abs(y[V]), c, e)
        return coulomb
    top = static
    if e.size > FOREIGN:
        top = coulomb + (static - coulomb) * foreign.film_share(y, e)
    if c[LAW] >= 2.0:
        h = y[H]
        top = (1.0 - h) * static if c[FILM] == 0.0 else static - h * (static - coulomb)
    return coulomb + (top - coulomb) * math.exp(-((abs(y[V]) / c[V_S]) ** c[N]))


@numba.njit
def film_rate(
    y: np.ndarray, static: float, coulomb: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> float:
    """dh/dt [1/s], Eq. 12-15."""
    if e.size > FOREIGN and e[AT_FILM] > 0.0:
        return second.film_rate(y, c, e)
    steady = min(abs(y[V]) / c[V_B], 1.0) ** (2.0 / 3.0)
    if c[FILM] == 0.0:
        steady *= max(1.0 - coulomb / static, 0.0)
    resting = memory[STICKING] == 1.0 if c[FILM_REST] == 0.0 else abs(y[V]) < c[V_FILM]
    if resting:
        return (steady - y[H]) / c[TAU_0]
    return (steady - y[H]) / (c[TAU_P] if y[H] <= steady else c[TAU_M])


@numba.njit
def cushion(depth: float, speed: float, e: np.ndarray) -> float:
    """Push [N] of a cushion that is pressed in by a depth [m] at a speed [m/s]."""
    if depth <= 0.0:
        return 0.0
    damping = e[CUSHION_D] * min(depth / e[CUSHION], 1.0)
    return max(e[CUSHION_K] * depth + damping * speed, 0.0)


@numba.njit
def outer_forces(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] along the outstroke of weight, spring and cushions."""
    weight = -(c[MASS] + c[LOAD]) * GRAVITY * math.sin(e[ANGLE])
    spring = -e[SPRING] * max(y[X] + e[PRELOAD], 0.0)
    inner = cushion(e[CUSHION] - y[X], -y[V], e)
    outer = cushion(y[X] - c[STROKE] + e[CUSHION], y[V], e)
    total = weight + spring + inner - outer
    total -= e[DRAG] * (abs(y[V]) + e[DRAG_ONE_SIDE] * y[V])
    total -= e[SEAL_LIMIT] * max(-1.0, min(1.0, y[SEAL] / e[SEAL_REACH]))
    # what the bore is wider than stated, both chambers press on
    total += e[TAPER] * c[A1] * (y[X] / c[STROKE] - 0.5) * (y[P1] - y[P2])
    if e.size > FOREIGN:
        total += second.load_force(y, c, e)
        if e[AT_PAD] > 0.0:
            total += second.pads(y, c, e)
    return total


@numba.njit
def seal_rate(y: np.ndarray, e: np.ndarray) -> float:
    """Rate of the deflection of a seal [m/s], which slips in the last percent of its reach."""
    if y[SEAL] * y[V] <= 0.0:
        return float(y[V])
    beyond = (abs(y[SEAL]) - e[SEAL_REACH]) / (0.01 * e[SEAL_REACH])
    return float(y[V] * (1.0 - max(0.0, min(1.0, beyond))))


@numba.njit
def elastic(c: np.ndarray, e: np.ndarray) -> bool:
    """Whether the load hangs on a joint that gives way."""
    if e.size > FOREIGN and e[AT_JOINT + 1] > 0.0:
        return c[LOAD] > 0.0
    return e[COMPLIANCE] > 0.0 and c[LOAD] > 0.0


@numba.njit
def joint_force(y: np.ndarray, e: np.ndarray) -> float:
    """Force [N] with which the joint of the load pulls along the outstroke."""
    if e.size > FOREIGN and e[AT_JOINT + 1] > 0.0:
        return second.joint(y, e)
    return y[STRETCH] / e[COMPLIANCE] + e[JOINT_D] * (y[LOAD_V] - y[V])


@numba.njit
def foreign_bending(v: float, bristles: float, level: float, e: np.ndarray) -> float:
    """dz/dt [m/s] of a foreign law."""
    if e[AT_BRISTLE] == 0.0:
        return v - abs(v) * bristles / level
    side = 1.0 if v > 0.0 else -1.0
    return v * foreign.bending(side * bristles / level, e)


@numba.njit
def motion_rates(
    t: float,
    y: np.ndarray,
    dy: np.ndarray,
    memory: np.ndarray,
    c: np.ndarray,
    e: np.ndarray,
    stiffness: np.ndarray,
    limit: np.ndarray,
) -> float:
    """Write the rates of motion and friction; return the acceleration that no stop hinders."""
    v = y[V]
    bristles = elements(y[Z], memory, stiffness, limit)
    coulomb, largest = levels(y, bristles, memory, c, e)
    static = static_force(t, coulomb, largest, memory, c, e)
    level = stribeck(y, static, coulomb, c, e)
    z_rate = v - abs(v) * bristles / level
    dy[H] = film_rate(y, static, coulomb, memory, c, e)
    if e[DROP] != 0.0:
        dy[WARMTH] = (1.0 - y[WARMTH]) * (abs(bristles * v) + c[SIGMA_2] * v * v) / e[WORK]
    if e[TRAVEL_RATE] != 0.0:
        dy[TRAVEL] = abs(v)
    if e[TIME_RATE] != 0.0:
        dy[ELAPSED] = 1.0
    if e[SEAL_LIMIT] != 0.0:
        dy[SEAL] = seal_rate(y, e)
    force = c[A1] * (y[P1] - c[P_ATM]) - c[A2] * (y[P2] - c[P_ATM]) + outer_forces(y, c, e)
    if e.size > FOREIGN:
        z_rate = foreign_bending(v, bristles, level, e)
        other = second.viscous(y, c, e) + second.element_rates(y, dy, level, c, e)
        second.history_rates(y, dy, bristles + c[SIGMA_2] * v + other, e)
        foreign.swing_rates(y, dy, e)
        second.pocket_rates(y, dy, c, e)
        force -= other
    force -= bristles + c[SIGMA_1] * z_rate + c[SIGMA_2] * v
    inertia = c[MASS] + c[LOAD]
    if elastic(c, e):
        joint = joint_force(y, e)
        dy[STRETCH], dy[LOAD_V] = y[LOAD_V] - v, -joint / c[LOAD]
        force, inertia = force + joint, c[MASS]
    if c[LAW] >= 2.0:
        inertia += c[SIGMA_2] * c[T_FLUID]
    acceleration = force / inertia
    dy[X], dy[V], dy[Z] = v, acceleration, z_rate
    if memory[CONTACT] != 0.0:
        dy[X] = dy[V] = dy[Z] = 0.0
    return acceleration
