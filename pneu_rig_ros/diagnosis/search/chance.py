"""
What a cause gains without being there: by chance, and by what it does to the noise.

In small parts over many windows any cause gains a little: as much as on replicates of the model
without it. Where less mass is accelerated - a lighter piston, a load on a spring - noise of the
position makes smaller residuals. Compared with the noise under the model as it was, they seem
likelier. A friction that is steep in the speed makes larger ones: a cause is then far off under
that noise though it is right, and the density of the residuals under their own noise has to judge
it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import Residuals
from pneu_rig_ros.diagnosis.residuals.dataset import STRETCHES, Dataset, RunData, loss, rms
from pneu_rig_ros.diagnosis.residuals.noise import COPIES, reading_errors
from pneu_rig_ros.diagnosis.residuals.replicates import replicate
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit, loss_of
from pneu_rig_ros.diagnosis.search.scoring import Data, ScoredFit, score
from pneu_rig_ros.executor import Executor, map_tasks, map_threads

REPLICATES = 4
"""Of the recordings, of which the largest gain counts: two for each of two processors."""
RENEWALS = 2
"""Of the noise: that of values which were fitted under another's is not yet a cause's own."""


def gains_by_chance(
    larger: Explanation,
    smaller: Explanation,
    dataset: Dataset,
    rng: Generator,
    executor: Executor,
) -> list[float]:
    """
    Return what an explanation gains on replicates of a smaller one, both fitted [-].

    :param dataset: whose runs are replicated, and with whose noise, without its cycles
    """
    seeds = rng.spawn(REPLICATES)
    return map_tasks(executor, _gain, seeds, larger, smaller, dataset)


def _gain(rng: Generator, larger: Explanation, smaller: Explanation, dataset: Dataset) -> float:
    true = smaller.hypothesis
    runs = [replicate(true, comparison, rng) for comparison in dataset.comparisons]
    data = Dataset.of(true, runs, rng, dataset.inflation)
    return _loss_left(smaller, data) - _loss_left(larger, data)


def _loss_left(explanation: Explanation, data: Dataset) -> float:
    """Return the loss that an explanation leaves, fitted if it has values [-]."""
    if explanation.coordinates:
        return fit(explanation, data, ROUNDS).loss
    return loss_of(explanation, data)


def beyond_noise(
    fits: Sequence[ScoredFit], smaller: Hypothesis, data: Data, rng: Generator
) -> list[ScoredFit]:
    """
    Return fits that pay for what they gain by smaller noise, so that the rest decides.

    :param smaller: the hypothesis of the fit before
    """
    gains = noise_gains([fit.hypothesis for fit in fits], smaller, data, rng)
    return [
        replace(fit, penalty=fit.penalty + gain) for fit, gain in zip(fits, gains, strict=True)
    ]


def noise_gains(
    larger: Sequence[Hypothesis], smaller: Hypothesis, data: Sequence[Dataset], rng: Generator
) -> list[float]:
    """
    Return by how much less the noise alone costs with each cause than without it, 0 at least [-].

    All hypotheses read the same simulated readings.
    """
    less = [any(accelerates_less(dataset, smaller, each) for dataset in data) for each in larger]
    if not any(less):
        return [0.0] * len(less)
    seed = int(rng.integers(2**32))

    def cost(hypothesis: Hypothesis) -> float:
        readings = np.random.default_rng(seed)
        return sum(_cost_of_noise(hypothesis, dataset, readings) for dataset in data)

    reference = cost(smaller)
    return [
        max(reference - cost(each), 0.0) if lighter else 0.0
        for each, lighter in zip(larger, less, strict=True)
    ]


def under_own_noise(before: ScoredFit, data: Data, seed: int) -> tuple[ScoredFit, float]:
    """
    Return a fit under the noise that the data have if it is true, and its RMS in training.

    Its losses are those of a density: a larger noise costs the logarithm of its growth.

    :param data: with the noise under another hypothesis, training and held-out, without cycles
    """
    rng, again = np.random.default_rng(seed), before
    for _ in range(RENEWALS):
        renewed = data.with_noise_of(again.hypothesis, rng)
        again = score(fit(again.explanation, renewed.training, ROUNDS), renewed)
    growth = [_growth_of_noise(*pair) for pair in zip(data, renewed, strict=True)]
    whitened = renewed.training.whitened(again.hypothesis)
    return replace(again, losses=again.losses + np.concatenate(growth)), rms(whitened)


def _growth_of_noise(before: Dataset, after: Dataset) -> Floats:
    """Return the logarithm by which the noise of each stretch grows, shape (k,)."""
    growth = []
    for old, new in zip(_log_deviations(before), _log_deviations(after), strict=True):
        # a window that is kept under one of them alone has nothing to be compared with
        larger = np.nan_to_num(new - old)[np.isfinite(new)]
        growth += [float(part.sum()) for part in np.array_split(larger, STRETCHES)]
    return np.array(growth)


def _log_deviations(dataset: Dataset) -> Iterator[Floats]:
    """Yield the logarithm of the noise of all windows, NaN of those not kept, shape (m,) each."""
    for run in dataset.runs:
        for whiten, factor in zip(run.noise, run.factors, strict=True):
            logarithm = np.full(whiten.kept.size, np.nan)
            logarithm[whiten.kept] = np.log(factor * whiten.deviation)
            yield logarithm


def accelerates_less(dataset: Dataset, smaller: Hypothesis, larger: Hypothesis) -> bool:
    """Return whether the accelerated mass is smaller in any window with a cause."""
    return any(
        np.any(run.evaluate(larger)[1] < run.evaluate(smaller)[1]) for run in dataset.comparisons
    )


def _cost_of_noise(hypothesis: Hypothesis, dataset: Dataset, rng: Generator) -> float:
    """Return the mean loss of the errors of residuals of simulated readings of all runs [-]."""
    seeds = rng.integers(2**32, size=len(dataset.runs)).tolist()
    return sum(map_threads(partial(_loss_of_noise, hypothesis), dataset.runs, seeds))


def _loss_of_noise(hypothesis: Hypothesis, run: RunData, seed: int) -> float:
    """Return the mean loss of the errors of residuals of simulated readings [-]."""
    errors = reading_errors(hypothesis, run.comparison, np.random.default_rng(seed), COPIES)
    losses = []
    for copy in zip(*errors, strict=True):
        whitened = run.noise.whiten(Residuals(*(np.nan_to_num(each) for each in copy)))
        losses.append(sum(loss(z / f) for z, f in zip(whitened, run.factors, strict=True)))
    return float(np.mean(losses))
