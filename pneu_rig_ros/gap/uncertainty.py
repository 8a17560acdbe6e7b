"""
How far fitted values may be off: the spread of the estimates from twins of the measured runs.

The curvature of a fit promises too much: the errors of the readings from which a prediction starts
again are common to a whole cycle, so that its residuals are not independent. Every twin has errors
of its own, and what one step of the fit makes of them is what it would have made of those of the
measured runs.

The spread is that about one minimum. Slips that come at the wrong time make several side by side,
and a fit that has ended in another than the truth's is off by more than its interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import FINE_STEP, Explanation, Fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.twin import twin_of

Floats = NDArray[np.float64]

TWINS = 12
"""Of all runs together."""
CONFIDENCE = 0.95


def with_spread(
    fit: Fit, given: Hypothesis, evidence: Evidence, modes: Sequence[Mode], executor: Executor
) -> Fit:
    """
    Return a fit whose intervals are those of the spread over twins.

    A model that leaves more than the noise is off by more too: in proportion to the root of the
    cost, as for any fit by least squares.

    :param modes: predictions that it was fitted to
    """
    seen, best = fit.explanation.seen, fit.explanation.apply(given)
    edges = np.array([c.bounds[1] for c in fit.explanation.coordinates])
    steps = np.where(seen + FINE_STEP < edges, 1.0, -1.0) * FINE_STEP
    moved = [fit.explanation.moved(one) for one in seen + np.diag(steps)]
    settled = given, evidence, modes
    here, *there = map_tasks(executor, _residual, [fit.explanation, *moved], *settled)
    slopes = (np.column_stack(there) - here[:, np.newaxis]) / steps
    inverse = np.linalg.pinv(slopes)
    seeds = evidence.rng.integers(2**63, size=TWINS).tolist()
    twins = map_tasks(executor, _residual_of_twin, seeds, best, evidence, modes)
    expected = float(np.mean([residual @ residual for residual in twins]))
    excess = max(float(here @ here) / expected, 1.0)
    changes = np.array([inverse @ one for one in twins])
    quantile = float(t.ppf(0.5 + 0.5 * CONFIDENCE, TWINS))
    spread = np.sqrt(excess * np.mean(changes**2, axis=0))
    return replace(fit, deviations=spread, quantile=quantile)


def _residual(
    explanation: Explanation, given: Hypothesis, evidence: Evidence, modes: Sequence[Mode]
) -> Floats:
    return evidence.residual(explanation.apply(given), modes)


def _residual_of_twin(
    seed: int, best: Hypothesis, evidence: Evidence, modes: Sequence[Mode]
) -> Floats:
    """
    Return the residual of a hypothesis on a twin of every experiment, under the same floors.

    A twin, too, is predicted from the start that its readings say.
    """
    rng = np.random.default_rng(seed)
    stroke = best.model.cylinder.stroke
    twins = [twin_of(best, one, rng).started(stroke) for one in evidence.experiments]
    return Evidence(twins, rng, evidence.floors).residual(best, modes)
