"""
Laws of friction, load, cushions and joints of the second list, from the literature of ``second``.

Each function is of both lists: where a form is of the first one, it is that of ``foreign_force``.
"""

import math

import numpy as np

from . import constants as at
from . import foreign_force as first
from .foreign_force import JOINT_DAMPING
from .kept import block

(
    THIRION, SIDE_LOAD, HEAT_BALANCE, ROOT_OUTWARD, RELAXING, TANH_CURVE, SQUEEZED_OUT, ENTRAINED,
    RUBBER_CORD, HOLDING_MAGNET, NEEDLE_VALVE, DRY_JOINT, EDDY_BRAKE,
) = range(at.SECOND_CODE + 1, at.SECOND_CODE + 14)  # fmt: skip

ROOT_SPEED, STRAIGHT_SPEED = 0.1, 1e-4
"""At which a force that grows as the root of speed is as strong as stated; below the second one it
is straight [m/s]."""
DRY_SPEED = 2e-3
"""Around which the friction of a joint changes its sign [m/s]."""
POCKET_REST, POCKET_EDGE, CHECK_TIME = 0.3, 1e-3, 5e-3
"""Of the pocket of a cushion: share that its piston leaves, depth at which it is shut [m], time of
its check valve [s]."""


@block
def over_pressure(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] of two lips: 1 / mu is straight in pressure, as rubber has it (Thirion 1946)."""
    if e[at.AT_PRESSURE] != THIRION:
        return 0.0
    total = 0.0
    for i in range(2):
        bars = max(y[at.P1 + i] - c[at.P_ATM], 0.0) / 1e5
        total += bars / (1.0 + bars / e[at.AT_PRESSURE + 2])
    return e[at.AT_PRESSURE + 1] * total


@block
def over_place(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Share of both levels [-] by a load across the rod: lever of a beam on piston and bush."""
    if e[at.AT_POSITION] != SIDE_LOAD:
        return 0.0
    place = y[at.X] / c[at.STROKE]
    return e[at.AT_POSITION + 1] * place / (1.0 + e[at.AT_POSITION + 2] - place)


@block
def over_history(y: np.ndarray, e: np.ndarray) -> float:
    """Share of both levels [-] by a viscosity that falls as exp(-heat) (Reynolds 1886)."""
    if e[at.AT_WARMING] != HEAT_BALANCE:
        return 0.0
    return math.exp(-e[at.AT_WARMING + 1] * y[at.HEATED]) - 1.0


@block
def added_levels(
    y: np.ndarray, bristles: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> tuple[float, float]:
    """Return what is added to F_c and F_smax [N]."""
    coulomb, largest = first.added_levels(y, bristles, memory, c, e)
    share = over_place(y, c, e) + over_history(y, e)
    force = over_pressure(y, c, e)
    return coulomb + share * c[at.F_C] + force, largest + share * c[at.F_S] + force


@block
def stribeck_excess(speed: float, c: np.ndarray, e: np.ndarray) -> float:
    """Return what the level of sliding friction is above F_c at a speed [N] (Makkar 2005)."""
    if e[at.AT_SHAPE] != TANH_CURVE:
        return first.stribeck_excess(speed, c, e)
    return e[at.AT_SHAPE + 1] * (1.0 - math.tanh(speed / (c[at.V_S] * e[at.AT_SHAPE + 2])))


@block
def dwell_share(dwell: float, e: np.ndarray) -> float:
    """
    Return the share of F_smax - F_c that a dwell time [s] leaves.

    A film that is squeezed out is as thin as t^-1/2 (Moore 1972); full at 1000 s.
    """
    if e[at.AT_DWELL] != SQUEEZED_OUT:
        return first.dwell_share(dwell, e)
    number = e[at.AT_DWELL + 2]
    grown = 1.0 - 1.0 / math.sqrt(1.0 + max(dwell, 0.0) / number)
    grown /= 1.0 - 1.0 / math.sqrt(1.0 + 1000.0 / number)
    return 1.0 - e[at.AT_DWELL + 1] * (1.0 - min(grown, 1.0))


@block
def film_rate(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Return dh/dt [1/s] of a film that the way draws in and the load squeezes out, as h^3."""
    if e[at.AT_FILM] != ENTRAINED:
        return first.foreign_film_rate(y, c, e)
    drawn_in = abs(y[at.V]) / e[at.AT_FILM + 2] * (1.0 - y[at.H])
    return drawn_in - y[at.H] ** 3 / e[at.AT_FILM + 3]


@block
def element_rates(
    y: np.ndarray, dy: np.ndarray, level: float, c: np.ndarray, e: np.ndarray
) -> float:
    """
    Write the rates of the elements' forces; return the force of all [N].

    The shear of a rubber lip, up to a share of the level, relaxes at rest: a Maxwell element that
    slides (Ferry 1980).
    """
    s = e[at.AT_BRISTLE + 1]
    if e[at.AT_BRISTLE] != RELAXING or s == 0.0:
        return first.element_rates(y, dy, level, c, e)
    v, force = y[at.V], y[at.ELEMENT_1]
    way = 1.0 if v > 0.0 else -1.0
    bent = s * level / e[at.AT_BRISTLE + 2] * v * (1.0 - way * force / (s * level))
    dy[at.ELEMENT_1] = bent - force / e[at.AT_BRISTLE + 3]
    return force


@block
def sums_elements(e: np.ndarray) -> bool:
    """Whether friction has the forces of elements beside that of the bristles."""
    code = e[at.AT_BRISTLE]
    return code == first.MAXWELL_SLIP or code == RELAXING


@block
def viscous(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """
    Force [N] that opposes the motion and comes of speed alone.

    A rod seal on a film that grows as the root of speed, outward (Blok 1963); a conductor in a
    magnetic field, largest at a speed (Smythe 1942).
    """
    v, force = y[at.V], first.viscous(y, c, e)
    if e[at.AT_SIDE] == ROOT_OUTWARD and v > 0.0:
        force += e[at.AT_SIDE + 1] * v / math.sqrt(ROOT_SPEED * (v + STRAIGHT_SPEED))
    if e[at.AT_VISCOUS] == EDDY_BRAKE:
        ratio = v / e[at.AT_VISCOUS + 2]
        force += e[at.AT_VISCOUS + 1] * 2.0 * ratio / (1.0 + ratio * ratio)
    return force


@block
def history_rates(y: np.ndarray, dy: np.ndarray, friction: float, e: np.ndarray) -> None:
    """Write the rates of time, way or work, of the speed that is remembered, and of heat."""
    first.history_rates(y, dy, friction, e)
    if e[at.AT_WARMING] == HEAT_BALANCE:
        power = abs(friction * y[at.V]) / e[at.AT_WARMING + 2]
        dy[at.HEATED] = power - y[at.HEATED] / e[at.AT_WARMING + 3]


@block
def load_force(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """
    Force [N] along the outstroke of what is coupled to the rod.

    A cord of rubber, lambda - lambda^-2 (Treloar 1975); a magnet that holds at the outer end
    (Furlani 2001).
    """
    code, s, number = e[at.AT_LOAD], e[at.AT_LOAD + 1], e[at.AT_LOAD + 2]
    if code == RUBBER_CORD:
        stretched = 1.0 + number * y[at.X] / c[at.STROKE]
        return -s * (stretched - stretched**-2)
    if code == HOLDING_MAGNET:
        gap = max(c[at.STROKE] - y[at.X], 0.0) / number
        return s / (1.0 + gap) ** 2
    return first.load_force(y, c, e)


@block
def entered(y: np.ndarray, end: int, c: np.ndarray, e: np.ndarray) -> tuple[float, float, float]:
    """
    Return how far a cushion's piston is in its pocket [m], its speed [m/s] and how shut that is.

    :param end: 0 for the inner one
    """
    length = e[at.AT_PAD + 2]
    depth, speed = length - y[at.X], -y[at.V]
    if end == 1:
        depth, speed = y[at.X] - c[at.STROKE] + length, y[at.V]
    return depth, speed, max(0.0, min(1.0, depth / POCKET_EDGE))


@block
def pads(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] along the outstroke of the cushions at both ends."""
    if e[at.AT_PAD] != NEEDLE_VALVE:
        return first.pads(y, c, e)
    total = 0.0
    for end in range(2):
        shut = entered(y, end, c, e)[2]
        push = e[at.AT_PAD + 1] * shut * max(y[at.POCKET_1 + end], 0.0)
        total += push if end == 0 else -push
    return total


@block
def pocket_rates(y: np.ndarray, dy: np.ndarray, c: np.ndarray, e: np.ndarray) -> None:
    """
    Write the rates of the overpressures in the pockets, as shares of the pressure around them.

    A pocket is shut when its piston has entered, and empties through a needle; a check valve lets
    it fill (Beater 2007).
    """
    if e[at.AT_PAD] != NEEDLE_VALVE:
        return
    length = e[at.AT_PAD + 2]
    for end in range(2):
        depth, speed, shut = entered(y, end, c, e)
        over = y[at.POCKET_1 + end]
        left = (1.0 + POCKET_REST) * length - max(0.0, min(depth, length))
        pressed = c[at.KAPPA] * (1.0 + over) * speed / left
        opened = shut / e[at.AT_PAD + 3] + (1.0 - shut) / CHECK_TIME
        if over < 0.0:
            opened = 1.0 / CHECK_TIME
        dy[at.POCKET_1 + end] = shut * pressed - over * opened


@block
def joint(y: np.ndarray, e: np.ndarray) -> float:
    """Force [N] of a joint; one with dry friction beside its spring (Den Hartog 1931)."""
    if e[at.AT_JOINT] != DRY_JOINT:
        return first.foreign_joint(y, e)
    slip = y[at.LOAD_V] - y[at.V]
    dry = e[at.AT_JOINT + 2] * math.tanh(slip / DRY_SPEED)
    return y[at.STRETCH] / e[at.AT_JOINT + 1] + dry + JOINT_DAMPING * slip
