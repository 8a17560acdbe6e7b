"""Roots between two bounds by false position (M. Dowell, P. Jarratt, BIT 11 (1971): Illinois)."""

from typing import NamedTuple

from pneu_rig_ros.model.compiled import compiled

MOST_ROUNDS = 60
"""Rounds at most; some five are needed, 25 where a flow is nearly shut off by what it makes."""


class Bracket(NamedTuple):
    """
    Bounds of a root, with the function at both.

    :param side: bound that moved last: -1 the lower, 1 the upper, 0 none
    """

    low: float
    at_low: float
    high: float
    at_high: float
    side: int


@compiled
def secant(bracket: Bracket) -> float:
    """Return where the straight line through both bounds is zero."""
    low, at_low, high, at_high, _ = bracket
    return (low * at_high - high * at_low) / (at_high - at_low)


@compiled
def narrowed(bracket: Bracket, middle: float, value: float) -> Bracket:
    """Return the bracket that a value between its bounds leaves; a bound kept weighs less."""
    low, at_low, high, at_high, side = bracket
    if value < 0.0:
        return Bracket(middle, value, high, at_high * (0.5 if side < 0 else 1.0), -1)
    return Bracket(low, at_low * (0.5 if side > 0 else 1.0), middle, value, 1)
