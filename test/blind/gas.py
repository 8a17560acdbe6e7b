"""
The gas of the second plant: Eq. 3-7, written anew, with what can be hidden in it.

``c`` are the constants, ``e`` what is hidden, ``y`` the state, see ``constants``.
"""

import math

import numpy as np

from . import constants as at
from . import foreign_gas as foreign
from . import second_gas as second
from .kept import block

FULL_VOLTAGE = 5.0


@block
def orifice(upstream: float, downstream: float, area: float, c: np.ndarray) -> float:
    """Mass flow [kg/s] of Eq. 3-5 through an area [m^2]; negative if downstream is higher."""
    k = c[at.KAPPA]
    high, low = max(upstream, downstream), min(upstream, downstream)
    ratio = low / high
    if ratio < (2.0 / (k + 1.0)) ** (k / (k - 1.0)):
        psi = (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    else:
        r = min(ratio, c[at.LAMINAR])
        psi = math.sqrt(2.0 / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))
        if ratio > c[at.LAMINAR]:
            psi *= (1.0 - ratio) / (1.0 - c[at.LAMINAR])
    flow = psi * high * math.sqrt(k / (c[at.R] * c[at.T_S])) * area
    return -flow if downstream > upstream else flow


@block
def openings(spool: float, c: np.ndarray, e: np.ndarray) -> tuple[float, float]:
    """
    Areas [m^2] of intake and exhaust with the spool at a voltage; full opening unbent.

    The exhaust has a hole of its own from its edge on, if its opening is counted from before it. A
    foreign curve bends the share of the travel, and an orifice of the line is behind the opening.
    """
    strange = e.size > at.FOREIGN
    if spool > c[at.U_M]:
        full = FULL_VOLTAGE - c[at.U_M]
        share = (spool - c[at.U_M]) / full
        if strange:
            share = second.bent(share, True, e)
        area = c[at.K_V1] * full * share ** e[at.OPENING_IN]
        return (foreign.narrowed(area, e) if strange else area), 0.0
    if spool < c[at.U_N]:
        share = 1.0 - spool / c[at.U_N]
        if strange:
            share = second.bent(share, False, e)
        area = c[at.K_V2] * (c[at.U_0] - c[at.U_N] + c[at.U_N] * share ** e[at.OPENING_OUT])
        return 0.0, (foreign.narrowed(area, e) if strange else area)
    return 0.0, 0.0


@block
def drawn(supply: float, y: np.ndarray, in_1: float, in_2: float, c: np.ndarray) -> float:
    """Flow [kg/s] out of the supply line at a pressure [Pa]; back flow does not raise it."""
    flow_1, flow_2 = orifice(supply, y[at.P1], in_1, c), orifice(supply, y[at.P2], in_2, c)
    return max(flow_1, 0.0) + max(flow_2, 0.0)


@block
def lawful_droop(
    before: float, y: np.ndarray, in_1: float, in_2: float, c: np.ndarray, e: np.ndarray
) -> float:
    """Supply pressure [Pa] behind a resistance with a law of its own, by bisection."""
    low, high = 0.0, before - c[at.P_ATM]
    for _ in range(60):
        droop = 0.5 * (low + high)
        if second.droop(drawn(before - droop, y, in_1, in_2, c), e) > droop:
            low = droop
        else:
            high = droop
    return before - 0.5 * (low + high)


@block
def drooped_supply(y: np.ndarray, in_1: float, in_2: float, c: np.ndarray, e: np.ndarray) -> float:
    """Supply pressure [Pa] behind a resistance, found by bisection."""
    before = c[at.P_S] - y[at.TANK]
    if e.size > at.FOREIGN:
        before = second.source(y, c, e) - y[at.TANK]
        if second.droops(e):
            return lawful_droop(before, y, in_1, in_2, c, e)
    if e[at.DROOP] == 0.0 or in_1 + in_2 == 0.0:
        return before
    low, high = 0.0, min(e[at.DROOP] * drawn(before, y, in_1, in_2, c), before)
    for _ in range(60):
        droop = 0.5 * (low + high)
        if e[at.DROOP] * drawn(before - droop, y, in_1, in_2, c) > droop:
            low = droop
        else:
            high = droop
        if high - low < 1e-7:
            break
    return before - 0.5 * (low + high)


@block
def behind_line(
    supply: float, pressure: float, inward: float, outward: float, c: np.ndarray, e: np.ndarray
) -> float:
    """
    Flow [kg/s] into a chamber through a valve's areas [m^2] and a line, by bisection.

    The line is a tube with turbulent, isothermal flow: p_v^2 - p^2 = (R m') |R m'|.
    """
    flow = orifice(supply, pressure, inward, c) - orifice(pressure, c[at.P_ATM], outward, c)
    if e[at.LINE_DROP] == 0.0 or flow == 0.0:
        return flow
    low, high = 0.0, 1.0
    for _ in range(60):
        share = 0.5 * (low + high)
        drop = e[at.LINE_DROP] * share * flow
        valve = math.sqrt(max(pressure**2 + drop * abs(drop), (0.01 * pressure) ** 2))
        passed = orifice(supply, valve, inward, c) - orifice(valve, c[at.P_ATM], outward, c)
        if passed / flow > share:
            low = share
        else:
            high = share
    return 0.5 * (low + high) * flow


@block
def spool_at(y: np.ndarray, dy: np.ndarray, i: int, target: float, e: np.ndarray) -> float:
    """
    Return where the spool of a chamber, 0 or 1, is [V]; write its rate.

    It lags, or moves 1 V in a time at least; near its place that is a lag of 1 ms.
    """
    place = at.SPOOL_1 + i
    if e[at.LAG_TIME] > 0.0:
        dy[place] = (target - y[place]) / e[at.LAG_TIME]
        target = y[place]
    if e[at.VOLT_TIME] > 0.0:
        limit = 1.0 / e[at.VOLT_TIME]
        dy[place] = max(-limit, min((target - y[place]) / 1e-3, limit))
        target = y[place]
    return target


@block
def out_of_line(y: np.ndarray, dy: np.ndarray, i: int, flow: float, e: np.ndarray) -> float:
    """Return the flow [kg/s] out of a line that lags, or has none; write its rate."""
    if e[at.LINE_TIME] == 0.0:
        return flow
    dy[at.LINE_1 + i] = (flow - y[at.LINE_1 + i]) / e[at.LINE_TIME]
    return y[at.LINE_1 + i]


@block
def null_leak(spool: float, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] past the lands: a gap's resistance grows with its length."""
    if e[at.NULL_IN] + e[at.NULL_OUT] == 0.0:
        return 0.0
    half = max(0.5 * (c[at.U_M] - c[at.U_N]), 1e-3)
    intake = e[at.NULL_IN] / (1.0 + max(c[at.U_M] - spool, 0.0) / half)
    exhaust = e[at.NULL_OUT] / (1.0 + max(spool - c[at.U_N], 0.0) / half)
    into = orifice(c[at.P_S], pressure, intake, c)
    return into - orifice(pressure, c[at.P_ATM], exhaust, c)


@block
def past_piston(place: float, c: np.ndarray, e: np.ndarray) -> float:
    """Area [m^2] of the leak past the piston, with that of a worn part of the bore."""
    if e[at.WORN] == 0.0:
        return e[at.CROSS]
    away = (place - e[at.WORN_PLACE] * c[at.STROKE]) / (e[at.WORN_WIDTH] * c[at.STROKE])
    return e[at.CROSS] + e[at.WORN] / math.exp(away * away)


@block
def pores(pressure: float, flow: float, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] out through pores, a power of the bars above atmosphere; straight near 0."""
    if flow == 0.0:
        return 0.0
    bars = 1e-5 * (pressure - c[at.P_ATM])
    if abs(bars) < 1e-3:
        return flow * 1e-3 ** e[at.PORES_POWER] * bars / 1e-3
    return math.copysign(flow * abs(bars) ** e[at.PORES_POWER], bars)


@block
def heated(
    y: np.ndarray, i: int, pressure: float, volume: float, c: np.ndarray, e: np.ndarray
) -> float:
    """
    Heat [W] that the gas of a chamber, 0 or 1, takes from its wall.

    By conduction, by a rising or falling layer of gas, and by gas that is stirred, which takes
    more of a wall [m^2] at a higher pressure.
    """
    if e[at.HEAT_1] + e[at.HEAT_2] + e[at.CONVECTION_1] + e[at.CONVECTION_2] + e[at.FORCED] == 0.0:
        return 0.0
    colder, area = c[at.T_S] - pressure * volume / (y[at.M1 + i] * c[at.R]), c[at.A1 + i]
    wall = 2.0 * area + 4.0 * volume / math.sqrt(4.0 * area / math.pi)
    forced = e[at.FORCED] * wall * (pressure / 3e5) ** e[at.FORCED_POWER]
    tens, power = 0.1 * colder, 1.0 + e[at.CONVECTION_POWER]
    convected = math.copysign(10.0 * e[at.CONVECTION_1 + i] * abs(tens) ** power, tens)
    return (e[at.HEAT_1 + i] + forced) * colder + convected


@block
def stirred(
    y: np.ndarray,
    dy: np.ndarray,
    i: int,
    volume: float,
    flow: float,
    c: np.ndarray,
    e: np.ndarray,
) -> float:
    """
    Heat [W] that the gas of a chamber, 0 or 1, takes from its wall by its own motion.

    As much for each gram, or as jets of the inflow [kg/s] stir it, Nu as Re^0.67 of a flow that
    lags.
    """
    if e[at.JET] + e[at.BY_GAS_MASS] == 0.0:
        return 0.0
    area, mass = c[at.A1 + i], y[at.M1 + i]
    dy[at.JET_1 + i] = (1e4 * max(flow, 0.0) - y[at.JET_1 + i]) / e[at.JET_TIME]
    wall = 2.0 * area + 4.0 * volume / math.sqrt(4.0 * area / math.pi)
    jets = e[at.JET] * wall * max(y[at.JET_1 + i], 0.0) ** 0.67
    for_each_gram = e[at.BY_GAS_MASS] * mass * c[at.R] / (c[at.KAPPA] - 1.0)
    return (jets + for_each_gram) * (c[at.T_S] - y[at.P1 + i] * volume / (mass * c[at.R]))


@block
def volume_of(y: np.ndarray, i: int, c: np.ndarray) -> float:
    """Volume [m^3] of a chamber, 0 or 1."""
    if i == 0:
        return c[at.V10] + c[at.A1] * y[at.X]
    return c[at.V20] + c[at.A2] * (c[at.STROKE] - y[at.X])


@block
def tank_rate(
    y: np.ndarray, supply: float, in_1: float, in_2: float, c: np.ndarray, e: np.ndarray
) -> float:
    """Rate of what the tank lacks [Pa/s]."""
    return e[at.TANK_FALL] * drawn(supply, y, in_1, in_2, c) - y[at.TANK] / e[at.TANK_TIME]


@block
def foreign_rates(
    y: np.ndarray, dy: np.ndarray, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> None:
    """Write the rates of pressures, gas masses, lines, spools, walls and supply; forms foreign."""
    outside, k = c[at.P_ATM], c[at.KAPPA]
    rt = c[at.R] * c[at.T_S] * foreign.heaviness(y, e)
    ends = second.at_valve(y, 0, e), second.at_valve(y, 1, e)
    spools, inward, outward = np.empty(2), np.empty(2), np.empty(2)
    for i in range(2):
        target = second.spool_of(y, dy, i, memory[at.TARGET_1 + i], e)
        spools[i] = spool_at(y, dy, i, target, e)
        inward[i], outward[i] = openings(spools[i], c, e)
    valves = y.copy()  # with the pressures that the valves work against
    valves[at.P1], valves[at.P2] = ends
    supply = drooped_supply(valves, inward[0], inward[1], c, e)
    if e[at.TANK_FALL] > 0.0:
        dy[at.TANK] = tank_rate(valves, supply, inward[0], inward[1], c, e)
    across = orifice(y[at.P1], y[at.P2], past_piston(y[at.X], c, e), c)
    across += second.cross_leak(y, c, e)
    total = 0.0
    for i in range(2):
        pressure, sign = y[at.P1 + i], 1.0 - 2.0 * i
        into = orifice(supply, ends[i], inward[i], c) * foreign.discharge(supply, ends[i], e)
        out = orifice(ends[i], outside, outward[i], c) * foreign.discharge(ends[i], outside, e)
        total += max(into, 0.0)
        net = into - out
        if e[at.LINE_DROP] > 0.0:
            net = behind_line(supply, ends[i], inward[i], outward[i], c, e)
        flow = out_of_line(y, dy, i, second.through_line(y, dy, i, net, c, e), e)
        flow += null_leak(spools[i], pressure, c, e)
        flow += second.null_flow(c[at.P_S], spools[i], pressure, c, e)
        share = e[at.AT_LEAK + 3] if i == 0 else 1.0
        flow -= orifice(pressure, outside, e[at.LEAK_1 + i], c)
        flow -= pores(pressure, e[at.PORES_1 + i], c, e)
        flow -= sign * across + share * second.leak(y, pressure, c, e)
        flow -= second.side_flow(y, dy, i, c, e)
        volume = volume_of(y, i, c)
        warmth = second.heat(y, dy, i, volume, flow, c, e) + heated(y, i, pressure, volume, c, e)
        warmth += stirred(y, dy, i, volume, net, c, e)
        dy[at.M1 + i] = flow
        work = k * (rt * flow - sign * pressure * c[at.A1 + i] * y[at.V]) + (k - 1.0) * warmth
        dy[at.P1 + i] = work / foreign.stiffened(volume, pressure, c, e)
    dy[at.SOURCE] = foreign.source_rate(y, total, c, e)


@block
def gas_rates(
    y: np.ndarray, dy: np.ndarray, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> None:
    """Write the rates of pressures, gas masses, lines and spools."""
    if e.size > at.FOREIGN:
        foreign_rates(y, dy, memory, c, e)
        return
    spools = (
        spool_at(y, dy, 0, memory[at.TARGET_1], e),
        spool_at(y, dy, 1, memory[at.TARGET_2], e),
    )
    areas = openings(spools[0], c, e), openings(spools[1], c, e)
    supply = drooped_supply(y, areas[0][0], areas[1][0], c, e)
    if e[at.TANK_FALL] > 0.0:
        dy[at.TANK] = tank_rate(y, supply, areas[0][0], areas[1][0], c, e)
    across = orifice(y[at.P1], y[at.P2], past_piston(y[at.X], c, e), c)
    k, rt = c[at.KAPPA], c[at.R] * c[at.T_S]
    for i in range(2):
        pressure, sign, volume = y[at.P1 + i], 1.0 - 2.0 * i, volume_of(y, i, c)
        inward, outward = areas[i]
        net = behind_line(supply, pressure, inward, outward, c, e)
        flow = out_of_line(y, dy, i, net, e) + null_leak(spools[i], pressure, c, e)
        flow -= sign * across + orifice(pressure, c[at.P_ATM], e[at.LEAK_1 + i], c)
        flow -= pores(pressure, e[at.PORES_1 + i], c, e)
        dy[at.M1 + i] = flow
        dy[at.P1 + i] = k / volume * (rt * flow - sign * pressure * c[at.A1 + i] * y[at.V])
        warmth = heated(y, i, pressure, volume, c, e) + stirred(y, dy, i, volume, net, c, e)
        dy[at.P1 + i] += (k - 1.0) / volume * warmth
