"""
One step of a linearly implicit Runge-Kutta (Rosenbrock-W) method, ROS34PW2, order 3(2).

Being a W-method it keeps its order with any approximation of the Jacobian; here that is the
arrow of (v; z, p1, p2), the stiff part, whose linear systems are solved in closed form.
Reference: J. Rang, L. Angermann, BIT Numerical Mathematics 45 (2005) 761.
"""

import numpy as np

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.dynamics import (
    DEFLECTION,
    P1_P1,
    P1_V,
    P2_P2,
    P2_V,
    PRESSURE_1,
    PRESSURE_2,
    V_P1,
    V_P2,
    V_V,
    V_Z,
    VELOCITY,
    Z_V,
    Z_Z,
    Array,
    RightHandSide,
)

ORDER = 3
"""Declared order of the method."""

_DIAGONAL = 4.3586652150845900e-01
_ALPHA = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [8.7173304301691801e-01, 0.0, 0.0, 0.0],
        [8.4457060015369423e-01, -1.1299064236484185e-01, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]
)
_GAMMA = np.array(
    [
        [_DIAGONAL, 0.0, 0.0, 0.0],
        [-8.7173304301691801e-01, _DIAGONAL, 0.0, 0.0],
        [-9.0338057013044082e-01, 5.4180672388095326e-02, _DIAGONAL, 0.0],
        [
            2.4212380706095346e-01,
            -1.2232505839045147e00,
            5.4526025533510214e-01,
            _DIAGONAL,
        ],
    ]
)
_WEIGHTS = np.array(
    [
        2.4212380706095346e-01,
        -1.2232505839045147e00,
        1.5452602553351020e00,
        4.3586652150845900e-01,
    ]
)
_EMBEDDED = np.array(
    [
        3.7810903145819369e-01,
        -9.6042292212423178e-02,
        5.0000000000000000e-01,
        2.1793326075422950e-01,
    ]
)

# in the variables u = Gamma k no product with the Jacobian is needed
_INVERSE = np.linalg.inv(_GAMMA)
_A = np.tril(_ALPHA @ _INVERSE, -1)
_C = np.tril(np.diag(1.0 / np.diag(_GAMMA)) - _INVERSE, -1)
_M = _WEIGHTS @ _INVERSE
_E = (_WEIGHTS - _EMBEDDED) @ _INVERSE
_A21, _A31, _A32, _A41, _A42, _A43 = (
    float(_A[i, j]) for i, j in ((1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2))
)
_C21, _C31, _C32, _C41, _C42, _C43 = (
    float(_C[i, j]) for i, j in ((1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2))
)
_M1, _M2, _M3, _M4 = (float(m) for m in _M)
_E1, _E2, _E3, _E4 = (float(e) for e in _E)
_T2, _T3, _T4 = (float(t) for t in _ALPHA.sum(axis=1)[1:])


@compiled
def solve(diagonal: float, arrow: Array, right: Array) -> None:
    """
    Solve (diagonal I - J) u = right in place for the arrow-shaped J.

    :param diagonal: 1 / (h gamma) [1/s]
    :param arrow: Jacobian entries, shape (ARROW_SIZE,)
    :param right: right-hand side, shape (n,), becomes u
    """
    z = 1.0 / (diagonal - arrow[Z_Z])
    p1 = 1.0 / (diagonal - arrow[P1_P1])
    p2 = 1.0 / (diagonal - arrow[P2_P2])
    feed_z, feed_1, feed_2 = arrow[V_Z] * z, arrow[V_P1] * p1, arrow[V_P2] * p2
    pivot = diagonal - arrow[V_V]
    pivot -= feed_z * arrow[Z_V] + feed_1 * arrow[P1_V] + feed_2 * arrow[P2_V]
    right_z, right_1, right_2 = right[DEFLECTION], right[PRESSURE_1], right[PRESSURE_2]
    v = right[VELOCITY] + feed_z * right_z + feed_1 * right_1 + feed_2 * right_2
    v /= pivot
    inverse = 1.0 / diagonal
    for i in range(len(right)):
        right[i] *= inverse
    right[VELOCITY] = v
    right[DEFLECTION] = (right_z + arrow[Z_V] * v) * z
    right[PRESSURE_1] = (right_1 + arrow[P1_V] * v) * p1
    right[PRESSURE_2] = (right_2 + arrow[P2_V] * v) * p2


def build_step(right_hand_side: RightHandSide) -> RightHandSide:
    """
    Return the compiled step for a right-hand side.

    ``step(t, h, y0, f0, arrow, y1, f1, arrow_1, error, work, memory, voltages, model, effects)``
    writes state, rate and Jacobian at t + h into ``y1``, ``f1`` and ``arrow_1`` and the local
    error estimate into ``error``; ``work`` has shape (6, n).
    """
    rhs = right_hand_side

    @compiled
    def step(
        t: float,
        h: float,
        y0: Array,
        f0: Array,
        arrow: Array,
        y1: Array,
        f1: Array,
        arrow_1: Array,
        error: Array,
        work: Array,
        memory: Array,
        voltages: Array,
        model: CompiledModel,
        effects: tuple[object, ...],
    ) -> None:
        n = len(y0)
        u1, u2, u3, u4, y, f = work[0], work[1], work[2], work[3], work[4], work[5]
        diagonal, per_h = 1.0 / (h * _DIAGONAL), 1.0 / h
        for i in range(n):
            u1[i] = f0[i]
        solve(diagonal, arrow, u1)
        for i in range(n):
            y[i] = y0[i] + _A21 * u1[i]
        rhs(t + _T2 * h, y, f, arrow_1, memory, voltages, model, effects)
        for i in range(n):
            u2[i] = f[i] + per_h * _C21 * u1[i]
        solve(diagonal, arrow, u2)
        for i in range(n):
            y[i] = y0[i] + _A31 * u1[i] + _A32 * u2[i]
        rhs(t + _T3 * h, y, f, arrow_1, memory, voltages, model, effects)
        for i in range(n):
            u3[i] = f[i] + per_h * (_C31 * u1[i] + _C32 * u2[i])
        solve(diagonal, arrow, u3)
        for i in range(n):
            y[i] = y0[i] + _A41 * u1[i] + _A42 * u2[i] + _A43 * u3[i]
        rhs(t + _T4 * h, y, f, arrow_1, memory, voltages, model, effects)
        for i in range(n):
            u4[i] = f[i] + per_h * (_C41 * u1[i] + _C42 * u2[i] + _C43 * u3[i])
        solve(diagonal, arrow, u4)
        for i in range(n):
            y1[i] = y0[i] + _M1 * u1[i] + _M2 * u2[i] + _M3 * u3[i] + _M4 * u4[i]
            error[i] = _E1 * u1[i] + _E2 * u2[i] + _E3 * u3[i] + _E4 * u4[i]
        rhs(t + h, y1, f1, arrow_1, memory, voltages, model, effects)

    return step
