"""
Search for the free runs that are nearest to the recordings, from the starts of all candidates.

Residuals do not show a cause whose states are known by integration of noise alone: of a load that
passes the play of its joint, only simulation from the start shows when it arrives.
"""

from collections.abc import Sequence

import numpy as np
from scipy.stats.qmc import Sobol

from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.cycles import Cycles
from pneu_rig_ros.diagnosis.search.multi_start import simplex_search
from pneu_rig_ros.executor import Executor, map_tasks

REFINED = 2
"""Starts that are refined, one for each of two processors."""
POINTS, BOX = 64, 1.0
"""Points around a start that are tried, and their distance at most, internal units [-]."""


def free_run_loss(explanation: Explanation, given: Hypothesis, cycles: Cycles) -> float:
    """Return the loss of free runs under an explanation [-]."""
    return float(cycles.losses(explanation.apply(given)).sum())


def nearest(
    starts: Sequence[Explanation], given: Hypothesis, cycles: Cycles, executor: Executor
) -> Explanation:
    """
    Return the explanation with the least loss of free runs that is found from some starts.

    :param cycles: the free runs
    """
    losses = map_tasks(executor, free_run_loss, starts, given, cycles)
    first = [starts[index] for index in np.argsort(losses, kind='stable')[:REFINED]]
    refined = map_tasks(executor, _refined, first, given, cycles)
    return min(refined, key=lambda pair: pair[1])[0]


def _refined(start: Explanation, given: Hypothesis, cycles: Cycles) -> tuple[Explanation, float]:
    """Return the best explanation near a start, and its loss of free runs [-]."""

    def cost(explanation: Explanation) -> float:
        return free_run_loss(explanation, given, cycles)

    steps = BOX * (2.0 * Sobol(start.theta.size, seed=0).random(POINTS) - 1.0)
    points = [start, *(start.with_theta(start.theta + step) for step in steps)]
    best, loss = min(((point, cost(point)) for point in points), key=lambda pair: pair[1])
    return simplex_search(best, loss, cost)
