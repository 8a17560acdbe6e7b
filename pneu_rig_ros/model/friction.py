"""
Seal friction: revised LuGre (Eq. 9-15) with dwell-time-dependent static friction (Eq. 16).

The simpler laws are the same equations without some terms: ``coulomb_viscous`` has a constant
level F_c, ``lugre`` adds the Stribeck curve, ``revised_lugre`` the lubricant film and the fluid
time constant, ``revised_lugre_dwell`` Eq. 16. Sticking is resolved by the bristle in all four.

F(z) of Eq. 9 is a presliding hysteresis with nonlocal memory, of parallel Maxwell-slip elements.
Each element is a spring in series with a Coulomb slider; the last one has no slider, so that F(z)
can always reach the sliding level. One element alone is a linear spring, F(z) = sigma_0 z.
Reference: F. Al-Bender, V. Lampaert, J. Swevers, IEEE Trans. Autom. Control 50 (2005) 1883.
"""

import math

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import Signals
from pneu_rig_ros.model.parameters import (
    COULOMB_VISCOUS,
    FILM_PRINTED,
    FILM_RESTS_BY_SPEED,
    REVISED_LUGRE,
    REVISED_LUGRE_DWELL,
    Friction,
)


@compiled
def friction_force(
    bristle_force: float,
    bristle_rate: float,
    velocity: float,
    acceleration: float,
    friction: Friction,
) -> float:
    """
    Return the friction force F_r [N] against the motion (Eq. 9).

    :param bristle_force: F(z) [N]
    :param bristle_rate: dz/dt [m/s]
    :param velocity: v [m/s]
    :param acceleration: dv/dt [m/s^2]
    """
    fluid = velocity + fluid_time(friction) * acceleration
    bristles = bristle_force + friction.micro_viscous_coefficient * bristle_rate
    return bristles + friction.viscous_coefficient * fluid


@compiled
def fluid_time(friction: Friction) -> float:
    """Return the fluid time constant T [s] of Eq. 9, zero for the laws without a film."""
    return friction.fluid_time_constant if friction.model >= REVISED_LUGRE else 0.0


@compiled
def bristle_deflection_rate(velocity: float, bristle_force: float, level: float) -> float:
    """
    Return the bristle deflection rate dz/dt [m/s] (Eq. 10).

    |v| in place of v, so that it holds in both directions::

        dz/dt = v - |v| F(z) / g(v, h)

    :param velocity: v [m/s], positive on the outstroke
    :param bristle_force: F(z) [N]
    :param level: g(v, h) [N], > 0
    """
    return velocity - abs(velocity) * bristle_force / level


@compiled
def friction_direction(signals: Signals, friction: Friction) -> float:
    """
    Return the side to which friction is directed, 1 on the outstroke and -1 on the instroke [-].

    At rest it is that in which the bristles are bent; it turns within half of F_c, so that what
    depends on it has no jump.
    """
    if signals.seal.sticking:
        return min(max(2.0 * signals.seal.bristle_force / friction.coulomb_force, -1.0), 1.0)
    return 1.0 if signals.motion.velocity > 0.0 else -1.0


@compiled
def stribeck_power(velocity: float, friction: Friction) -> float:
    """Return |v / v_s|^n [-] of Eq. 11, with |v| so that it holds in both directions."""
    ratio = abs(velocity) / friction.stribeck_velocity
    if friction.stribeck_exponent == 2.5:  # Table 2; a square root is cheaper than a power
        return ratio * ratio * math.sqrt(ratio)
    return math.pow(ratio, friction.stribeck_exponent)


@compiled
def static_level(
    film: float, static_force: float, coulomb_force: float, friction: Friction
) -> float:
    """
    Return the level [N] that g(v, h) of Eq. 11 takes at v = 0.

    ``(1 - h) F_s`` as printed, or with the film as a share eta of its largest thickness,
    ``F_c + (F_s - F_c)(1 - eta)``, which stays above F_c when F_s varies.

    :param film: film thickness h, or its share eta [-]
    :param static_force: F_s [N]
    :param coulomb_force: F_c [N]
    """
    if friction.model == COULOMB_VISCOUS:
        return coulomb_force
    if friction.model < REVISED_LUGRE:
        return static_force
    if friction.film_reading == FILM_PRINTED:
        return (1.0 - film) * static_force
    return coulomb_force + (static_force - coulomb_force) * (1.0 - film)


@compiled
def sliding_level(power: float, level_at_rest: float, coulomb_force: float) -> float:
    """
    Return the Stribeck function g(v, h) [N] (Eq. 11).

    :param power: |v / v_s|^n [-], see :func:`stribeck_power`
    :param level_at_rest: g(0, h) [N], see :func:`static_level`
    :param coulomb_force: F_c [N]
    """
    return coulomb_force + (level_at_rest - coulomb_force) * math.exp(-power)


@compiled
def film_steady_state(
    velocity: float, static_force: float, coulomb_force: float, friction: Friction
) -> float:
    """
    Return the steady film thickness h_ss [-] (Eq. 14 and 15), or its share of the largest.

    :param velocity: v [m/s]
    :param static_force: F_s [N]
    :param coulomb_force: F_c [N]
    """
    ratio = min(abs(velocity) / friction.film_velocity, 1.0)
    share = np.cbrt(ratio * ratio)
    if friction.film_reading == FILM_PRINTED:
        share *= max(1.0 - coulomb_force / static_force, 0.0)
    return float(share)


@compiled
def film_rate(film: float, steady: float, resting: bool, friction: Friction) -> float:
    """
    Return dh/dt [1/s] (Eq. 12), with the time constant tau_h [s] of Eq. 13.

    :param film: h [-]
    :param steady: h_ss [-]
    :param resting: whether v counts as zero in Eq. 13, see ``film_rests``
    """
    if resting:
        time = friction.film_time_dwell
    elif film <= steady:
        time = friction.film_time_acceleration
    else:
        time = friction.film_time_deceleration
    return (steady - film) / time


@compiled
def film_rests(velocity: float, sticking: bool, friction: Friction) -> bool:
    """
    Return whether v counts as zero in Eq. 13.

    While the dwell clock of Eq. 16 runs, or whenever the piston is slower than a threshold.

    :param velocity: v [m/s]
    :param sticking: whether the dwell clock runs
    """
    if friction.film_rest_reading == FILM_RESTS_BY_SPEED:
        return abs(velocity) < friction.film_rest_velocity
    return sticking


@compiled
def static_friction(
    dwell_time: float, breakaway_force: float, coulomb_force: float, friction: Friction
) -> float:
    """
    Return the static friction force F_s [N] after a dwell time (Eq. 16).

    :param dwell_time: t_D >= 0 [s]
    :param breakaway_force: F_smax [N]
    :param coulomb_force: F_c [N]
    """
    if friction.model != REVISED_LUGRE_DWELL:
        return breakaway_force
    return grown_static_friction(
        dwell_time,
        breakaway_force,
        coulomb_force,
        friction.dwell_coefficient,
        friction.dwell_exponent,
    )


@compiled
def faded_dwell(dwell_time: float, sliding_time: float, friction: Friction) -> float:
    """
    Return the dwell [s] after which Eq. 16 gives what sliding has left of F_s - F_c.

    Sliding lets F_s - F_c decay with the memory time tau::

        1 - exp(-gamma t'^alpha) = (1 - exp(-gamma t^alpha)) exp(-s / tau)

    :param dwell_time: t >= 0, at breakaway [s]
    :param sliding_time: s, since breakaway [s]; negative for a time before it
    """
    if sliding_time <= 0.0:
        return max(dwell_time + sliding_time, 0.0)
    gamma, alpha = friction.dwell_coefficient, friction.dwell_exponent
    grown = -math.expm1(-gamma * math.pow(dwell_time, alpha))
    left = grown * math.exp(-sliding_time / friction.memory_time)
    if left <= 0.0:
        return 0.0
    if left >= 1.0:  # saturated to all digits, whatever the dwell
        return dwell_time
    return math.pow(-math.log1p(-left) / gamma, 1.0 / alpha)


@compiled
def grown_static_friction(
    dwell_time: float, breakaway: float, coulomb: float, coefficient: float, exponent: float
) -> float:
    """
    Return Eq. 16 [N] with F_smax, F_c [N], gamma [s^-alpha] and alpha [-] given.

    :param dwell_time: t_D >= 0 [s]
    """
    growth = coefficient * math.pow(dwell_time, exponent)
    return breakaway - (breakaway - coulomb) * math.exp(-growth)


@compiled
def element_force(
    deflection: float, anchor: float, index: int, friction: Friction
) -> tuple[float, float]:
    """
    Return force [N] and tangent stiffness [N/m] of one element.

    :param deflection: z [m]
    :param anchor: z [m] at which the element is relaxed
    :param index: number of the element
    """
    stiffness = friction.element_stiffness[index]
    force = stiffness * (deflection - anchor)
    if index < len(friction.element_limit):
        limit = friction.element_limit[index]
        if abs(force) > limit:
            return np.copysign(limit, force), 0.0
    return force, stiffness


@compiled
def bristle_force(deflection: float, anchors: Floats, friction: Friction) -> tuple[float, float]:
    """
    Return F(z) [N] and its tangent stiffness [N/m], valid until z reverses.

    :param deflection: mean bristle deflection z [m]
    :param anchors: relaxed positions of the elements [m], shape (n,)
    """
    total, tangent = 0.0, 0.0
    for index in range(len(friction.element_stiffness)):
        force, stiffness = element_force(deflection, anchors[index], index, friction)
        total += force
        tangent += stiffness
    return total, tangent


@compiled
def drag_anchors(deflection: float, anchors: Floats, friction: Friction) -> None:
    """
    Let the elements that slip drag their anchors along, in place: the memory of F(z).

    :param deflection: z [m], the extreme reached before a reversal
    :param anchors: relaxed positions [m], shape (n,); changed
    """
    for index in range(len(friction.element_limit)):
        reach = friction.element_limit[index] / friction.element_stiffness[index]
        low, high = deflection - reach, deflection + reach
        anchors[index] = min(max(anchors[index], low), high)
