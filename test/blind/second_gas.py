"""
Laws of gas, valves and lines of the second list, from the literature that ``second`` names.

Each function is of both lists: where a form is of the first one, it is that of ``foreign_gas``.
"""

import math

import numpy as np

from . import constants as at
from . import foreign_gas as first
from .foreign_gas import CENTRE, iso_flow, wetted_area
from .kept import block, kept

(
    BY_INFLOW, PRESSED_SLIT, ONE_WAY_LIP, NOTCHED_LAND, CRACKING_DROOP, ROUND_PORT, EDDY_CURRENT,
    HUNTING, WARM_COIL, BOUC_WEN, DARCY_LINE, SIDE_VOLUME,
) = range(at.SECOND_CODE + 1, at.SECOND_CODE + 13)  # fmt: skip

REFERENCE_FLOW = 1e-5
"""At which the gas is stirred by 1 [kg/s]."""
INFLOW_POWER = 0.67
LAND_CRITICAL = 0.3
"""Critical ratio of pressures of a notch [-]."""
VISCOSITY = 1.82e-5
"""Of air [Pa s]."""
BLASIUS = 0.3164


@block
def heat(
    y: np.ndarray,
    dy: np.ndarray,
    chamber: int,
    volume: float,
    flow: float,
    c: np.ndarray,
    e: np.ndarray,
) -> float:
    """
    Heat that flows into a chamber's gas [W] while a mass flow [kg/s] comes in.

    By a jet, Nu grows as Re^0.67 of the inflow (Woodfield, Monde and Mitsutake 2007); here the
    motion of the gas decays after it.
    """
    code, strength = e[at.AT_HEAT], e[at.AT_HEAT + 1]
    if code != BY_INFLOW:
        return first.heat(y, dy, chamber, volume, c, e)
    stirred = y[at.STIRRED_1 + chamber]
    fed = max(flow, 0.0) / REFERENCE_FLOW
    dy[at.STIRRED_1 + chamber] = (fed - stirred) / e[at.AT_HEAT + 2]
    gas = y[at.P1 + chamber] * volume / (y[at.M1 + chamber] * c[at.R])
    surface = wetted_area(volume, c[at.A1 + chamber])
    return strength * surface * max(stirred, 0.0) ** INFLOW_POWER * (c[at.T_S] - gas)


@block
def leak(y: np.ndarray, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """
    Flow [kg/s] to the outside of a chamber at a pressure [Pa].

    A slit in a lip that the pressure presses shut: its height falls as 1 / (1 + p / p_0), and a
    laminar flow as the cube of that (Mueller and Nau 1998).
    """
    if e[at.AT_LEAK] != PRESSED_SLIT:
        return first.leak(y, pressure, c, e)
    outside = c[at.P_ATM]
    height = 1.0 / (1.0 + max(pressure - outside, 0.0) / e[at.AT_LEAK + 2])
    return e[at.AT_LEAK + 1] * (pressure**2 - outside**2) * height**3


@block
def cross_leak(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Flow [kg/s] from chamber 1 past the piston into chamber 2; a lip seals one way alone."""
    if e[at.AT_CROSS] != ONE_WAY_LIP:
        return first.cross_leak(y, c, e)
    return e[at.AT_CROSS + 1] * max(y[at.P1] ** 2 - y[at.P2] ** 2, 0.0)


@block
def null_flow(supply: float, spool: float, pressure: float, c: np.ndarray, e: np.ndarray) -> float:
    """
    Flow [kg/s] past the lands of a spool.

    A V-shaped notch in the land leaves an area that grows with the square of its open length
    (Borghi, Milani and Paoluzzi 2005).
    """
    if e[at.AT_NULL] != NOTCHED_LAND:
        return first.null_flow(supply, spool, pressure, c, e)
    half, reach = max(0.5 * (c[at.U_M] - c[at.U_N]), 1e-3), e[at.AT_NULL + 2]
    intake = max(1.0 - max(c[at.U_M] - spool, 0.0) / half / reach, 0.0) ** 2
    exhaust = e[at.AT_NULL + 3] * max(1.0 - max(spool - c[at.U_N], 0.0) / half / reach, 0.0) ** 2
    into = intake * iso_flow(supply, pressure, LAND_CRITICAL, c)
    out = exhaust * iso_flow(pressure, c[at.P_ATM], LAND_CRITICAL, c)
    return e[at.AT_NULL + 1] * (into - out)


@block
def source(y: np.ndarray, c: np.ndarray, e: np.ndarray) -> float:
    """Supply pressure [Pa] before anything resists."""
    return c[at.P_S] if e[at.AT_SUPPLY] == CRACKING_DROOP else first.source(y, c, e)


@block
def droops(e: np.ndarray) -> bool:
    """Whether the supply has a law of its own for how it droops."""
    code = e[at.AT_SUPPLY]
    return (code == first.QUADRATIC_DROP or code == CRACKING_DROOP) and e[at.AT_SUPPLY + 1] > 0.0


@block
def droop(flow: float, e: np.ndarray) -> float:
    """
    Pressure [Pa] that the supply lacks while a flow [kg/s] is drawn.

    Quadratic; or that of a regulator whose poppet cracks open: steep at first, then flat
    (characteristic curves of ISO 6953).
    """
    if e[at.AT_SUPPLY] == CRACKING_DROOP:
        return e[at.AT_SUPPLY + 1] * flow / (flow + e[at.AT_SUPPLY + 2])
    return e[at.AT_SUPPLY + 1] * flow**2


@block
def segment(share: float) -> float:
    """Share of a circle [-] that a straight edge has uncovered, by share of its diameter."""
    x = max(0.0, min(share, 1.0))
    return (math.acos(1.0 - 2.0 * x) - 2.0 * (1.0 - 2.0 * x) * math.sqrt(x * (1.0 - x))) / math.pi


@block
def bent(share: float, intake: bool, e: np.ndarray) -> float:
    """Opening [-] at a share [-] of the spool's travel; of round ports (Merritt 1967)."""
    if e[at.AT_CURVE] != ROUND_PORT:
        return first.bent(share, intake, e)
    s = e[at.AT_CURVE + 1]
    return (1.0 - s) * share + s * segment(share)


@block
def spool_of(y: np.ndarray, dy: np.ndarray, place: int, target: float, e: np.ndarray) -> float:
    """
    Return where a spool is [V]; ``place`` 0 or 1.

    Eddy currents in a solid core delay a part of the force (Roters 1941); a spool servo hunts in a
    limit cycle (Gelb and Vander Velde 1968); the copper of the coil warms up by u^2 and the
    current falls, its heat being 1 at 1 V (IEC 60028).
    """
    code, s, number = e[at.AT_SPOOL], e[at.AT_SPOOL + 1], e[at.AT_SPOOL + 2]
    if s == 0.0:
        return target
    if code == EDDY_CURRENT:
        slow = y[at.SPOOL_1 + place]
        dy[at.SPOOL_1 + place] = (target - slow) / number
        return target - s * (target - slow)
    if code == HUNTING:
        return target + s * math.sin(2.0 * math.pi * number * y[at.CLOCK])
    if code == WARM_COIL:
        warm = y[at.COIL_1 + place]
        dy[at.COIL_1 + place] = ((target - CENTRE) ** 2 - warm) / number
        return target - s * warm * (target - CENTRE)
    return first.spool_of(y, dy, place, target, e)


@block
def darcy_flow(squares: float, bore: float, length: float, c: np.ndarray) -> float:
    """
    Isothermal mass flow [kg/s] through a smooth tube, by p_1^2 - p_2^2 [Pa^2]; signed.

    Darcy and Weisbach, with 64 / Re (Hagen and Poiseuille) or 0.3164 Re^-1/4 (Blasius 1913),
    whichever resists more.
    """
    rt, area = c[at.R] * c[at.T_S], 0.25 * math.pi * bore**2
    laminar = math.pi * bore**4 / (256.0 * VISCOSITY * length * rt) * abs(squares)
    scale = BLASIUS * (0.25 * math.pi * bore * VISCOSITY) ** 0.25 * length / bore * rt / area**2
    turbulent = (abs(squares) / scale) ** (4.0 / 7.0)
    return math.copysign(min(laminar, turbulent), squares)


@block
def through_line(
    y: np.ndarray, dy: np.ndarray, chamber: int, flow: float, c: np.ndarray, e: np.ndarray
) -> float:
    """Return the flow [kg/s] at the end of a line that takes a flow in at its beginning."""
    length, bore = e[at.AT_LINE + 1], e[at.AT_LINE + 2]
    if e[at.AT_LINE] != DARCY_LINE or length == 0.0:
        return first.through_line(y, dy, chamber, flow, c, e)
    pipe, pressure = y[at.PIPE_1 + chamber], y[at.P1 + chamber]
    out = darcy_flow(pipe**2 - pressure**2, bore, length, c)
    volume = 0.25 * math.pi * bore**2 * length
    dy[at.PIPE_1 + chamber] = c[at.KAPPA] * c[at.R] * c[at.T_S] / volume * (flow - out)
    return out


@block
def at_valve(y: np.ndarray, chamber: int, e: np.ndarray) -> float:
    """Return the pressure that a valve works against [Pa]."""
    if e[at.AT_LINE] == DARCY_LINE and e[at.AT_LINE + 1] > 0.0:
        return y[at.PIPE_1 + chamber]
    return first.at_valve(y, chamber, e)


@block
def side_flow(y: np.ndarray, dy: np.ndarray, chamber: int, c: np.ndarray, e: np.ndarray) -> float:
    """
    Flow [kg/s] from a chamber into a volume beside it, a blind bore or the tube of a gauge.

    It follows with a time constant, at the temperature of the supply (Andersen 1967).
    """
    if e[at.AT_GAS] != SIDE_VOLUME:
        return 0.0
    rate = (y[at.P1 + chamber] - y[at.SIDE_1 + chamber]) / e[at.AT_GAS + 2]
    dy[at.SIDE_1 + chamber] = rate
    return e[at.AT_GAS + 1] * rate / (c[at.R] * c[at.T_S])


@block
def loaded(loop: float, step: float) -> float:
    """
    Return the state of a Bouc-Wen loop [-] after a step of its travel [-].

    dh/du = 1 - h^2 where it is loaded, 1 where it is unloaded (Wen 1976 with n = 2, beta = gamma).
    """
    if loop * step < 0.0:
        rest = abs(step) - abs(loop)
        if rest <= 0.0:
            return loop + step
        return math.copysign(math.tanh(rest), step)
    now = min(abs(loop), 1.0 - 1e-12)
    return math.copysign(math.tanh(math.atanh(now) + abs(step)), step)


@kept
def looped(voltages: np.ndarray, strength: float, travel: float) -> np.ndarray:
    """Return voltages less a Bouc-Wen loop, from shut valves on."""
    found = np.empty_like(voltages)
    for side in range(voltages.shape[1]):
        loop, before = 0.0, CENTRE
        for k in range(len(voltages)):
            wanted = voltages[k, side]
            if wanted != before:
                loop, before = loaded(loop, (wanted - before) / travel), wanted
            found[k, side] = wanted - strength * loop
    return found


def targets(voltages: np.ndarray, interval: float, e: np.ndarray) -> np.ndarray:
    """Return where the voltages draw the spools to [V], shape (n, 2)."""
    code, strength, travel = e[at.AT_PLAY : at.AT_PLAY + 3]
    if code == BOUC_WEN and strength != 0.0:
        return looped(voltages, strength, travel)
    return first.targets(voltages, interval, e)
