"""
Fitted explanations with their losses, and which of them is preferred.

They are compared by a penalised robust loss of all runs, taken for a log density; of those within
two standard errors of the best (A. Vehtari, A. Gelman, J. Gabry, Stat. Comput. 27 (2017) 1413) the
simplest is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import FORCE
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.localisation import significant_cells
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.diagnosis.search.fitting import Fit

STANDARD_ERRORS = 2.0
"""Two explanations whose difference is smaller are indistinguishable."""
DECISIVE = 10.0
"""
Difference of robust losses that decides however few the runs [-]. Of log densities it would be
odds of 20 000 to 1, of which the errors of the noise model may take some.
"""
LIKELY = 3.0
"""What one more cause has to gain on the held-out data alone [-]: so 20 to 1."""
LARGEST_CHANCE = 100.0
"""
Improvement that no cause has by chance [-]: a bristle stiffness gained up to 31 on 28 sets of
replicates of the second shipped cylinder.
"""
MOST_LEFT = 0.2
"""Largest share of the excess that a named cause may leave where a formula leaves less [-]."""
MOST_LEFT_ALONE = 0.5
"""The same where no formula does: a cause has to explain most of the excess [-]."""
MOST_LEFT_REPORTED = 0.75
"""
Largest share of the excess, as it is reported, that a named cause may leave [-]: with the noise
that the data have if it is true, which may differ from that under the given model.
"""
MOST_LEFT_OF_ALL = 0.95
"""The same of an effect where all models are far off: those of real seals close a tenth [-]."""
MUCH_BETTER = 0.5
"""Empirical terms take the place of a name that leaves more than their excess by this factor."""


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


def score(fit: Fit, given: Hypothesis, training: Dataset, held_out: Dataset) -> ScoredFit:
    """Return a fit with its losses on all runs."""
    hypothesis = fit.explanation.apply(given)
    parts = [dataset.losses(hypothesis) for dataset in (training, held_out)]
    count = sum(whiten.kept.sum() for run in training.runs for whiten in run.noise)
    penalty = 0.5 * len(fit.explanation.coordinates) * float(np.log(max(count, 1)))
    penalty += fit.explanation.negative_log_prior
    return ScoredFit(
        fit.explanation,
        fit.loss,
        fit.covariance,
        losses=np.concatenate(parts),
        penalty=penalty,
        held_out=parts[1].size,
        simulated=training.cycles is not None,
    )


def as_good_as(fit: ScoredFit, best: ScoredFit) -> bool:
    """Return whether a fit is within two standard errors of the best."""
    difference, error = fit.difference(best)
    return difference <= min(STANDARD_ERRORS * error, DECISIVE)


def preferred(fits: Sequence[ScoredFit]) -> ScoredFit:
    """Return the simplest of those that are within two standard errors of the best."""
    best = min(fits, key=lambda fit: fit.cost)
    equivalent = [fit for fit in fits if as_good_as(fit, best)]
    return min(equivalent, key=lambda fit: (len(fit.explanation.coordinates), fit.cost))


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


def any_improves(fits: Sequence[ScoredFit], smaller: ScoredFit) -> bool:
    """Return whether there are explanations, the preferred one better than a smaller one."""
    return bool(fits) and improves(preferred(fits), smaller)


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
