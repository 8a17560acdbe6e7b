"""
Fitted explanations with their losses, and which of them is preferred.

They are compared by a penalised robust loss of all runs, taken for a log density; of those within
two standard errors of the best (A. Vehtari, A. Gelman, J. Gabry, Stat. Comput. 27 (2017) 1413) the
simplest is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import FORCE, GAS, SENSOR
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, by_balance, rms
from pneu_rig_ros.diagnosis.residuals.localisation import NOISE_ERROR, significant_cells
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.diagnosis.search.fitting import Fit

# the reasons are in docs/diagnose.md: "The numbers that decide", "Weak nuisances and ..."
STANDARD_ERRORS = 2.0
"""Two explanations whose difference is smaller are indistinguishable."""
DECISIVE = 10.0
"""Difference of robust losses that decides however few the runs [-]."""
LIKELY = 3.0
"""What one more cause has to gain on the held-out data alone [-]."""
LARGEST_CHANCE = 100.0
"""Improvement that no cause has by chance [-]."""
LITTLE_LEFT = 0.2
"""Share of the excess that counts as little: a name may leave it where a formula leaves less."""
MOST_LEFT = 0.5
"""Largest share that a name may leave where no formula leaves less: it has to explain most."""
MOST_LEFT_REPORTED = 0.75
"""The same as it is reported: with the noise that the data have if the name is true [-]."""
NEARLY_ALL_LEFT = 0.95
"""
The same where little is left as reported; and of an effect where all models are far off: those of
real seals close a tenth [-].
"""
MUCH_BETTER = 0.5
"""Empirical terms take the place of a name that leaves more than their excess by this factor."""
NEGLIGIBLE = 0.03
"""Share of the excess so small that its significance is no measure of a cause [-]."""
ANOTHER_CAUSE_LEAVES = 0.7
"""Largest share of the excess that one more cause may leave [-]."""
LEAST_EFFECT = 0.5
"""
RMS of the change of a residual, relative to its noise, by the weakest cause that is named where
sensors and supply are known to their class only [-].
"""
BALANCES_OF = {GAS: ('gas_1', 'gas_2'), FORCE: ('force',), SENSOR: BALANCES}
"""Group of a cause -> balances on which it acts."""


class Data(NamedTuple):
    """Runs to which explanations are fitted, and runs that judge them."""

    training: Dataset
    held_out: Dataset

    def each(self, change: Callable[[Dataset], Dataset]) -> Data:
        """Return both changed, the training data first."""
        return Data(change(self.training), change(self.held_out))

    @property
    def without_cycles(self) -> Data:
        """Both without simulation."""
        return self.each(lambda dataset: dataset.without_cycles)

    @property
    def single_runs(self) -> list[Dataset]:
        """A dataset of each run, without simulation."""
        return [run for dataset in self for run in dataset.single_runs]

    def with_cycles(self, hypothesis: Hypothesis, rng: Generator, free: bool = False) -> Data:
        """Return both with simulated cycles, see ``Dataset.with_cycles``."""
        return self.each(lambda dataset: dataset.with_cycles(hypothesis, rng, free))

    def with_noise_of(self, hypothesis: Hypothesis, rng: Generator) -> Data:
        """Return both with the noise that they have if a hypothesis is true."""

        def renewed(before: Dataset) -> Dataset:
            dataset = Dataset.of(hypothesis, before.comparisons, rng)
            if before.cycles is None:
                return dataset
            return dataset.with_cycles(hypothesis, rng, before.runs_freely)

        return self.each(renewed)


@dataclass(frozen=True, kw_only=True)
class ScoredFit(Fit):
    """
    A fit with its losses on all runs.

    :param losses: of independent stretches of all runs, held-out ones last, shape (k,)
    :param penalty: for its coordinates (G. Schwarz, Ann. Stat. 6 (1978) 461) [-]
    :param held_out: number of the held-out stretches
    :param simulated: whether simulated cycles are part of the data
    """

    losses: Floats
    penalty: float
    held_out: int
    simulated: bool

    @property
    def cost(self) -> float:
        """Negative log density of all runs, penalised [-]."""
        return float(self.losses.sum()) + self.penalty

    def difference(self, other: ScoredFit) -> tuple[float, float]:
        """Return by how much the cost exceeds that of another fit, with its standard error."""
        difference = self.losses - other.losses
        error = float(np.sqrt(difference.size) * difference.std())
        return self.cost - other.cost, error


def score(fit: Fit, data: Data) -> ScoredFit:
    """Return a fit with its losses on all runs."""
    parts = [dataset.losses(fit.hypothesis) for dataset in data]
    count = sum(whiten.kept.sum() for run in data.training.runs for whiten in run.noise)
    penalty = 0.5 * len(fit.explanation.coordinates) * float(np.log(max(count, 1)))
    penalty += fit.explanation.negative_log_prior
    return ScoredFit(
        fit.explanation,
        fit.loss,
        fit.covariance,
        losses=np.concatenate(parts),
        penalty=penalty,
        held_out=parts[1].size,
        simulated=data.training.cycles is not None,
    )


def as_good_as(fit: ScoredFit, best: ScoredFit) -> bool:
    """Return whether a fit is within two standard errors of the best."""
    difference, error = fit.difference(best)
    return difference <= min(STANDARD_ERRORS * error, DECISIVE)


def preferred(fits: Sequence[ScoredFit]) -> ScoredFit:
    """
    Return the simplest of those that are within two standard errors of the best.

    That is the one with the fewest parameters of the model, then with the fewest fitted values: a
    parameter often imitates an effect whose formula is not quite right, hardly any effect one.
    """
    best = min(fits, key=lambda fit: fit.cost)

    def order(fit: ScoredFit) -> tuple[int, int, float]:
        own = fit.explanation
        return sum(part.is_parameter for part in own.parts), len(own.coordinates), fit.cost

    return min((fit for fit in fits if as_good_as(fit, best)), key=order)


def best_of_each(fits: Sequence[ScoredFit]) -> list[ScoredFit]:
    """Return the best fit of each set of causes and forms of their laws, best first."""
    best: dict[tuple[object, ...], ScoredFit] = {}
    for fit in sorted(fits, key=lambda fit: fit.cost):
        best.setdefault(fit.explanation.forms, fit)
    return list(best.values())


def improves(fit: ScoredFit, smaller: ScoredFit) -> bool:
    """
    Return whether an explanation is better than a smaller one, also on the held-out data.

    Where these do not show what is beyond doubt in the training data, they must not contradict it.
    """
    difference, _ = fit.difference(smaller)
    gains = smaller.losses - fit.losses
    training, held_out = gains[: -fit.held_out].sum(), gains[-fit.held_out :].sum()
    reproduced = held_out > LIKELY or (held_out >= 0.0 and training > LARGEST_CHANCE)
    return bool(-difference > DECISIVE and reproduced)


class Grown(NamedTuple):
    """Fits of explanations with one more cause, and the best one without it on the same data."""

    fits: list[ScoredFit]
    before: ScoredFit

    @property
    def chosen(self) -> ScoredFit:
        """The preferred one, if there are any."""
        return preferred(self.fits)

    @property
    def is_better(self) -> bool:
        """Whether there are any, the preferred one better than without the cause."""
        return bool(self.fits) and improves(self.chosen, self.before)


def ambiguous(fits: Sequence[ScoredFit]) -> bool:
    """Return whether a cause of friction is among several that are indistinguishable."""
    best = min(fits, key=lambda fit: fit.cost)
    causes = [fit.explanation.parts[-1] for fit in fits if as_good_as(fit, best)]
    return len(causes) > 1 and any(cause.group == FORCE for cause in causes)


def excess(dataset: Dataset, hypothesis: Hypothesis) -> float:
    """Return the misfit beyond the noise [-]: of the cycles if simulated, else of residuals."""
    if dataset.cycles is None:
        return residual_excess(dataset, hypothesis)
    return dataset.cycles.excess(hypothesis)


def residual_excess(
    dataset: Dataset, hypothesis: Hypothesis, balances: Sequence[str] = BALANCES
) -> float:
    """
    Return the misfit of residuals beyond the noise, in some balances [-].

    It is the root of the sum of squares in the cells in which they are significant: a local one
    does not drown in the noise of all others.
    """
    significant = significant_cells(windows_of(dataset, hypothesis))
    return float(np.sqrt(sum(t.excess for cell, t in significant if cell.place[0] in balances)))


def remaining_share(dataset: Dataset, before: Hypothesis, after: Hypothesis) -> float:
    """Return the share of the excess of a hypothesis that remains with another, 0 of none [-]."""
    old = excess(dataset, before)
    return excess(dataset, after) / old if old > 0.0 else 0.0


def stands_out(grown: Grown) -> bool:
    """
    Return whether an effect gains more than by chance, and decisively more than any other cause.

    What several weak effects leave is hardly the formula of one, so that other causes explain it
    about as well; a parameter, which changes a balance everywhere, may explain it best. Other
    forms of an effect are the same cause.
    """
    chosen, cause = grown.chosen, grown.chosen.explanation.parts[-1]
    others = [fit for fit in grown.fits if fit.explanation.parts[-1].effect != cause.effect]
    clear = all(fit.difference(chosen)[0] > DECISIVE for fit in others)
    return cause.is_effect and clear and grown.before.cost - chosen.cost > LARGEST_CHANCE


def explains_alone(best: Fit, smaller: Hypothesis, searched: Dataset, data: Data) -> bool:
    """
    Return whether the last cause leaves nothing but noise where it acts, and more was left.

    Several weak effects would leave what the others make.

    :param smaller: the hypothesis without it
    :param searched: the training data in which it was found, with the noise under that
    :param data: with the noise under the best explanation
    """
    before = by_balance(searched.residuals_by_run(smaller))
    after, *left = (
        by_balance(dataset.residuals_by_run(best.hypothesis)) for dataset in (searched, *data)
    )
    acts = [
        name
        for name in BALANCES
        if rms(before[name]) > NOISE_ERROR and rms(after[name] - before[name]) > LEAST_EFFECT
    ]
    return bool(acts) and all(rms(each[name]) < NOISE_ERROR for each in left for name in acts)


def closes_the_gap(held_out: Dataset, smaller: Hypothesis, accepted: Fit, causes: int = 1) -> bool:
    """
    Return whether more causes leave much less on the held-out data.

    Where hardly anything is significant there, that is no measure of a cause: the likelihood, by
    which it was chosen, has to do. Nor is a gap in balances on which a cause does not act, unless
    cycles are simulated, in which a cause of the forces moves everything, as any does in free
    runs. These are so sharp that they show the formula of the first cause to be off, and many a
    further one closes a part of that: it has to close most.

    :param causes: that the accepted explanation has more than the smaller one
    """
    better, parts = accepted.hypothesis, accepted.explanation.parts
    if held_out.runs_freely:
        most = ANOTHER_CAUSE_LEAVES if len(parts) == causes else MOST_LEFT
        return excess(held_out, better) < most**causes * excess(held_out, smaller)
    most = ANOTHER_CAUSE_LEAVES**causes
    groups = {part.group for part in parts[-causes:]}
    if held_out.cycles is None or groups == {GAS}:
        acts_on = [name for group in groups for name in BALANCES_OF[group]]
        before, after = (residual_excess(held_out, each, acts_on) for each in (smaller, better))
        if after <= most * before:
            return True
    for dataset in (held_out.without_cycles, held_out):
        left = excess(dataset, smaller)
        if left < NEGLIGIBLE * excess(dataset, accepted.explanation.given):
            return True
        if excess(dataset, better) < most * left:
            return True
    return False
