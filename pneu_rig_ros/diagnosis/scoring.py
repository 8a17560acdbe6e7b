"""
Fitted explanations with what they leave, and which of them is preferred.

They are compared by the log predictive density of all runs; of those within two standard errors of
the best (A. Vehtari, A. Gelman, J. Gabry, Stat. Comput. 27 (2017) 1413) the simplest is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.candidates import FORCE
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.fitting import Fit
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.localisation import NOISE_KNOWN

Floats = NDArray[np.float64]

ERRORS = 2.0
"""Standard errors within which two explanations are not told apart."""
DECISIVE = 10.0
"""
Difference of log densities beyond which they are, however few the runs [-]: odds of 20 000 to 1,
of which the errors of the noise model may take some.
"""
LIKELY = 3.0
"""The same for one more cause, on the runs left out alone [-]: odds of 20 to 1."""
TRUE_LOSS = 3.5
"""Mean loss of the cycles of a true model [-]."""


@dataclass(frozen=True)
class ScoredFit:
    """
    A fitted explanation and what it leaves.

    :param fit: the fit
    :param losses: of independent stretches of all runs, those left out last, shape (k,)
    :param penalty: what its coordinates cost (Schwarz) [-]
    :param held: number of the last stretches, those of runs left out
    :param simulated: whether simulation was part of the dataset
    """

    fit: Fit
    losses: Floats
    penalty: float
    held: int
    simulated: bool

    @property
    def explanation(self) -> Explanation:
        """The explanation with its values."""
        return self.fit.explanation

    @property
    def total(self) -> float:
        """Negative log density of all runs, penalised [-]."""
        return float(self.losses.sum()) + self.penalty

    def behind(self, other: ScoredFit) -> tuple[float, float]:
        """Return by how much it is worse than another one, and the standard error of that."""
        difference = self.losses - other.losses
        error = float(np.sqrt(difference.size) * difference.std())
        return self.total - other.total, error


def as_good_as(one: ScoredFit, best: ScoredFit) -> bool:
    """Return whether one is within two standard errors of the best."""
    worse, error = one.behind(best)
    return worse <= min(ERRORS * error, DECISIVE)


def preferred(scored: Sequence[ScoredFit]) -> ScoredFit:
    """Return the simplest of those that are within two standard errors of the best."""
    best = min(scored, key=lambda one: one.total)
    alike = [one for one in scored if as_good_as(one, best)]
    return min(alike, key=lambda one: (len(one.explanation.coordinates), one.total))


def best_of_each(scored: Sequence[ScoredFit]) -> list[ScoredFit]:
    """Return the best of those that have the same causes."""
    best: dict[str, ScoredFit] = {}
    for one in sorted(scored, key=lambda one: one.total):
        best.setdefault(one.explanation.name, one)
    return list(best.values())


def score(one: Fit, given: Hypothesis, fitted: Dataset, held: Dataset) -> ScoredFit:
    """Return a fit with its losses on all runs."""
    hypothesis = one.explanation.apply(given)
    parts = [dataset.losses(hypothesis) for dataset in (fitted, held)]
    count = sum(whiten.kept.sum() for noise in fitted.noises for whiten in noise)
    penalty = 0.5 * len(one.explanation.coordinates) * float(np.log(max(count, 1)))
    simulated = fitted.cycles is not None
    return ScoredFit(one, np.concatenate(parts), penalty, parts[1].size, simulated)


def gained(one: ScoredFit, before: ScoredFit) -> bool:
    """Return whether an explanation is better than a smaller one, on the runs left out too."""
    worse, _ = one.behind(before)
    gain = float((before.losses - one.losses)[-one.held :].sum())
    return -worse > DECISIVE and gain > LIKELY


def ambiguous(found: Sequence[ScoredFit]) -> bool:
    """Return whether a cause of friction is among several that cannot be told apart."""
    best = min(found, key=lambda one: one.total)
    alike = [one for one in found if as_good_as(one, best)]
    last = [one.explanation.parts[-1] for one in alike]
    return len(alike) > 1 and any(part.group == FORCE for part in last)


def above(whitened: Floats) -> float:
    """Return what of residuals noise does not explain, in standard deviations [-]."""
    if not whitened.size:
        return 0.0
    excess = float(np.mean(whitened**2)) - NOISE_KNOWN**2
    return float(np.sqrt(max(excess, 0.0)))


def excess(dataset: Dataset, hypothesis: Hypothesis) -> float:
    """
    Return how far a hypothesis is off beyond the noise [-].

    In the cycles, where simulation is part of the dataset, else in the residuals.
    """
    if dataset.cycles is None:
        return above(dataset.whitened(hypothesis))
    losses = dataset.cycles.losses(hypothesis) - TRUE_LOSS
    return max(float(losses.mean()), 0.0)


def remaining_share(dataset: Dataset, before: Hypothesis, after: Hypothesis) -> float:
    """Return the share of the excess of one hypothesis that another leaves, 0 of none [-]."""
    old = excess(dataset, before)
    return excess(dataset, after) / old if old > 0.0 else 0.0
