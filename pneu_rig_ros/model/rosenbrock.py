"""
One step of a linearly implicit Runge-Kutta (Rosenbrock-W) method, ROS34PW2, order 3(2).

Being a W-method it keeps its order with any approximation of the Jacobian; here that is the
arrow of (v; z, p1, p2), the stiff part, whose linear systems are solved in closed form.
Reference: J. Rang, L. Angermann, BIT Numerical Mathematics 45 (2005) 761.
"""

from collections.abc import Callable

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.dynamics import RightHandSide

ORDER = 3
"""Declared order of the method."""

_DIAGONAL = 4.3586652150845900e-01
_ALPHA = np.zeros((4, 4))
_ALPHA[1, 0] = 8.7173304301691801e-01
_ALPHA[2, :2] = 8.4457060015369423e-01, -1.1299064236484185e-01
_ALPHA[3, 2] = 1.0
_GAMMA = np.diag([_DIAGONAL] * 4)
_GAMMA[1, 0] = -8.7173304301691801e-01
_GAMMA[2, :2] = -9.0338057013044082e-01, 5.4180672388095326e-02
_GAMMA[3, :3] = 2.4212380706095346e-01, -1.2232505839045147e00, 5.4526025533510214e-01
_WEIGHTS = np.array(
    [2.4212380706095346e-01, -1.2232505839045147e00, 1.5452602553351020e00, _DIAGONAL]
)
_EMBEDDED = np.array(
    [3.7810903145819369e-01, -9.6042292212423178e-02, 0.5, 2.1793326075422950e-01]
)

# In the variables u = Gamma k no product with the Jacobian is needed (Hairer, Wanner, Solving
# Ordinary Differential Equations II, 1996, IV.7): stage s is evaluated at y0 + sum A[s, j] u[j],
# and its linear system has the right-hand side f + sum C[s, j] u[j] / h. Row 4 is the result.
_INVERSE = np.linalg.inv(_GAMMA)
_A = np.vstack([np.tril(_ALPHA @ _INVERSE, -1), _WEIGHTS @ _INVERSE])
_C = np.tril(np.diag(1.0 / np.diag(_GAMMA)) - _INVERSE, -1)
_E = (_WEIGHTS - _EMBEDDED) @ _INVERSE
_TIMES = np.append(_ALPHA.sum(axis=1), 1.0)


@compiled
def solve(diagonal: float, arrow: Floats, right: Floats) -> None:
    """
    Solve (diagonal I - J) u = right in place for the arrow-shaped J.

    :param diagonal: 1 / (h gamma) [1/s]
    :param arrow: Jacobian entries, shape (ARROW_SIZE,)
    :param right: right-hand side, shape (n,), becomes u
    """
    z = 1.0 / (diagonal - arrow[at.Z_Z])
    p1 = 1.0 / (diagonal - arrow[at.P1_P1])
    p2 = 1.0 / (diagonal - arrow[at.P2_P2])
    feed_z, feed_1, feed_2 = arrow[at.V_Z] * z, arrow[at.V_P1] * p1, arrow[at.V_P2] * p2
    pivot = diagonal - arrow[at.V_V]
    pivot -= feed_z * arrow[at.Z_V] + feed_1 * arrow[at.P1_V] + feed_2 * arrow[at.P2_V]
    right_z, right_1, right_2 = right[at.DEFLECTION], right[at.PRESSURE_1], right[at.PRESSURE_2]
    v = right[at.VELOCITY] + feed_z * right_z + feed_1 * right_1 + feed_2 * right_2
    v /= pivot
    inverse = 1.0 / diagonal
    for i in range(len(right)):
        right[i] *= inverse
    right[at.VELOCITY] = v
    right[at.DEFLECTION] = (right_z + arrow[at.Z_V] * v) * z
    right[at.PRESSURE_1] = (right_1 + arrow[at.P1_V] * v) * p1
    right[at.PRESSURE_2] = (right_2 + arrow[at.P2_V] * v) * p2


def build_step(right_hand_side: RightHandSide) -> Callable[..., None]:
    """
    Return the compiled step for a right-hand side.

    ``step(t, h, carry, model)`` writes state, rate and Jacobian at t + h into ``carry.end`` and
    the local error estimate into ``carry.work[4]``; ``carry.work[:4]`` is scratch.
    """

    @inner
    def step(t: float, h: float, carry: at.IntegratorState, model: CompiledModel) -> None:
        y0, f0, arrow, u = carry.y0, carry.f0, carry.arrow_0, carry.work
        y1, f1 = carry.end.state, carry.end.rate
        u1, u2, u3, u4, error = u[0], u[1], u[2], u[3], u[4]
        diagonal, per_h = 1.0 / (h * _DIAGONAL), 1.0 / h
        for i in range(len(y0)):
            u1[i] = f0[i]
            u2[i] = u3[i] = u4[i] = 0.0  # what is not yet known counts with a coefficient of zero
        solve(diagonal, arrow, u1)
        # A loop with a single call, as the whole plant is inlined there: four times the code would
        # take much longer to compile.
        for stage in range(1, 5):
            a1, a2, a3, a4 = _A[stage, 0], _A[stage, 1], _A[stage, 2], _A[stage, 3]
            for i in range(len(y0)):
                y1[i] = y0[i] + a1 * u1[i] + a2 * u2[i] + a3 * u3[i] + a4 * u4[i]
            right_hand_side(t + _TIMES[stage] * h, carry.end, model)
            if stage < 4:
                # 1/h is a factor of the sum, but at first of the coefficient: the order decides
                # the last digit, and with it recorded trajectories
                inside, outside = (per_h, 1.0) if stage == 1 else (1.0, per_h)
                c1, c2, c3 = inside * _C[stage, 0], _C[stage, 1], _C[stage, 2]
                for i in range(len(y0)):
                    u[stage, i] = f1[i] + outside * (c1 * u1[i] + c2 * u2[i] + c3 * u3[i])
                solve(diagonal, arrow, u[stage])
        for i in range(len(y0)):
            error[i] = _E[0] * u1[i] + _E[1] * u2[i] + _E[2] * u3[i] + _E[3] * u4[i]

    return step
