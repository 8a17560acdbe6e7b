"""
Foreign laws of friction, load, cushions and joints, from the literature that ``foreign`` names.

``e`` as in ``foreign_gas``; a strength of zero leaves the plant as it is.
"""

import math

import numpy as np

from . import constants as at
from .foreign_gas import RUN
from .kept import block

POWER_OF_PRESSURE, FIRST_LIP, SECOND_LIP, DIFFERENCE = range(1, 5)
BUMP, TAPER, SLEEVE, LONG_WAVE, SHORT_WAVE, STICKING_PLACE = range(1, 7)
BY_TIME, BY_DISTANCE, RISING, WEAR = range(1, 5)
OUTWARD_LEVEL, OUTWARD_EXCESS, OUTWARD_VISCOUS, INWARD_FORCE = range(1, 5)
DAHL, ELASTO_PLASTIC, MAXWELL_SLIP = range(1, 4)
TUSTIN, LORENTZ, HESS_SOOM, BO_PAVELESCU = range(1, 5)
LOGARITHMIC, POWER_OF_DWELL, RATIONAL = range(1, 4)
LINEAR_FILM, FILM_BY_DISTANCE = range(1, 3)
(
    PROGRESSIVE,
    DEAD_ZONE,
    GAS_SPRING,
    ECCENTRIC,
    CURVED_RAIL,
    DETENT,
    SHAKING_FLOOR,
    SLOSHING,
) = range(1, 9)
AIR_ORIFICE, TRAPPED_AIR, RUBBER = range(1, 4)
BACKLASH, HARDENING = range(1, 3)
THICK_OIL, THINNING_OIL, CHURNING, MEMORY = range(1, 5)
CREEPING_STOP = 1

SWING_RATE, SWING_DAMPING = 9.0, 0.1
"""Of a load that swings [rad/s, -]."""
JOINT_DAMPING = 5.0
"""[N s/m]"""
SHARES = (0.2, 0.3, 0.5)
"""Of the force of an element model that each element takes [-]."""
ATTRACTION = 200.0
"""How fast the force of an element that slides goes to its level [1/s]."""


@block
def side_of(y: np.ndarray, bristles: float, memory: np.ndarray, c: np.ndarray) -> float:
    """Return the way of the motion or, at rest, of what pushes, -1 to 1."""
    if memory[at.STICKING] == 1.0:
        return max(-1.0, min(1.0, 2.0 * bristles / c[at.F_C]))
    return 1.0 if y[at.V] > 0.0 else -1.0


@block
def walk(t: float, number: float) -> float:
    """
    Random walk with a standard deviation of 1 at the end of a run (Karhunen-Loeve, 8 terms).

    :param number: which walk
    """
    total = 0.0
    for k in range(8):
        chaos = math.sin(12.9898 * (k + 1.0) + 78.233 * number) * 43758.5453
        drawn = math.sqrt(12.0) * (chaos - math.floor(chaos) - 0.5)
        rate = (k + 0.5) * math.pi
        total += drawn * math.sqrt(2.0) * math.sin(rate * t / RUN) / rate
    return total


@block
def over_place(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Share of both levels [-] that the position adds."""
    code, s, number = e[at.AT_POSITION], e[at.AT_POSITION + 1], e[at.AT_POSITION + 2]
    place = y[at.X] / c[at.STROKE]
    if s == 0.0 or code > STICKING_PLACE:
        return 0.0
    if code == BUMP:
        return s * math.exp(-(((place - number) / e[at.AT_POSITION + 3]) ** 2))
    if code == TAPER:
        return s * (2.0 * place - 1.0) ** 2
    if code == SLEEVE:
        return s * 0.5 * (1.0 + math.tanh((place - number) / 0.02))
    if code == STICKING_PLACE:
        return s * math.exp(-(((place - number) / 0.012) ** 2))
    return s * math.sin(2.0 * math.pi * number * place)


@block
def over_history(y: np.ndarray, e: np.ndarray) -> float:
    """Share of both levels [-] that time, way or work add."""
    code, s, number = e[at.AT_WARMING], e[at.AT_WARMING + 1], e[at.AT_WARMING + 2]
    if code == BY_TIME:
        return -s * (1.0 - math.exp(-y[at.CLOCK] / number))
    if code == BY_DISTANCE:
        return -s * (1.0 - math.exp(-y[at.WAY] / number))
    if code == RISING:
        return s * (1.0 - math.exp(-y[at.WAY] / number))
    return s * walk(y[at.CLOCK], number) if code == WEAR else 0.0


@block
def over_pressure(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] that the pressures add to both levels."""
    code, s = e[at.AT_PRESSURE], e[at.AT_PRESSURE + 1]
    first, second = (y[at.P1] - c[at.P_ATM]) / 1e5, (y[at.P2] - c[at.P_ATM]) / 1e5
    if code == POWER_OF_PRESSURE:
        return s * max(0.5 * (first + second), 0.0) ** e[at.AT_PRESSURE + 2]
    if code == FIRST_LIP:
        return s * max(first, 0.0)
    if code == SECOND_LIP:
        return s * max(second, 0.0)
    return s * abs(first - second) if code == DIFFERENCE else 0.0


@block
def added_levels(
    y: np.ndarray, bristles: float, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> tuple[float, float]:
    """Return what is added to F_c and F_smax [N]."""
    share = over_place(y, c, e) + over_history(y, e)
    force = over_pressure(y, c, e)
    code, s = e[at.AT_SIDE], e[at.AT_SIDE + 1]
    outward = 0.0
    if s != 0.0:
        outward = max(side_of(y, bristles, memory, c), 0.0)
    if code == OUTWARD_LEVEL:
        share += s * outward
    if code == INWARD_FORCE:
        force += s * (1.0 - outward)
    excess = s * outward * (c[at.F_S] - c[at.F_C]) if code == OUTWARD_EXCESS else 0.0
    return share * c[at.F_C] + force, share * c[at.F_S] + force + excess


@block
def stribeck_excess(speed: float, c: np.ndarray, e: np.ndarray) -> float:
    """
    Return what the level of sliding friction is above F_c at a speed [N].

    Tustin 1947 exp(-|v| / v_s), Lorentz 1 / (1 + (v / v_s)^2) (Hess and Soom 1990), 1 / (1 +
    |v| / v_s), Bo and Pavelescu 1982 exp(-(|v| / v_s)^n) with n of 0.5 to 1.
    """
    code, s = e[at.AT_SHAPE], e[at.AT_SHAPE + 1]
    ratio = speed / (c[at.V_S] * e[at.AT_SHAPE + 2]) if s != 0.0 else 0.0
    if code == TUSTIN:
        return s * math.exp(-ratio)
    if code == LORENTZ:
        return s / (1.0 + ratio * ratio)
    if code == HESS_SOOM:
        return s / (1.0 + ratio)
    return s * math.exp(-(ratio ** e[at.AT_SHAPE + 3])) if code == BO_PAVELESCU else 0.0


@block
def dwell_share(dwell: float, e: np.ndarray) -> float:
    """
    Return the share of F_smax - F_c that a dwell time [s] leaves.

    Logarithmic: Rabinowicz 1958, Dieterich 1972; power: Brockley and Davis 1968; rational: Kato
    1972. All are full at 1000 s.
    """
    code, s, number = e[at.AT_DWELL], e[at.AT_DWELL + 1], e[at.AT_DWELL + 2]
    grown = 1.0
    if code == LOGARITHMIC:
        grown = math.log1p(dwell / number) / math.log1p(1000.0 / number)
    elif code == POWER_OF_DWELL:
        grown = (max(dwell, 0.0) / 1000.0) ** number
    elif code == RATIONAL:
        grown = dwell / (dwell + number) * (1000.0 + number) / 1000.0
    return 1.0 - s * (1.0 - min(grown, 1.0))


@block
def film_share(y: np.ndarray, e: np.ndarray) -> float:
    """Return the share of F_s - F_c that the film leaves."""
    return 1.0 - e[at.AT_FILM + 1] * max(0.0, min(1.0, y[at.H]))


@block
def foreign_film_rate(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Return dh/dt [1/s] of a film that is linear in speed, or grows with the way slid."""
    steady = min(abs(y[at.V]) / c[at.V_B], 1.0)
    if e[at.AT_FILM] == LINEAR_FILM:
        return (steady - y[at.H]) / e[at.AT_FILM + 2]
    return abs(y[at.V]) / e[at.AT_FILM + 2] * (steady - y[at.H])


@block
def bending(ratio: float, e: np.ndarray) -> float:
    """
    Return the share of the travel that bends the bristles, 1 - ratio without a form.

    :param ratio: force of the bristles along the travel over the level of friction

    Dahl 1968 (1 - ratio)^n; elasto-plastic, Dupont et al. 2002: purely elastic below half of where
    all slides.
    """
    code, s = e[at.AT_BRISTLE], e[at.AT_BRISTLE + 1]
    if code == DAHL:
        left = 1.0 - ratio
        return math.copysign(abs(left) ** (1.0 + s), left)
    if code == ELASTO_PLASTIC and s > 0.0:
        low, high = 0.5 * s, s
        part = 1.0
        if ratio < high:
            middle = (ratio - 0.5 * (low + high)) / (high - low)
            part = 0.5 + 0.5 * math.sin(math.pi * middle) if ratio > low else 0.0
        return 1.0 - part * ratio
    return 1.0 - ratio


@block
def slipped(
    z: float,
    travel: float,
    level: float,
    stiffness: np.ndarray,
    memory: np.ndarray,
    limit: np.ndarray,
    e: np.ndarray,
) -> float:
    """Return the deflection [m] after a travel [m], backward Euler, by bisection."""
    way = 1.0 if travel > 0.0 else -1.0
    low, high = min(z, z + travel), max(z, z + travel)
    for i in range(len(stiffness)):  # what relaxes may go beyond where it was
        low = min(low, -level / stiffness[i])
        high = max(high, level / stiffness[i])
    for _ in range(80):
        new = 0.5 * (low + high)
        force = 0.0
        for i in range(len(stiffness)):
            part = stiffness[i] * (new - memory[at.ANCHORS + i])
            force += max(-limit[i], min(limit[i], part)) if i < len(limit) else part
        if new - z - travel * bending(way * force / level, e) > 0.0:
            high = new
        else:
            low = new
    return 0.5 * (low + high)


@block
def element_rates(
    y: np.ndarray, dy: np.ndarray, level: float, c: np.ndarray, e: np.ndarray
) -> float:
    """
    Write the rates of the elements' forces; return the force of all [N].

    Generalised Maxwell slip, Al-Bender et al. 2005: an element sticks as a spring, or slides and
    its force is attracted to its share of the Stribeck curve; here the two are blended near it.
    """
    if e[at.AT_BRISTLE] != MAXWELL_SLIP or e[at.AT_BRISTLE + 1] == 0.0:
        return 0.0
    total, v, s = 0.0, y[at.V], e[at.AT_BRISTLE + 1]
    way = 1.0 if v > 0.0 else -1.0
    for i in range(3):
        force, top = y[at.ELEMENT_1 + i], s * SHARES[i] * level
        stuck = s * c[at.F_C] / e[at.AT_BRISTLE + 2] * v
        slides = max(0.0, min(1.0, 20.0 * (way * force / top - 0.95)))
        attracted = ATTRACTION * abs(v) / (abs(v) + 1e-3) * (way * top - force)
        dy[at.ELEMENT_1 + i] = slides * attracted + (1.0 - slides) * stuck
        total += force
    return total


@block
def viscous(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] that opposes the motion and comes of speed alone."""
    v, force = y[at.V], 0.0
    code, s, number = e[at.AT_VISCOUS], e[at.AT_VISCOUS + 1], e[at.AT_VISCOUS + 2]
    if e[at.AT_SIDE] == OUTWARD_VISCOUS:
        force += e[at.AT_SIDE + 1] * max(v, 0.0)
    if code == THICK_OIL:  # viscosity grows with pressure (Barus 1893)
        over = (y[at.P1] + y[at.P2] - 2.0 * c[at.P_ATM]) / 1e5
        force += s * c[at.SIGMA_2] * over * v
    elif code == THINNING_OIL:  # and falls as it warms (Vogel 1921)
        force -= s * c[at.SIGMA_2] * (1.0 - math.exp(-y[at.WAY] / number)) * v
    elif code == CHURNING:
        force += s * v * abs(v)
    elif code == MEMORY:  # friction that is behind the speed (Hess and Soom 1990)
        force += s * c[at.SIGMA_2] * (y[at.LATE] - v)
    return force


@block
def history_rates(y: np.ndarray, dy: np.ndarray, friction: float, e: np.ndarray) -> None:
    """Write the rates of time, way or work, and of the speed that is remembered."""
    dy[at.CLOCK] = 1.0
    dy[at.WAY] = abs(friction * y[at.V]) if e[at.AT_WARMING] == RISING else abs(y[at.V])
    if e[at.AT_VISCOUS] == MEMORY:
        dy[at.LATE] = (y[at.V] - y[at.LATE]) / e[at.AT_VISCOUS + 2]


@block
def load_force(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] along the outstroke of what is coupled to the rod."""
    code, s, number = e[at.AT_LOAD], e[at.AT_LOAD + 1], e[at.AT_LOAD + 2]
    x, place = y[at.X], y[at.X] / c[at.STROKE]
    weight = 9.80665 * (c[at.MASS] + c[at.LOAD])
    if s == 0.0:
        return 0.0
    if code == PROGRESSIVE:
        return -s * x * place * place
    if code == DEAD_ZONE:
        return -s * max(x - number * c[at.STROKE], 0.0)
    if code == GAS_SPRING:
        return -s * ((1.0 - 0.6 * place) ** -1.4 - 1.0)
    if code == ECCENTRIC:
        return -s * weight * math.cos(2.0 * math.pi * number * place)
    if code == CURVED_RAIL:
        return -s * weight * (2.0 * place - 1.0)
    if code == DETENT:
        return -s * math.sin(2.0 * math.pi * x / number)
    if code == SHAKING_FLOOR:
        return s * weight / 9.80665 * math.sin(2.0 * math.pi * number * y[at.CLOCK])
    slip = y[at.SWING_V] - y[at.V]
    pull = SWING_RATE * (SWING_RATE * y[at.SWING] + 2.0 * SWING_DAMPING * slip)
    return s * weight / 9.80665 * pull


@block
def swing_rates(y: np.ndarray, dy: np.ndarray, e: np.ndarray) -> None:
    """Write the rates of a load that swings (Ibrahim, Liquid Sloshing Dynamics, 2005)."""
    if e[at.AT_LOAD] == SLOSHING:
        slip = y[at.SWING_V] - y[at.V]
        pull = SWING_RATE * (SWING_RATE * y[at.SWING] + 2.0 * SWING_DAMPING * slip)
        dy[at.SWING], dy[at.SWING_V] = slip, -pull


@block
def pad_force(depth: float, speed: float, e: np.ndarray) -> float:
    """
    Push [N] of a cushion that is pressed in by a depth [m] at a speed [m/s].

    Trapped air leaves through an orifice, or not; rubber as Hunt and Crossley 1975.
    """
    code, s, length = e[at.AT_PAD], e[at.AT_PAD + 1], e[at.AT_PAD + 2]
    if depth <= 0.0 or s == 0.0:
        return 0.0
    if code == AIR_ORIFICE:
        return s * depth / length * max(speed, 0.0) ** 2
    if code == TRAPPED_AIR:
        return s * ((1.0 - 0.9 * min(depth / length, 1.0)) ** -1.4 - 1.0)
    return max(s * depth**1.5 * (1.0 + e[at.AT_PAD + 3] * speed), 0.0)


@block
def pads(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Force [N] along the outstroke of the cushions at both ends."""
    length = e[at.AT_PAD + 2]
    inner = pad_force(length - y[at.X], -y[at.V], e)
    return inner - pad_force(y[at.X] - c[at.STROKE] + length, y[at.V], e)


@block
def foreign_joint(y: np.ndarray, e: np.ndarray) -> float:
    """Force [N] of a joint with play, or of one that hardens, whose compliance is the strength."""
    stretch, compliance, number = y[at.STRETCH], e[at.AT_JOINT + 1], e[at.AT_JOINT + 2]
    damping = JOINT_DAMPING * (y[at.LOAD_V] - y[at.V])
    if e[at.AT_JOINT] == BACKLASH:  # outside of the play alone
        free = max(abs(stretch) - 0.5 * number, 0.0)
        return math.copysign(free / compliance, stretch) + (damping if free > 0.0 else 0.0)
    return stretch / compliance * (1.0 + (stretch / number) ** 2) + damping
