"""The compiled entry points of the integration of one right-hand side."""

from collections.abc import Callable
from typing import NamedTuple

from pneu_rig_ros.model.dynamics import RightHandSide
from pneu_rig_ros.model.imposed import build_run_imposed
from pneu_rig_ros.model.integrator import build_advance, build_cut, build_run, build_start, sample


class Solver(NamedTuple):
    """Rates at the start, a run, and a run along a measured one."""

    start: Callable[..., None]
    run: Callable[..., None]
    run_imposed: Callable[..., None]


def build_solver(right_hand_side: RightHandSide) -> Solver:
    """Return the compiled entry points for a right-hand side."""
    start = build_start(right_hand_side)
    cut, advance = build_cut(start), build_advance(right_hand_side, start)
    return Solver(start, build_run(cut, advance), build_run_imposed(start, cut, sample, advance))
