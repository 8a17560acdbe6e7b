"""
The piston of the second plant: Eq. 8-16, written anew, with what can be hidden in it.

Arguments as in ``gas``; ``stiffness`` and ``limit`` are those of the elements of F(z).
"""

import math

import numpy as np

from . import constants as at
from . import foreign_force as foreign
from . import second_force as second
from .kept import block

GRAVITY = 9.80665


@block
def elements(z: float, memory: np.ndarray, stiffness: np.ndarray, limit: np.ndarray) -> float:
    """F(z) [N]: springs, each but the last behind a slider."""
    total = 0.0
    for i in range(len(stiffness)):
        force = stiffness[i] * (z - memory[at.ANCHORS + i])
        if i < len(limit):
            force = max(-limit[i], min(limit[i], force))
        total += force
    return total


@block
def drag(z: float, memory: np.ndarray, stiffness: np.ndarray, limit: np.ndarray) -> None:
    """Let the sliders that slip take their springs along."""
    for i in range(len(limit)):
        reach = limit[i] / stiffness[i]
        memory[at.ANCHORS + i] = max(z - reach, min(z + reach, memory[at.ANCHORS + i]))


@block
def drifted(rate: float, limit: float, progress: float) -> float:
    """Share [-] by which a level has drifted: at a rate at first, towards a limit."""
    if rate == 0.0:
        return 0.0
    share = limit * (1.0 - math.exp(-abs(rate) * progress / limit))
    return share if rate > 0.0 else -min(share, 0.9)


@block
def pressed(pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """Friction [N] of a lip that a pressure [Pa] presses on: a power of its bars."""
    return e[at.LIP] * max(1e-5 * (pressure - c[at.P_ATM]), 0.0) ** e[at.LIP_POWER]


@block
def levels(
    y: np.ndarray, bristles: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> tuple[float, float]:
    """F_c and F_smax [N] with what hidden effects add to them."""
    share = e[at.GRADIENT] * (y[at.X] / c[at.STROKE] - 0.5) - e[at.DROP] * y[at.WARMTH]
    share += e[at.BELL] * math.exp(
        -(((y[at.X] / c[at.STROKE] - e[at.BELL_PLACE]) / e[at.BELL_WIDTH]) ** 2)
    )
    side = 1.0 if y[at.V] > 0.0 else -1.0
    if memory[at.STICKING] == 1.0:
        side = max(-1.0, min(1.0, 2.0 * bristles / c[at.F_C]))
    share += e[at.ASYMMETRY] * (side + e[at.ONE_SIDE])
    share += drifted(e[at.TRAVEL_RATE], e[at.TRAVEL_LIMIT], y[at.TRAVEL])
    share += drifted(e[at.TIME_RATE], e[at.TIME_LIMIT], y[at.ELAPSED])
    added = e[at.SLOPE] * max(y[at.P1] + y[at.P2] - 2.0 * c[at.P_ATM], 0.0)
    added += pressed(y[at.P1], c, e) + pressed(y[at.P2], c, e)
    if e.size > at.FOREIGN:
        more, most = second.added_levels(y, bristles, memory, c, e)
        coulomb = max((1.0 + share) * c[at.F_C] + added + more, 0.01 * c[at.F_C])
        return coulomb, max((1.0 + share) * c[at.F_S] + added + most, 0.01 * c[at.F_S])
    coulomb = max((1.0 + share) * c[at.F_C] + added, 0.01 * c[at.F_C])
    largest = max((1.0 + share) * c[at.F_S] + added, 0.01 * c[at.F_S])
    excess = e[at.STATIC_ASYMMETRY] * (side + e[at.STATIC_ONE_SIDE])
    return coulomb, largest + excess * max(largest - coulomb, 0.0)


@block
def static_after(
    dwell: float, coulomb: float, largest: float, c: np.ndarray, e: np.ndarray
) -> float:
    """F_s [N] after a dwell time [s], Eq. 16; the largest where the law has none."""
    if e.size > at.FOREIGN and e[at.AT_DWELL] > 0.0:
        return coulomb + (largest - coulomb) * second.dwell_share(dwell, e)
    if c[at.LAW] != 3.0:
        return largest
    return largest - (largest - coulomb) * math.exp(-c[at.GAMMA] * dwell ** c[at.ALPHA])


@block
def share_left(t: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """
    Share that F_s has of what a dwell adds to it, if that fades while sliding.

    Sliding it decays; at rest it grows by Eq. 16, from where that has the share it began with.
    """
    share = memory[at.SHARE]
    if memory[at.STICKING] == 0.0:
        return share * math.exp((memory[at.SLIDE_START] - t) / c[at.TAU_S])
    gamma, alpha = c[at.GAMMA], c[at.ALPHA]
    if gamma == 0.0:
        return 0.0
    grown = -math.log(max(1.0 - share, 1e-300))
    before = (grown / gamma) ** (1.0 / alpha)
    return 1.0 - math.exp(-gamma * (before + (t - memory[at.REST_START])) ** alpha)


@block
def static_force(
    t: float, coulomb: float, largest: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> float:
    """F_s [N] under the chosen reading of Eq. 16; a foreign one is kept from breakaway on."""
    if e.size > at.FOREIGN and e[at.AT_DWELL] > 0.0 and memory[at.STICKING] == 0.0:
        return memory[at.HELD]
    grows = c[at.LAW] == 3.0
    if grows and (c[at.READING] == 2.0 or (c[at.READING] == 1.0 and memory[at.STICKING] == 0.0)):
        return memory[at.HELD]
    if grows and c[at.READING] == 3.0:
        return largest - (largest - coulomb) * (1.0 - share_left(t, memory, c, e))
    dwell = t - memory[at.REST_START] if memory[at.STICKING] == 1.0 else 0.0
    return static_after(dwell, coulomb, largest, c, e)


@block
def stribeck(y: np.ndarray, static: float, coulomb: float, c: np.ndarray, e: np.ndarray) -> float:
    """g(v, h) [N], Eq. 11."""
    if c[at.LAW] == 0.0:
        if e.size > at.FOREIGN:
            return coulomb + second.stribeck_excess(abs(y[at.V]), c, e)
        return coulomb
    top = static
    if e.size > at.FOREIGN:
        top = coulomb + (static - coulomb) * foreign.film_share(y, e)
    if c[at.LAW] >= 2.0:
        h = y[at.H]
        top = (1.0 - h) * static if c[at.FILM] == 0.0 else static - h * (static - coulomb)
    return coulomb + (top - coulomb) * math.exp(-((abs(y[at.V]) / c[at.V_S]) ** c[at.N]))


@block
def film_rate(
    y: np.ndarray, static: float, coulomb: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> float:
    """dh/dt [1/s], Eq. 12-15."""
    if e.size > at.FOREIGN and e[at.AT_FILM] > 0.0:
        return second.film_rate(y, c, e)
    steady = min(abs(y[at.V]) / c[at.V_B], 1.0) ** (2.0 / 3.0)
    if c[at.FILM] == 0.0:
        steady *= max(1.0 - coulomb / static, 0.0)
    resting = memory[at.STICKING] == 1.0 if c[at.FILM_REST] == 0.0 else abs(y[at.V]) < c[at.V_FILM]
    if resting:
        return (steady - y[at.H]) / c[at.TAU_0]
    return (steady - y[at.H]) / (c[at.TAU_P] if y[at.H] <= steady else c[at.TAU_M])


@block
def cushion(depth: float, speed: float, e: np.ndarray) -> float:
    """Push [N] of a cushion that is pressed in by a depth [m] at a speed [m/s]."""
    if depth <= 0.0:
        return 0.0
    damping = e[at.CUSHION_D] * min(depth / e[at.CUSHION], 1.0)
    return max(e[at.CUSHION_K] * depth + damping * speed, 0.0)


@block
def outer_forces(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] along the outstroke of weight, spring and cushions."""
    weight = -(c[at.MASS] + c[at.LOAD]) * GRAVITY * math.sin(e[at.ANGLE])
    spring = -e[at.SPRING] * max(y[at.X] + e[at.PRELOAD], 0.0)
    inner = cushion(e[at.CUSHION] - y[at.X], -y[at.V], e)
    outer = cushion(y[at.X] - c[at.STROKE] + e[at.CUSHION], y[at.V], e)
    total = weight + spring + inner - outer
    total -= e[at.DRAG] * (abs(y[at.V]) + e[at.DRAG_ONE_SIDE] * y[at.V])
    total -= e[at.SEAL_LIMIT] * max(-1.0, min(1.0, y[at.SEAL] / e[at.SEAL_REACH]))
    # what the bore is wider than stated, both chambers press on
    total += e[at.TAPER] * c[at.A1] * (y[at.X] / c[at.STROKE] - 0.5) * (y[at.P1] - y[at.P2])
    if e.size > at.FOREIGN:
        total += second.load_force(y, c, e)
        if e[at.AT_PAD] > 0.0:
            total += second.pads(y, c, e)
    return total


@block
def seal_rate(y: np.ndarray, e: np.ndarray) -> float:
    """Rate of the deflection of a seal [m/s], which slips in the last percent of its reach."""
    if y[at.SEAL] * y[at.V] <= 0.0:
        return float(y[at.V])
    beyond = (abs(y[at.SEAL]) - e[at.SEAL_REACH]) / (0.01 * e[at.SEAL_REACH])
    return float(y[at.V] * (1.0 - max(0.0, min(1.0, beyond))))


@block
def elastic(c: np.ndarray, e: np.ndarray) -> bool:
    """Whether the load hangs on a joint that gives way."""
    if e.size > at.FOREIGN and e[at.AT_JOINT + 1] > 0.0:
        return c[at.LOAD] > 0.0
    return e[at.COMPLIANCE] > 0.0 and c[at.LOAD] > 0.0


@block
def joint_force(y: np.ndarray, e: np.ndarray) -> float:
    """Force [N] with which the joint of the load pulls along the outstroke."""
    if e.size > at.FOREIGN and e[at.AT_JOINT + 1] > 0.0:
        return second.joint(y, e)
    return y[at.STRETCH] / e[at.COMPLIANCE] + e[at.JOINT_D] * (y[at.LOAD_V] - y[at.V])


@block
def foreign_bending(v: float, bristles: float, level: float, e: np.ndarray) -> float:
    """dz/dt [m/s] of a foreign law."""
    if e[at.AT_BRISTLE] == 0.0:
        return v - abs(v) * bristles / level
    side = 1.0 if v > 0.0 else -1.0
    return v * foreign.bending(side * bristles / level, e)


@block
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
    v = y[at.V]
    bristles = elements(y[at.Z], memory, stiffness, limit)
    coulomb, largest = levels(y, bristles, memory, c, e)
    static = static_force(t, coulomb, largest, memory, c, e)
    level = stribeck(y, static, coulomb, c, e)
    z_rate = v - abs(v) * bristles / level
    dy[at.H] = film_rate(y, static, coulomb, memory, c, e)
    if e[at.DROP] != 0.0:
        dy[at.WARMTH] = (
            (1.0 - y[at.WARMTH]) * (abs(bristles * v) + c[at.SIGMA_2] * v * v) / e[at.WORK]
        )
    if e[at.TRAVEL_RATE] != 0.0:
        dy[at.TRAVEL] = abs(v)
    if e[at.TIME_RATE] != 0.0:
        dy[at.ELAPSED] = 1.0
    if e[at.SEAL_LIMIT] != 0.0:
        dy[at.SEAL] = seal_rate(y, e)
    force = (
        c[at.A1] * (y[at.P1] - c[at.P_ATM])
        - c[at.A2] * (y[at.P2] - c[at.P_ATM])
        + outer_forces(y, c, e)
    )
    if e.size > at.FOREIGN:
        z_rate = foreign_bending(v, bristles, level, e)
        other = second.viscous(y, c, e) + second.element_rates(y, dy, level, c, e)
        second.history_rates(y, dy, bristles + c[at.SIGMA_2] * v + other, e)
        foreign.swing_rates(y, dy, e)
        second.pocket_rates(y, dy, c, e)
        force -= other
    force -= bristles + c[at.SIGMA_1] * z_rate + c[at.SIGMA_2] * v
    inertia = c[at.MASS] + c[at.LOAD]
    if elastic(c, e):
        joint = joint_force(y, e)
        dy[at.STRETCH], dy[at.LOAD_V] = y[at.LOAD_V] - v, -joint / c[at.LOAD]
        force, inertia = force + joint, c[at.MASS]
    if c[at.LAW] >= 2.0:
        inertia += c[at.SIGMA_2] * c[at.T_FLUID]
    acceleration = force / inertia
    dy[at.X], dy[at.V], dy[at.Z] = v, acceleration, z_rate
    if memory[at.CONTACT] != 0.0:
        dy[at.X] = dy[at.V] = dy[at.Z] = 0.0
    return acceleration
