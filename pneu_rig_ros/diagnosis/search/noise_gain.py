"""
What a cause gains by making the noise of the readings small, and not by explaining anything.

Where less mass is accelerated - a lighter piston, a load on a spring - noise of the position makes
smaller residuals. Compared with the noise under the model as it was, they seem likelier.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import Comparison, Residuals
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.residuals.noise import COPIES, NoiseModel, reading_errors
from pneu_rig_ros.diagnosis.residuals.threads import map_runs
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE, ScoredFit, improves, preferred


def chosen_beyond_noise(
    fits: Sequence[ScoredFit],
    before: ScoredFit,
    given: Hypothesis,
    smaller: Hypothesis,
    data: Sequence[Dataset],
    rng: Generator,
) -> ScoredFit | None:
    """
    Return the preferred of the fits that are better than a smaller one also without that gain.

    :param given: to which the explanations of the fits are applied
    :param smaller: the hypothesis of the fit before
    """
    while fits and improves(chosen := preferred(fits), before):
        larger = chosen.explanation.apply(given)
        by_noise = sum(noise_gain(dataset, smaller, larger, rng) for dataset in data)
        if before.cost - chosen.cost - by_noise > DECISIVE:
            return chosen
        fits = [fit for fit in fits if fit is not chosen]
    return None


def noise_gain(dataset: Dataset, smaller: Hypothesis, larger: Hypothesis, rng: Generator) -> float:
    """
    Return by how much less the noise alone costs with a cause than without it, 0 at least [-].

    Both hypotheses read the same simulated readings.

    :param smaller, larger: the hypothesis without and with the cause
    """
    if not accelerates_less(dataset, smaller, larger):
        return 0.0
    seeds = rng.integers(2**32, size=len(dataset.comparisons)).tolist()
    arguments = dataset.comparisons, dataset.noises, dataset.factors, seeds
    losses = [
        sum(map_runs(partial(_loss_of_noise, hypothesis), *arguments))
        for hypothesis in (smaller, larger)
    ]
    return max(losses[0] - losses[1], 0.0)


def accelerates_less(dataset: Dataset, smaller: Hypothesis, larger: Hypothesis) -> bool:
    """Return whether the accelerated mass is smaller in any window with a cause."""
    masses = [
        np.concatenate([run.evaluate(hypothesis)[1] for run in dataset.comparisons])
        for hypothesis in (smaller, larger)
    ]
    return bool(np.any(masses[1] < masses[0]))


def _loss_of_noise(
    hypothesis: Hypothesis,
    comparison: Comparison,
    noise: NoiseModel,
    factors: Residuals,
    seed: int,
) -> float:
    """Return the mean loss of the errors of residuals of simulated readings [-]."""
    errors = reading_errors(hypothesis, comparison, np.random.default_rng(seed), COPIES)
    losses = []
    for copy in zip(*errors, strict=True):
        whitened = noise.whiten(Residuals(*(np.nan_to_num(each) for each in copy)))
        losses.append(sum(loss(z / f) for z, f in zip(whitened, factors, strict=True)))
    return float(np.mean(losses))
