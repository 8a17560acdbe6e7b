"""
The arrays that a run changes, and what is where in them: ``state[at.VELOCITY]``.

The continuous state is a flat array, followed by the states of the optional effects. What jumps -
rest or sliding, contact with an end stop, the static friction held through a slip, the anchors of
F(z) - is the memory, constant while the equations are integrated and changed only by ``events``.
"""

from typing import NamedTuple

from pneu_rig_ros.arrays import Floats, Integers

POSITION, VELOCITY, PRESSURE_1, PRESSURE_2, DEFLECTION, FILM, GAS_MASS_1, GAS_MASS_2 = range(8)
STATE_SIZE = 8

(STICKING, CONTACT, REST_START, REST_AGE, SLIDE_START, HELD_STATIC, HELD_DWELL, ANCHORS) = range(8)
"""
Memory: at rest (0, 1), end stop touched (-1 at 0, +1 at L), time rest began [s] and the dwell that
F_s stood for then [s]; time sliding began [s]; F_s [N] and dwell [s] at the last breakaway; the
anchors of F(z) [m].
"""
HELD = 2.0
"""In place of a contact: the motion is imposed from outside, see ``run``."""

(V_V, V_Z, V_P1, V_P2, Z_V, Z_Z, P1_V, P1_P1, P2_V, P2_P2, FREE_ACCELERATION, GROWN_STATIC) = (
    range(12)
)
"""Arrow-shaped Jacobian of (v, z, p1, p2), row_column; acceleration without a stop; Eq. 16."""
ARROW_SIZE = 12

START, END, SUGGESTED, NOW = range(4)
"""Clock [s]: both ends of the present step, length of the next one, present time."""
STEPS, REJECTED, EVALUATIONS, EVENTS, PENDING = range(5)
"""Counts; the last is the code of the event that the present step ends with."""


class Point(NamedTuple):
    """
    Where the right-hand side is evaluated, and what it finds there.

    :param state: shape (n,)
    :param rate: d(state)/dt, shape (n,)
    :param arrow: Jacobian entries and auxiliary output, shape (ARROW_SIZE,)
    :param memory: what jumps, shape (ANCHORS + anchors,)
    :param voltages: u1, u2 [V], shape (2,)
    """

    state: Floats
    rate: Floats
    arrow: Floats
    memory: Floats
    voltages: Floats


class IntegratorState(NamedTuple):
    """
    Everything an integration under way consists of.

    :param clock: shape (4,); a step that ends at infinity has led to states that are not numbers
    :param counts: shape (5,)
    :param y0, f0, arrow_0: state, rate and Jacobian at the start of the present step
    :param end: of the present step
    :param scale: error weights, full scale of each state, shape (n,)
    :param work: scratch, shape (5, n)
    """

    clock: Floats
    counts: Integers
    y0: Floats
    f0: Floats
    arrow_0: Floats
    end: Point
    scale: Floats
    work: Floats
