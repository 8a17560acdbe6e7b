"""
The gas of the second plant: Eq. 3-7, written anew, with what can be hidden in it.

``c`` are the constants, ``e`` what is hidden, ``y`` the state, see ``constants``.
"""

import math

import numba
import numpy as np

from . import foreign_gas as foreign
from . import second_gas as second
from .constants import (
    A1,
    A2,
    AT_LEAK,
    CONVECTION_1,
    CONVECTION_2,
    CONVECTION_POWER,
    CROSS,
    DROOP,
    FORCED,
    FORCED_POWER,
    FOREIGN,
    HEAT_1,
    HEAT_2,
    K_V1,
    K_V2,
    KAPPA,
    LAG_TIME,
    LAMINAR,
    LEAK_1,
    LEAK_2,
    LINE_1,
    LINE_2,
    LINE_DROP,
    LINE_TIME,
    M1,
    M2,
    NULL_IN,
    NULL_OUT,
    OPENING_IN,
    OPENING_OUT,
    P1,
    P2,
    P_ATM,
    P_S,
    PORES_1,
    PORES_2,
    PORES_POWER,
    SOURCE,
    SPOOL_1,
    SPOOL_2,
    STROKE,
    T_S,
    TANK,
    TANK_FALL,
    TANK_TIME,
    TARGET_1,
    TARGET_2,
    U_0,
    U_M,
    U_N,
    V10,
    V20,
    VOLT_TIME,
    WORN,
    WORN_PLACE,
    WORN_WIDTH,
    R,
    V,
    X,
)

FULL_VOLTAGE = 5.0


@numba.njit
def orifice(upstream: float, downstream: float, area: float, c: np.ndarray) -> float:
    """Mass flow [kg/s] of Eq. 3-5 through an area [m^2]; negative if downstream is higher."""
    if downstream > upstream:
        return -orifice(downstream, upstream, area, c)
    k = c[KAPPA]
    ratio = downstream / upstream
    if ratio < (2.0 / (k + 1.0)) ** (k / (k - 1.0)):
        psi = (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    else:
        r = min(ratio, c[LAMINAR])
        psi = math.sqrt(2.0 / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))
        if ratio > c[LAMINAR]:
            psi *= (1.0 - ratio) / (1.0 - c[LAMINAR])
    return psi * upstream * math.sqrt(k / (c[R] * c[T_S])) * area


@numba.njit
def openings(spool: float, c: np.ndarray, e: np.ndarray) -> tuple[float, float]:
    """
    Areas [m^2] of intake and exhaust with the spool at a voltage; full opening unbent.

    The exhaust has a hole of its own from its edge on, if its opening is counted from before it.
    """
    if e.size > FOREIGN and not c[U_N] <= spool <= c[U_M]:
        return bent_openings(spool, c, e)
    if spool > c[U_M]:
        full = FULL_VOLTAGE - c[U_M]
        return c[K_V1] * full * ((spool - c[U_M]) / full) ** e[OPENING_IN], 0.0
    if spool < c[U_N]:
        bent = c[U_N] * (1.0 - spool / c[U_N]) ** e[OPENING_OUT]
        return 0.0, c[K_V2] * (c[U_0] - c[U_N] + bent)
    return 0.0, 0.0


@numba.njit
def bent_openings(spool: float, c: np.ndarray, e: np.ndarray) -> tuple[float, float]:
    """Areas [m^2] under a foreign curve, an orifice of the line behind them."""
    if spool > c[U_M]:
        full = FULL_VOLTAGE - c[U_M]
        share = second.bent((spool - c[U_M]) / full, True, e)
        return foreign.narrowed(c[K_V1] * full * share ** e[OPENING_IN], e), 0.0
    share = second.bent(1.0 - spool / c[U_N], False, e)
    area = c[K_V2] * (c[U_0] - c[U_N] + c[U_N] * share ** e[OPENING_OUT])
    return 0.0, foreign.narrowed(area, e)


@numba.njit
def drawn(supply: float, y: np.ndarray, in_1: float, in_2: float, c: np.ndarray) -> float:
    """Flow [kg/s] out of the supply line at a pressure [Pa]; back flow does not raise it."""
    flow_1, flow_2 = orifice(supply, y[P1], in_1, c), orifice(supply, y[P2], in_2, c)
    return max(flow_1, 0.0) + max(flow_2, 0.0)


@numba.njit
def lawful_droop(
    before: float, y: np.ndarray, in_1: float, in_2: float, c: np.ndarray, e: np.ndarray
) -> float:
    """Supply pressure [Pa] behind a resistance with a law of its own, by bisection."""
    low, high = 0.0, before - c[P_ATM]
    for _ in range(60):
        droop = 0.5 * (low + high)
        if second.droop(drawn(before - droop, y, in_1, in_2, c), e) > droop:
            low = droop
        else:
            high = droop
    return before - 0.5 * (low + high)


@numba.njit
def drooped_supply(y: np.ndarray, in_1: float, in_2: float, c: np.ndarray, e: np.ndarray) -> float:
    """Supply pressure [Pa] behind a resistance, found by bisection."""
    before = c[P_S] - y[TANK]
    if e.size > FOREIGN:
        before = second.source(y, c, e) - y[TANK]
        if second.droops(e):
            return lawful_droop(before, y, in_1, in_2, c, e)
    if e[DROOP] == 0.0 or in_1 + in_2 == 0.0:
        return before
    low, high = 0.0, min(e[DROOP] * drawn(before, y, in_1, in_2, c), before)
    for _ in range(60):
        droop = 0.5 * (low + high)
        if e[DROOP] * drawn(before - droop, y, in_1, in_2, c) > droop:
            low = droop
        else:
            high = droop
        if high - low < 1e-7:
            break
    return before - 0.5 * (low + high)


@numba.njit
def behind_line(
    supply: float, pressure: float, inward: float, outward: float, c: np.ndarray, e: np.ndarray
) -> float:
    """
    Flow [kg/s] into a chamber through a valve's areas [m^2] and a line, by bisection.

    The line is a tube with turbulent, isothermal flow: p_v^2 - p^2 = (R m') |R m'|.
    """
    flow = orifice(supply, pressure, inward, c) - orifice(pressure, c[P_ATM], outward, c)
    if e[LINE_DROP] == 0.0 or flow == 0.0:
        return flow
    low, high = 0.0, 1.0
    for _ in range(60):
        share = 0.5 * (low + high)
        drop = e[LINE_DROP] * share * flow
        valve = math.sqrt(max(pressure**2 + drop * abs(drop), (0.01 * pressure) ** 2))
        passed = orifice(supply, valve, inward, c) - orifice(valve, c[P_ATM], outward, c)
        if passed / flow > share:
            low = share
        else:
            high = share
    return 0.5 * (low + high) * flow


@numba.njit
def limited_rate(spool: float, target: float, e: np.ndarray) -> float:
    """Speed [V/s] of a spool that moves 1 V in a time at least; near its place a lag of 1 ms."""
    limit = 1.0 / e[VOLT_TIME]
    return max(-limit, min((target - spool) / 1e-3, limit))


@numba.njit
def null_leak(spool: float, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] past the lands: a gap's resistance grows with its length."""
    half = max(0.5 * (c[U_M] - c[U_N]), 1e-3)
    intake = e[NULL_IN] / (1.0 + max(c[U_M] - spool, 0.0) / half)
    exhaust = e[NULL_OUT] / (1.0 + max(spool - c[U_N], 0.0) / half)
    into = orifice(c[P_S], pressure, intake, c)
    return into - orifice(pressure, c[P_ATM], exhaust, c)


@numba.njit
def past_piston(place: float, c: np.ndarray, e: np.ndarray) -> float:
    """Area [m^2] of the leak past the piston, with that of a worn part of the bore."""
    if e[WORN] == 0.0:
        return e[CROSS]
    away = (place - e[WORN_PLACE] * c[STROKE]) / (e[WORN_WIDTH] * c[STROKE])
    return e[CROSS] + e[WORN] / math.exp(away * away)


@numba.njit
def pores(pressure: float, flow: float, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] out through pores, a power of the bars above atmosphere; straight near 0."""
    bars = 1e-5 * (pressure - c[P_ATM])
    if abs(bars) < 1e-3:
        return flow * 1e-3 ** e[PORES_POWER] * bars / 1e-3
    return math.copysign(flow * abs(bars) ** e[PORES_POWER], bars)


@numba.njit
def convected(gas: float, conductance: float, c: np.ndarray, e: np.ndarray) -> float:
    """Heat [W] that a rising or falling layer of gas at a temperature [K] takes from the wall."""
    tens = 0.1 * (c[T_S] - gas)
    return math.copysign(10.0 * conductance * abs(tens) ** (1.0 + e[CONVECTION_POWER]), tens)


@numba.njit
def forced(pressure: float, volume: float, area: float, e: np.ndarray) -> float:
    """Conductance [W/K] of the wall of a chamber to gas that is stirred, by its pressure."""
    wall = 2.0 * area + 4.0 * volume / math.sqrt(4.0 * area / math.pi)
    return e[FORCED] * wall * (pressure / 3e5) ** e[FORCED_POWER]


@numba.njit
def tank_rate(
    y: np.ndarray, supply: float, in_1: float, in_2: float, c: np.ndarray, e: np.ndarray
) -> float:
    """Rate of what the tank lacks [Pa/s]."""
    return e[TANK_FALL] * drawn(supply, y, in_1, in_2, c) - y[TANK] / e[TANK_TIME]


@numba.njit
def foreign_rates(
    y: np.ndarray, dy: np.ndarray, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> None:
    """Write the rates of pressures, gas masses, lines, spools, walls and supply; forms foreign."""
    outside, k, rt = c[P_ATM], c[KAPPA], c[R] * c[T_S] * foreign.heaviness(y, e)
    ends = second.at_valve(y, 0, e), second.at_valve(y, 1, e)
    spools, inward, outward = np.empty(2), np.empty(2), np.empty(2)
    for i in range(2):
        spools[i] = second.spool_of(y, dy, i, memory[TARGET_1 + i], e)
        if e[LAG_TIME] > 0.0:
            dy[SPOOL_1 + i] = (spools[i] - y[SPOOL_1 + i]) / e[LAG_TIME]
            spools[i] = y[SPOOL_1 + i]
        if e[VOLT_TIME] > 0.0:
            dy[SPOOL_1 + i] = limited_rate(y[SPOOL_1 + i], spools[i], e)
            spools[i] = y[SPOOL_1 + i]
        inward[i], outward[i] = openings(spools[i], c, e)
    valves = y.copy()  # with the pressures that the valves work against
    valves[P1], valves[P2] = ends
    supply = drooped_supply(valves, inward[0], inward[1], c, e)
    if e[TANK_FALL] > 0.0:
        dy[TANK] = tank_rate(valves, supply, inward[0], inward[1], c, e)
    across = orifice(y[P1], y[P2], past_piston(y[X], c, e), c) + second.cross_leak(y, c, e)
    total = 0.0
    for i in range(2):
        pressure, sign = y[P1 + i], 1.0 - 2.0 * i
        into = orifice(supply, ends[i], inward[i], c) * foreign.discharge(supply, ends[i], e)
        out = orifice(ends[i], outside, outward[i], c) * foreign.discharge(ends[i], outside, e)
        total += max(into, 0.0)
        net = into - out
        if e[LINE_DROP] > 0.0:
            net = behind_line(supply, ends[i], inward[i], outward[i], c, e)
        flow = second.through_line(y, dy, i, net, c, e)
        if e[LINE_TIME] > 0.0:
            dy[LINE_1 + i] = (flow - y[LINE_1 + i]) / e[LINE_TIME]
            flow = y[LINE_1 + i]
        if e[NULL_IN] + e[NULL_OUT] > 0.0:
            flow += null_leak(spools[i], pressure, c, e)
        flow += second.null_flow(c[P_S], spools[i], pressure, c, e)
        share = e[AT_LEAK + 3] if i == 0 else 1.0
        flow -= orifice(pressure, outside, e[LEAK_1 + i], c)
        flow -= pores(pressure, e[PORES_1 + i], c, e)
        flow -= sign * across + share * second.leak(y, pressure, c, e)
        flow -= second.side_flow(y, dy, i, c, e)
        volume = c[V10] + c[A1] * y[X] if i == 0 else c[V20] + c[A2] * (c[STROKE] - y[X])
        warmth = second.heat(y, dy, i, volume, flow, c, e)
        if e[HEAT_1 + i] + e[CONVECTION_1 + i] + e[FORCED] > 0.0:
            gas = pressure * volume / (y[M1 + i] * c[R])
            wall = e[HEAT_1 + i] + forced(pressure, volume, c[A1 + i], e)
            warmth += wall * (c[T_S] - gas) + convected(gas, e[CONVECTION_1 + i], c, e)
        dy[M1 + i] = flow
        work = k * (rt * flow - sign * pressure * c[A1 + i] * y[V]) + (k - 1.0) * warmth
        dy[P1 + i] = work / foreign.stiffened(volume, pressure, c, e)
    dy[SOURCE] = foreign.source_rate(y, total, c, e)


@numba.njit
def gas_rates(
    y: np.ndarray, dy: np.ndarray, memory: np.ndarray, c: np.ndarray, e: np.ndarray
) -> None:
    """Write the rates of pressures, gas masses, lines and spools."""
    if e.size > FOREIGN:
        foreign_rates(y, dy, memory, c, e)
        return
    spool_1, spool_2 = memory[TARGET_1], memory[TARGET_2]
    if e[LAG_TIME] > 0.0:
        dy[SPOOL_1] = (spool_1 - y[SPOOL_1]) / e[LAG_TIME]
        dy[SPOOL_2] = (spool_2 - y[SPOOL_2]) / e[LAG_TIME]
        spool_1, spool_2 = y[SPOOL_1], y[SPOOL_2]
    if e[VOLT_TIME] > 0.0:
        dy[SPOOL_1] = limited_rate(y[SPOOL_1], spool_1, e)
        dy[SPOOL_2] = limited_rate(y[SPOOL_2], spool_2, e)
        spool_1, spool_2 = y[SPOOL_1], y[SPOOL_2]
    in_1, out_1 = openings(spool_1, c, e)
    in_2, out_2 = openings(spool_2, c, e)
    supply = drooped_supply(y, in_1, in_2, c, e)
    if e[TANK_FALL] > 0.0:
        dy[TANK] = tank_rate(y, supply, in_1, in_2, c, e)
    p1, p2, outside = y[P1], y[P2], c[P_ATM]
    flow_1 = behind_line(supply, p1, in_1, out_1, c, e)
    flow_2 = behind_line(supply, p2, in_2, out_2, c, e)
    if e[LINE_TIME] > 0.0:
        dy[LINE_1] = (flow_1 - y[LINE_1]) / e[LINE_TIME]
        dy[LINE_2] = (flow_2 - y[LINE_2]) / e[LINE_TIME]
        flow_1, flow_2 = y[LINE_1], y[LINE_2]
    if e[NULL_IN] + e[NULL_OUT] > 0.0:
        flow_1 += null_leak(spool_1, p1, c, e)
        flow_2 += null_leak(spool_2, p2, c, e)
    across = orifice(p1, p2, past_piston(y[X], c, e), c)
    flow_1 -= across + orifice(p1, outside, e[LEAK_1], c)
    flow_2 += across - orifice(p2, outside, e[LEAK_2], c)
    if e[PORES_1] + e[PORES_2] > 0.0:
        flow_1 -= pores(p1, e[PORES_1], c, e)
        flow_2 -= pores(p2, e[PORES_2], c, e)
    volume_1 = c[V10] + c[A1] * y[X]
    volume_2 = c[V20] + c[A2] * (c[STROKE] - y[X])
    k, rt = c[KAPPA], c[R] * c[T_S]
    dy[M1], dy[M2] = flow_1, flow_2
    dy[P1] = k / volume_1 * (rt * flow_1 - p1 * c[A1] * y[V])
    dy[P2] = k / volume_2 * (rt * flow_2 + p2 * c[A2] * y[V])
    if e[HEAT_1] + e[HEAT_2] + e[CONVECTION_1] + e[CONVECTION_2] + e[FORCED] > 0.0:
        gas_1, gas_2 = p1 * volume_1 / (y[M1] * c[R]), p2 * volume_2 / (y[M2] * c[R])
        wall_1 = e[HEAT_1] + forced(p1, volume_1, c[A1], e)
        wall_2 = e[HEAT_2] + forced(p2, volume_2, c[A2], e)
        heat_1 = wall_1 * (c[T_S] - gas_1) + convected(gas_1, e[CONVECTION_1], c, e)
        heat_2 = wall_2 * (c[T_S] - gas_2) + convected(gas_2, e[CONVECTION_2], c, e)
        dy[P1] += (k - 1.0) / volume_1 * heat_1
        dy[P2] += (k - 1.0) / volume_2 * heat_2
