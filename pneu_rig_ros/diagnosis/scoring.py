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
from pneu_rig_ros.diagnosis.evidence import Evidence
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.localisation import NOISE_KNOWN
from pneu_rig_ros.diagnosis.ranking import Fit

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
class Scored:
    """
    A fitted explanation and what it leaves.

    :param fit: the fit
    :param losses: of independent stretches of all runs, those left out last, shape (k,)
    :param penalty: what its coordinates cost (Schwarz) [-]
    :param held: number of the last stretches, those of runs left out
    :param simulated: whether simulation was part of the evidence
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

    def behind(self, other: Scored) -> tuple[float, float]:
        """Return by how much it is worse than another one, and the standard error of that."""
        difference = self.losses - other.losses
        error = float(np.sqrt(difference.size) * difference.std())
        return self.total - other.total, error


def no_worse(one: Scored, best: Scored) -> bool:
    """Return whether one is within two standard errors of the best."""
    worse, error = one.behind(best)
    return worse <= min(ERRORS * error, DECISIVE)


def preferred(scored: Sequence[Scored]) -> Scored:
    """Return the simplest of those that are within two standard errors of the best."""
    best = min(scored, key=lambda one: one.total)
    alike = [one for one in scored if no_worse(one, best)]
    return min(alike, key=lambda one: (len(one.explanation.coordinates), one.total))


def best_of_each(scored: Sequence[Scored]) -> list[Scored]:
    """Return the best of those that have the same causes."""
    best: dict[str, Scored] = {}
    for one in sorted(scored, key=lambda one: one.total):
        best.setdefault(one.explanation.name, one)
    return list(best.values())


def score(one: Fit, given: Hypothesis, fitted: Evidence, held: Evidence) -> Scored:
    """Return a fit with its losses on all runs."""
    hypothesis = one.explanation.apply(given)
    parts = [evidence.losses(hypothesis) for evidence in (fitted, held)]
    count = sum(whiten.kept.sum() for noise in fitted.noises for whiten in noise)
    penalty = 0.5 * len(one.explanation.coordinates) * float(np.log(max(count, 1)))
    simulated = fitted.confirmation is not None
    return Scored(one, np.concatenate(parts), penalty, parts[1].size, simulated)


def gained(one: Scored, before: Scored) -> bool:
    """Return whether an explanation is better than a smaller one, on the runs left out too."""
    worse, _ = one.behind(before)
    gain = float((before.losses - one.losses)[-one.held :].sum())
    return -worse > DECISIVE and gain > LIKELY


def ambiguous(found: Sequence[Scored]) -> bool:
    """Return whether a cause of friction is among several that cannot be told apart."""
    best = min(found, key=lambda one: one.total)
    alike = [one for one in found if no_worse(one, best)]
    last = [one.explanation.parts[-1] for one in alike]
    return len(alike) > 1 and any(part.group == FORCE for part in last)


def above(whitened: Floats) -> float:
    """Return what of residuals noise does not explain, in standard deviations [-]."""
    if not whitened.size:
        return 0.0
    excess = float(np.mean(whitened**2)) - NOISE_KNOWN**2
    return float(np.sqrt(max(excess, 0.0)))


def excess(evidence: Evidence, hypothesis: Hypothesis) -> float:
    """
    Return how far a hypothesis is off beyond the noise [-].

    In the cycles, where simulation is part of the evidence, else in the residuals.
    """
    if evidence.confirmation is None:
        return above(evidence.whitened(hypothesis))
    losses = evidence.confirmation.losses(hypothesis) - TRUE_LOSS
    return max(float(losses.mean()), 0.0)


def left_of(evidence: Evidence, before: Hypothesis, after: Hypothesis) -> float:
    """Return the share of the excess of one hypothesis that another leaves, 0 of none [-]."""
    old = excess(evidence, before)
    return excess(evidence, after) / old if old > 0.0 else 0.0
