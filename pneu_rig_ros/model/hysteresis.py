"""
F(z) of Eq. 9: presliding hysteresis with nonlocal memory, as parallel Maxwell-slip elements.

Each element is a spring in series with a Coulomb slider; the last one has no slider, so that
F(z) can always reach the sliding level. One element alone is a linear spring, F(z) = sigma_0 z.
Reference: F. Al-Bender, V. Lampaert, J. Swevers, IEEE Trans. Autom. Control 50 (2005) 1883.
"""

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.parameters import Friction


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
