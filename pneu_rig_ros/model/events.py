"""
What ends a smooth stretch of motion, and what changes then.

Breakaway and arrest (the zero-velocity thresholds of Eq. 16; that of Eq. 13 ends no stretch
unless it is the same), contact with an end stop,
release from it, and the reversals that F(z) remembers. The end stops are rigid and the impact is
perfectly plastic: the piston stays at the stop until the net force points inwards.
"""

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import friction
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.dynamics import dwell_clock
from pneu_rig_ros.model.parameters import Friction

NONE, BREAKAWAY, ARREST, TOUCH, RELEASE, REVERSAL = range(6)

LEAST_HYSTERESIS = 1e-3
"""
How far apart breakaway and arrest are at least, as a share of the velocity of arrest [-].

Where F_s drops so far at breakaway that the piston is held back at once, it goes to and fro
between the two; were they the same velocity, without end in no time.
"""
VELOCITY_TOLERANCE = 1e-10
"""How far beyond its threshold a velocity may be when the event is taken [m/s]."""
POSITION_TOLERANCE = 1e-12
"""How far beyond an end stop the piston may be when the contact is taken [m]."""
PULL_TOLERANCE = 1e-4
"""How far inwards the forces may accelerate a piston when it leaves an end stop [m/s^2]."""


@compiled
def hermite(c0: float, d0: float, c1: float, d1: float, share: float) -> float:
    """Return the cubic through (0, c0), (1, c1) with slopes d0, d1 at ``share`` in 0 to 1."""
    rest = 1.0 - share
    bend = (d0 - (c1 - c0)) * rest - (d1 - (c1 - c0)) * share
    return c0 + share * (c1 - c0) + share * rest * bend


@compiled
def crossing(c0: float, d0: float, c1: float, d1: float, level: float) -> float:
    """Return the share of the step at which the cubic first found passes ``level``."""
    low, high = 0.0, 1.0
    rising = c1 > c0
    for _ in range(40):
        middle = 0.5 * (low + high)
        if (hermite(c0, d0, c1, d1, middle) > level) == rising:
            high = middle
        else:
            low = middle
    return high


@compiled
def release(before: Floats, arrow: Floats, contact: float) -> tuple[int, float, bool]:
    """
    Return whether the piston leaves an end stop within a step, as :func:`locate_event` does.

    :param before, arrow: auxiliary output of the right-hand side at both ends of the step
    :param contact: -1 or +1, the stop
    """
    first, last = -contact * before[at.FREE_ACCELERATION], -contact * arrow[at.FREE_ACCELERATION]
    if last <= 0.0 or contact == at.HELD:
        return NONE, 1.0, False
    if first >= 0.0 or last <= PULL_TOLERANCE:
        return RELEASE, 1.0, True
    return RELEASE, (0.5 * PULL_TOLERANCE - first) / (last - first), False


@compiled
def breakaway_velocity(law: Friction) -> float:
    """Return the velocity [m/s] above which a resting piston moves, see ``LEAST_HYSTERESIS``."""
    return max(law.start_velocity, law.stop_velocity * (1.0 + LEAST_HYSTERESIS))


@compiled
def locate_event(
    step: float, carry: at.IntegratorState, backlash: float, model: CompiledModel
) -> tuple[int, float, bool]:
    """
    Return the first event of a step: its code, its share of the step, and whether it is met.

    An event is met when the step ends beyond its threshold by no more than the tolerance. A
    reversal is not an event: it only bounds the step, so that F(z) sees the turning point.

    :param step: length of the step [s]
    :param carry: with the rates at both ends
    :param backlash: way [m] that the bristle may go back within a step unnoticed by F(z)
    """
    y0, f0, law = carry.y0, carry.f0, model.friction
    y1, f1, arrow, memory, _ = carry.end
    v0, v1 = y0[at.VELOCITY], y1[at.VELOCITY]
    a0, a1 = step * f0[at.VELOCITY], step * f1[at.VELOCITY]
    if memory[at.CONTACT] != 0.0:
        return release(carry.arrow_0, arrow, memory[at.CONTACT])

    if memory[at.STICKING] != 0.0:
        change, threshold = BREAKAWAY, breakaway_velocity(law)
        side = 1.0 if v1 > 0.0 else -1.0
        excess = side * v1 - threshold
        level = side * (threshold + 0.5 * VELOCITY_TOLERANCE)
    else:
        change, threshold = ARREST, law.stop_velocity
        side = 1.0 if v0 > 0.0 else -1.0
        excess = threshold - side * v1
        level = side * (threshold - 0.5 * VELOCITY_TOLERANCE)
    code, share, met = NONE, 1.0, False
    if excess > 0.0:
        code, share = change, crossing(v0, a0, v1, a1, level)
        met = excess <= VELOCITY_TOLERANCE

    x1, stroke = y1[at.POSITION], model.cylinder.stroke
    beyond = max(-x1, x1 - stroke)
    if beyond > 0.25 * POSITION_TOLERANCE:  # rounding at the stop is no contact
        level = -0.5 * POSITION_TOLERANCE if x1 < 0.0 else stroke + 0.5 * POSITION_TOLERANCE
        touch = crossing(y0[at.POSITION], step * v0, x1, step * v1, level)
        if code == NONE or touch < share:
            code, share, met = TOUCH, touch, beyond <= POSITION_TOLERANCE

    if len(law.element_limit) > 0:
        r0, r1 = f0[at.DEFLECTION], f1[at.DEFLECTION]
        if r0 * r1 < 0.0:
            turn = r0 / (r0 - r1)
            back = 0.5 * step * (1.0 - turn) * abs(r1)
            if back > backlash and (code == NONE or turn < share):
                code, share, met = REVERSAL, turn, False
    return code, share, met


@compiled
def update_anchors(point: at.Point, model: CompiledModel) -> None:
    """Let F(z) remember the deflection at the end of an accepted step; changes the memory."""
    friction.drag_anchors(point.state[at.DEFLECTION], point.memory[at.ANCHORS :], model.friction)


@compiled
def apply_event(code: int, time: float, point: at.Point, model: CompiledModel) -> None:
    """Carry out an event: changes state and memory."""
    state, _, arrow, memory, _ = point
    if code == BREAKAWAY:
        break_away(time, memory, arrow[at.GROWN_STATIC], model.friction)
    elif code == ARREST:
        enter_rest(time, memory, model.friction)
    elif code == TOUCH:
        outer = state[at.POSITION] > 0.5 * model.cylinder.stroke
        memory[at.CONTACT] = 1.0 if outer else -1.0
        state[at.POSITION] = model.cylinder.stroke if outer else 0.0
        state[at.VELOCITY] = 0.0
        if memory[at.STICKING] == 0.0:
            enter_rest(time, memory, model.friction)
    elif code == RELEASE:
        memory[at.CONTACT] = 0.0


@compiled
def break_away(time: float, memory: Floats, grown: float, law: Friction) -> None:
    """Begin to slide at ``time`` [s], with Eq. 16 ``grown`` [N]; changes ``memory``."""
    memory[at.HELD_STATIC], memory[at.HELD_DWELL] = grown, dwell_clock(time, memory, law)
    memory[at.SLIDE_START], memory[at.STICKING] = time, 0.0


@compiled
def enter_rest(time: float, memory: Floats, law: Friction) -> None:
    """Let the dwell clock of Eq. 16 run from ``time`` [s] on; changes ``memory``."""
    memory[at.REST_AGE] = dwell_clock(time, memory, law)
    memory[at.REST_START], memory[at.STICKING] = time, 1.0
