"""
Causes that no cell shows but all windows together do: a score test with replicates.

What a cause adds to each window is known from its formula, so that its gain sums over all of them
(C. R. Rao, Proc. Camb. Phil. Soc. 44 (1948) 50). Small errors of the noise sum up as well: what
fits of the cause gain on replicates without it does not count.
"""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.replicates import replicate
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit, loss_of
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE
from pneu_rig_ros.diagnosis.search.screening import Screened
from pneu_rig_ros.executor import Executor, map_tasks

REPLICATES = 4
"""Of the recordings, of which the largest gain counts: two for each of two processors."""


def worth_a_fit(screened: Sequence[Screened], loss_without: float, windows: int) -> list[Screened]:
    """Return the candidates that would gain decisively if each kept to its estimate."""
    price = 0.5 * np.log(max(windows, 1))
    return [
        result
        for result in screened
        if loss_without - result.loss > DECISIVE + price * len(result.candidate.coordinates)
    ]


def gains_by_chance(
    larger: Explanation,
    smaller: Explanation,
    given: Hypothesis,
    dataset: Dataset,
    rng: Generator,
    executor: Executor,
) -> list[float]:
    """
    Return what an explanation gains on replicates of a smaller one, both fitted [-].

    :param given: to which the explanations are applied
    :param dataset: whose runs are replicated, and with whose noise, without its cycles
    """
    seeds = rng.spawn(REPLICATES)
    return map_tasks(executor, _gain, seeds, larger, smaller, given, dataset)


def _gain(
    rng: Generator, larger: Explanation, smaller: Explanation, given: Hypothesis, dataset: Dataset
) -> float:
    true = smaller.apply(given)
    runs = [replicate(true, comparison, rng) for comparison in dataset.comparisons]
    data = Dataset.of(true, runs, rng, dataset.inflation)
    return _loss_left(smaller, given, data) - _loss_left(larger, given, data)


def _loss_left(explanation: Explanation, given: Hypothesis, data: Dataset) -> float:
    """Return the loss that the fitted explanation leaves [-]."""
    if not explanation.coordinates:
        return loss_of(explanation, given, data)
    return fit(explanation, given, data, ROUNDS).loss
