"""
Foreign laws of gas, valves and lines, written from the literature that ``foreign`` names.

``e`` holds for each slot the code of a form, its strength and two numbers of its shape; a strength
of zero leaves the plant as it is. ``c`` and ``y`` as in ``gas``.
"""

import math

import numpy as np

from . import constants as at
from .kept import block, kept

WOSCHNI, EICHELBERG, LAMINAR_CONVECTION, TURBULENT_CONVECTION, BY_MASS, THIN_WALL = range(1, 7)
LAMINAR_GAP, SONIC, LINEAR, POROUS, OPENING_SEAL, RELIEF = range(1, 7)
LABYRINTH, WORN_BORE = range(4, 6)
ROUNDED_LAND = 4
QUADRATIC_DROP, TANK, REGULATOR, PULSATION, SAWTOOTH = range(1, 6)
QUADRATIC, CUBIC, KNEE, SATURATING, ONE_EDGE, DEAD_BAND, DISCHARGE = range(1, 8)
SECOND_ORDER, RATE_LIMIT, SLOW_CLOSING, SPOOL_DRIFT = range(1, 5)
PREISACH, STICTION, ONE_FLANK, MAGNETIC, DEAD_TIME, DELAY_AND_LAG = range(1, 7)
PIPE, HELMHOLTZ, LINE_ORIFICE, LINE_LAG = range(1, 5)
DRYING, ELASTIC_HOSE = range(1, 3)

REFERENCE_PRESSURE, REFERENCE_TEMPERATURE, REFERENCE_SPEED = 3e5, 300.0, 0.1
"""At which the coefficients of heat transfer are as strong as stated [Pa, K, m/s]."""
DENSITY, NORMAL_TEMPERATURE = 1.185, 293.15
"""Of the reference atmosphere of ISO 6358 [kg/m^3, K]."""
RUN = 14.0
"""In which a drift reaches its strength [s], about one recording."""
FULL_VOLTAGE, CENTRE = 5.0, 2.5


@block
def wetted_area(volume: float, area: float) -> float:
    """Wall of a cylinder [m^2] that holds a volume [m^3] above a face [m^2]."""
    return 2.0 * area + 4.0 * volume / math.sqrt(4.0 * area / math.pi)


@block
def heat_coefficient(
    code: float, y: np.ndarray, pressure: float, hot: float, cold: float
) -> float:
    """
    Coefficient of heat transfer [-], as multiple of that at the reference state.

    Woschni 1967 (SAE 670931): p^0.8 T^-0.53 w^0.8. Eichelberg 1939: (p T)^1/2 c^1/3. McAdams,
    Heat Transmission, 1954: |dT|^1/4 in laminar, |dT|^1/3 in turbulent natural convection, with
    Grashof's number growing as p^2.
    """
    p, speed = pressure / REFERENCE_PRESSURE, abs(y[at.V]) / REFERENCE_SPEED
    if code == WOSCHNI:
        return p**0.8 * (hot / REFERENCE_TEMPERATURE) ** -0.53 * (1.0 + speed) ** 0.8
    if code == EICHELBERG:
        return math.sqrt(p * hot / REFERENCE_TEMPERATURE) * (0.5 + speed) ** (1.0 / 3.0)
    if code == LAMINAR_CONVECTION:
        return math.sqrt(p) * abs(hot - cold) ** 0.25
    if code == TURBULENT_CONVECTION:
        return p ** (2.0 / 3.0) * abs(hot - cold) ** (1.0 / 3.0)
    return 1.0


@block
def heat(
    y: np.ndarray, dy: np.ndarray, chamber: int, volume: float, c: np.ndarray, e: np.ndarray
) -> float:
    """Heat that flows into a chamber's gas [W]; the wall of finite capacity gives it."""
    code, strength = e[at.AT_HEAT], e[at.AT_HEAT + 1]
    if strength == 0.0:
        return 0.0
    pressure, mass, area = y[at.P1 + chamber], y[at.M1 + chamber], c[at.A1 + chamber]
    gas, wall = pressure * volume / (mass * c[at.R]), c[at.T_S]
    if code == BY_MASS:  # stirred gas: conductance as its mass (Kagawa 1985)
        return strength * mass * (wall - gas)
    surface = wetted_area(volume, area)
    if code == THIN_WALL:
        wall = y[at.WALL_1 + chamber]
    flow = strength * surface * heat_coefficient(code, y, pressure, gas, wall) * (wall - gas)
    if code == THIN_WALL:  # capacity and loss to the room for each m^2
        lost = e[at.AT_HEAT + 3] * (wall - c[at.T_S])
        dy[at.WALL_1 + chamber] = -(flow / surface + lost) / e[at.AT_HEAT + 2]
    return flow


@block
def iso_flow(upstream: float, downstream: float, critical: float, c: np.ndarray) -> float:
    """Mass flow [kg/s] of ISO 6358 for a sonic conductance of 1 m^3/(s Pa); signed."""
    high, low = max(upstream, downstream), min(upstream, downstream)
    flow = high * DENSITY * math.sqrt(NORMAL_TEMPERATURE / c[at.T_S])
    ratio = low / high
    if ratio > critical:
        flow *= math.sqrt(max(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2, 0.0))
    return -flow if downstream > upstream else flow


@block
def gap_flow(
    code: float, upstream: float, downstream: float, number: float, c: np.ndarray
) -> float:
    """
    Mass flow through a gap of strength 1; signed.

    Laminar: p1^2 - p2^2 (Blackburn, Fluid Power Control, 1960). Porous: (p - p_atm)^n. Labyrinth:
    sqrt(|p1^2 - p2^2|) (Egli 1935).
    """
    squares = upstream**2 - downstream**2
    if code == LAMINAR_GAP:
        return squares
    if code == SONIC:
        return iso_flow(upstream, downstream, number, c)
    return upstream - downstream


@block
def leak(y: np.ndarray, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] to the outside of a chamber at a pressure [Pa]."""
    code, strength, number = e[at.AT_LEAK], e[at.AT_LEAK + 1], e[at.AT_LEAK + 2]
    if strength == 0.0:
        return 0.0
    over = pressure - c[at.P_ATM]
    if code == POROUS:  # relative to 1 bar
        flow = strength * 1e5 * math.copysign((abs(over) / 1e5) ** number, over)
    elif code == OPENING_SEAL:  # the gap of a seal that creeps open
        flow = strength * over * y[at.CLOCK] / RUN
    elif code == RELIEF:  # opens above a pressure (spring-loaded poppet)
        flow = strength * max(pressure - number, 0.0)
    else:
        flow = strength * gap_flow(code, pressure, c[at.P_ATM], number, c)
    return flow


@block
def cross_leak(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] from chamber 1 past the piston into chamber 2."""
    code, strength, number = e[at.AT_CROSS], e[at.AT_CROSS + 1], e[at.AT_CROSS + 2]
    if strength == 0.0:
        return 0.0
    p1, p2 = y[at.P1], y[at.P2]
    if code == LABYRINTH:
        squares = p1 * p1 - p2 * p2
        return strength * math.copysign(math.sqrt(abs(squares)), squares)
    if code == WORN_BORE:
        place = (y[at.X] / c[at.STROKE] - number) / 0.15
        return strength * (p1 - p2) * math.exp(-place * place)
    return strength * gap_flow(code, p1, p2, number, c)


@block
def null_flow(supply: float, spool: float, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """
    Flow [kg/s] past the lands of a spool.

    The land of rounded edges leaves sqrt(o^2 + r^2) - o at an overlap o (Merritt, Hydraulic
    Control Systems, 1967); a laminar gap's resistance grows with its length.
    """
    code, strength = e[at.AT_NULL], e[at.AT_NULL + 1]
    if strength == 0.0:
        return 0.0
    outside, half = c[at.P_ATM], max(0.5 * (c[at.U_M] - c[at.U_N]), 1e-3)
    gaps = 1.0, 1.0
    overlaps = max(c[at.U_M] - spool, 0.0) / half, max(spool - c[at.U_N], 0.0) / half
    if code == LAMINAR_GAP:
        gaps = 1.0 / (1.0 + overlaps[0]), 1.0 / (1.0 + overlaps[1])
    if code == ROUNDED_LAND:
        gaps = (
            math.hypot(overlaps[0], 1.0) - overlaps[0],
            math.hypot(overlaps[1], 1.0) - overlaps[1],
        )
    law = float(SONIC) if code == ROUNDED_LAND else code
    critical, exhaust = e[at.AT_NULL + 2], e[at.AT_NULL + 3]
    into = gaps[0] * gap_flow(law, supply, pressure, critical, c)
    out = exhaust * gaps[1] * gap_flow(law, pressure, outside, critical, c)
    return strength * (into - out)


@block
def source(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Supply pressure [Pa] before anything resists; a regulator's and a tank's is a state."""
    code, strength, number = e[at.AT_SUPPLY], e[at.AT_SUPPLY + 1], e[at.AT_SUPPLY + 2]
    if strength == 0.0 or code == QUADRATIC_DROP:
        return c[at.P_S]
    if code == PULSATION:  # strokes of the compressor, `number` a second
        return c[at.P_S] + strength * math.sin(2.0 * math.pi * number * y[at.CLOCK])
    if code == SAWTOOTH:  # between the two points of its switch, `number` seconds apart
        share = y[at.CLOCK] / number
        return c[at.P_S] + strength * (0.5 - (share - math.floor(share)))
    return y[at.SOURCE]


@block
def source_rate(y: np.ndarray, flow: float, c: np.ndarray, e: np.ndarray) -> float:
    """
    Rate of the supply pressure [Pa/s] while a flow [kg/s] is drawn.

    A tank is filled through a hose in proportion to the difference of pressures; a regulator
    droops with the flow and follows with a lag (Andersen, The Analysis and Design of Pneumatic
    Systems, 1967).
    """
    code, strength, number = e[at.AT_SUPPLY], e[at.AT_SUPPLY + 1], e[at.AT_SUPPLY + 2]
    if code == TANK:
        return strength * (number * (c[at.P_S] - y[at.SOURCE]) - flow)
    if code == REGULATOR:
        return (c[at.P_S] - strength * flow - y[at.SOURCE]) / number
    return 0.0


@block
def bent(share: float, intake: bool, e: np.ndarray) -> float:
    """
    Opening [-] at a share [-] of the spool's travel, 0 to 1 without a form.

    Polynomials and tables as fitted to valves (Beater, Pneumatic Drives, 2007, ch. 5).
    """
    code, s, number = e[at.AT_CURVE], e[at.AT_CURVE + 1], e[at.AT_CURVE + 2]
    x = share
    if s == 0.0:
        return x
    if code == QUADRATIC:
        return (1.0 - s) * x + s * x * x
    if code == CUBIC:
        return (1.0 - s) * x + s * x**3
    if code == KNEE:
        return (1.0 - s) * x if x < number else x - s * number
    if code == SATURATING:
        return x / (1.0 + s * x)
    if code == ONE_EDGE:  # only one of the edges is bent
        return x if intake else float(x ** (1.0 + s))
    if code == DEAD_BAND:
        return max(x - s, 0.0)
    return x


@block
def discharge(upstream: float, downstream: float, e: np.ndarray) -> float:
    """Factor on a flow: the contraction of a jet weakens as the ratio falls (Perry 1949)."""
    if e[at.AT_CURVE] != DISCHARGE:
        return 1.0
    ratio = min(downstream / upstream, 1.0)
    return 1.0 - e[at.AT_CURVE + 1] * ratio * ratio


@block
def narrowed(area: float, e: np.ndarray) -> float:
    """Area [m^2] of an opening and an orifice in the line behind it (Andersen 1967)."""
    if e[at.AT_LINE] != LINE_ORIFICE:
        return area
    return area / math.hypot(1.0, e[at.AT_LINE + 1] * area)


@block
def spool_of(y: np.ndarray, dy: np.ndarray, place: int, target: float, e: np.ndarray) -> float:
    """
    Return where a spool is [V]; ``place`` 0 or 1.

    Mass on a spring; a servo of limited speed; a spring that closes slower than the coil opens
    (Merritt 1967); a null that drifts with temperature.
    """
    code, strength, number = e[at.AT_SPOOL], e[at.AT_SPOOL + 1], e[at.AT_SPOOL + 2]
    if strength == 0.0:
        return target
    now = y[at.SPOOL_1 + place]
    if code == SECOND_ORDER:
        speed = y[at.SPOOL_V1 + place]
        dy[at.SPOOL_1 + place] = speed
        dy[at.SPOOL_V1 + place] = ((target - now) / strength - 2.0 * number * speed) / strength
    elif code == RATE_LIMIT:  # strength is the time for 1 V
        rate = (target - now) / 1e-3
        dy[at.SPOOL_1 + place] = max(-1.0 / strength, min(1.0 / strength, rate))
    elif code == SLOW_CLOSING:
        opens = abs(target - CENTRE) > abs(now - CENTRE)
        dy[at.SPOOL_1 + place] = (target - now) / (strength * (number if opens else 1.0))
    elif code == SPOOL_DRIFT:
        now = target + strength * y[at.CLOCK] / RUN
    return now


@block
def through_line(
    y: np.ndarray, dy: np.ndarray, chamber: int, flow: float, c: np.ndarray, e: np.ndarray
) -> float:
    """
    Return the flow [kg/s] at the end of a line that takes a flow in at its beginning.

    A volume and a laminar hose; the same with the inertance of the gas in it (Helmholtz; Anderson
    and Hughes); a first-order lag.
    """
    code, volume, number = e[at.AT_LINE], e[at.AT_LINE + 1], e[at.AT_LINE + 2]
    if volume == 0.0 or code == LINE_ORIFICE:
        return flow
    pipe, end = at.PIPE_1 + chamber, at.LINE_1 + chamber
    if code == LINE_LAG:
        dy[end] = (flow - y[end]) / volume
        return y[end]
    over = y[pipe] - y[at.P1 + chamber]
    out = number * over
    if code == HELMHOLTZ:
        out = y[end]
        dy[end] = e[at.AT_LINE + 3] * (over - out / number)
    dy[pipe] = c[at.KAPPA] * c[at.R] * c[at.T_S] / volume * (flow - out)
    return out


@block
def at_valve(y: np.ndarray, chamber: int, e: np.ndarray) -> float:
    """Return the pressure that a valve works against [Pa]."""
    code = e[at.AT_LINE]
    if 0.0 < code <= HELMHOLTZ and e[at.AT_LINE + 1] > 0.0:
        return y[at.PIPE_1 + chamber]
    return y[at.P1 + chamber]


@block
def heaviness(y: np.ndarray, e: np.ndarray) -> float:
    """
    Factor on R T_s in the energy that a flow brings.

    Moisture raises R until the gas is dry; a choked flow falls as 1 / sqrt(R), so that its energy
    grows as sqrt(R) (moist air: ISO 8778, Beater 2007).
    """
    if e[at.AT_GAS] != DRYING:
        return 1.0
    return math.sqrt(1.0 + e[at.AT_GAS + 1] * math.exp(-y[at.CLOCK] / e[at.AT_GAS + 2]))


@block
def stiffened(volume: float, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """Volume [m^3] that takes the place of V in dp/dt, walls yielding dV/dp = strength."""
    if e[at.AT_GAS] != ELASTIC_HOSE:
        return volume
    grown = e[at.AT_GAS + 1] * (pressure - c[at.P_ATM])
    return volume + grown + c[at.KAPPA] * pressure * e[at.AT_GAS + 1]


@block
def late(voltages: np.ndarray, count: int) -> np.ndarray:
    """Return voltages so many samples later; shut before."""
    shifted = np.full_like(voltages, CENTRE)
    if count < len(voltages):
        shifted[count:] = voltages[: len(voltages) - count]
    return shifted


@kept
def targets(voltages: np.ndarray, interval: float, e: np.ndarray) -> np.ndarray:
    """
    Return where the voltages draw the spools to [V], shape (n, 2).

    Several plays of different widths (Preisach; Mayergoyz 1991); stiction that is left in one jump
    and holds again half its width too early (Choudhury 2005); play on one flank only; a smooth
    magnetic loop that forgets with the travel (Coleman and Hodgdon 1987); a dead time.
    """
    code, s, number = e[at.AT_PLAY], e[at.AT_PLAY + 1], e[at.AT_PLAY + 2]
    if s == 0.0:
        return voltages.copy()
    if code >= DEAD_TIME:
        return late(voltages, round(s / interval))
    found = np.empty_like(voltages)
    for side in range(2):
        plays, now, before = np.full(4, CENTRE), CENTRE, CENTRE
        loop = 0.0
        for k in range(len(voltages)):
            wanted = voltages[k, side]
            if code == PREISACH:
                for i in range(4):
                    half = 0.125 * s * (i + 1)
                    plays[i] = min(max(plays[i], wanted - half), wanted + half)
                now = plays.mean()
            elif code == STICTION:
                if abs(wanted - now) > s:
                    now = wanted - math.copysign(0.5 * s, wanted - now)
            elif code == ONE_FLANK:
                now = min(max(now, wanted), wanted + s)
            else:
                step = wanted - before
                goal = 1.0 if step > 0.0 else -1.0
                loop = goal + (loop - goal) * math.exp(-abs(step) / number)
                now, before = wanted - s * loop, wanted
            found[k, side] = now
    return found
