"""
The ranking of the candidates, and the explanations that compete with the best one.

What was fitted shares the probability of a verdict by pseudo-BMA+ weights (Y. Yao et al., Bayesian
Anal. 13 (2018) 917): by the log predictive densities of stretches of the runs, under a Bayesian
bootstrap of these.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy.special import softmax

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.search.scoring import ScoredFit, as_good_as, excess
from pneu_rig_ros.diagnosis.search.selection import Search

MOST_ROWS = 20
"""Length of the ranking at most."""
RIVALS = 3
"""Explanations that the next experiment is to separate."""
DRAWS, SEED = 2000, 1
"""Of the bootstrap."""

Names = frozenset[str]


def ranking_rows(
    search: Search, best: ScoredFit | None, verdict: str, probability: float
) -> list[dict[str, Any]]:
    """
    Return the candidates of diagnosis.json: the answer, other fitted ones, screened ones.

    :param best: the fit of the answer, None where nothing is missing
    :param verdict: of the answer, which may be none of the causes
    :param probability: of the verdict [-]
    """
    explanation = Explanation(search.given) if best is None else best.explanation
    condition = any(part.is_condition for part in explanation.parts)
    named = condition or verdict in ('effect', 'parameter')
    likely = probabilities(search, explanation, named, probability)
    residuals = search.held_out.without_cycles
    before = excess(residuals, search.given)

    def gap_left(explanation: Explanation) -> float | None:
        if before == 0.0:
            return None
        return min(excess(residuals, explanation.hypothesis) / before, 1.0)

    compared = None if best is None else as_compared(search, best)
    ranking = sorted(search.ranking, key=lambda fit: fit.cost)
    fits = first_of_each(search, ranking if best is None else [best, *ranking])
    rows: dict[Names, dict[str, Any]] = {}
    for names, fit in list(fits.items())[:MOST_ROWS]:
        scored = compared if compared is not None and fit is best else fit
        rows[names] = {
            'names': search.causes(fit.explanation),
            'chosen': fit is best and verdict != 'unknown',
            'probability': likely.get(names),
            'stage': 'simulation' if scored.simulated else 'regression',
            'score': -scored.cost,
            'error': 0.0 if compared is None else _error(scored, compared),
            'gap_left': gap_left(fit.explanation),
            'parameters': _values(fit.explanation),
        }
    for result in search.screened[: MOST_ROWS - len(rows)]:
        name, start = result.candidate.name, result.starts[0]
        if frozenset({name}) not in rows:
            rows[frozenset({name})] = {
                'names': [name],
                'chosen': False,
                'probability': None,
                'stage': 'screened',
                'score': -result.loss,
                'error': 0.0,
                'gap_left': gap_left(Explanation(search.given).with_part(result.candidate, start)),
                'parameters': {},
            }
    return list(rows.values())


def as_compared(search: Search, best: ScoredFit) -> ScoredFit:
    """Return the best fit as it was compared with the others: since then its noise has changed."""
    own = search.causes(best.explanation)
    return next((fit for fit in search.ranking if search.causes(fit.explanation) == own), best)


def _error(fit: ScoredFit, best: ScoredFit) -> float:
    """Return the standard error of the difference from the best fit, 0 on other data."""
    return fit.difference(best)[1] if best.losses.size == fit.losses.size else 0.0


def _values(explanation: Explanation) -> dict[str, float]:
    """Return the fitted values by name."""
    return {
        part.name if part.is_parameter else f'{part.name}.{c.name}': value
        for part, fitted in zip(explanation.parts, explanation.values, strict=True)
        for c, value in zip(part.coordinates, fitted, strict=True)
    }


def indistinguishable(search: Search, best: ScoredFit | None) -> list[list[str]]:
    """Return the explanations of equal size that are as good as the best, that one first."""
    if best is None or not search.causes(best.explanation):
        return []
    size, compared = len(best.explanation.parts), as_compared(search, best)
    alike = (
        fit
        for fit in search.ranking
        if len(fit.explanation.parts) == size and fit.losses.size == compared.losses.size
        if as_good_as(fit, compared)
    )
    fits = first_of_each(search, [best, *alike]).values()
    names = ['+'.join(search.causes(fit.explanation)) for fit in fits]
    return [names] if len(names) > 1 else []


def rivals(search: Search) -> dict[str, Hypothesis]:
    """Return the best explanation and the next ones of the same size."""
    if search.best is None:
        return {}
    size = len(search.best.explanation.parts)
    fits = sorted(search.ranking, key=lambda fit: fit.cost)
    alike = first_of_each(search, (fit for fit in fits if len(fit.explanation.parts) == size))
    first = [fit.explanation for fit in alike.values()][:RIVALS]
    return {' + '.join(search.causes(each)): each.hypothesis for each in first}


def probabilities(
    search: Search, explanation: Explanation, named: bool, share: float
) -> dict[Names, float]:
    """
    Return the names of causes -> probability that they are what is missing [-].

    Those of one size that can be compared; what is left of 1 is for a cause that was not fitted.
    Of a verdict without a name they share what that leaves.

    :param named: whether the verdict names a cause
    :param share: probability of the verdict [-]
    """
    share = share if named else 1.0 - share
    fits = _comparable(search, explanation)
    found = weights([fit.losses for fit in fits.values()], [fit.penalty for fit in fits.values()])
    return dict(zip(fits, (share * found).tolist(), strict=True))


def _comparable(search: Search, explanation: Explanation) -> dict[Names, ScoredFit]:
    """Return the fits of as many causes as an explanation has, on the same data; or of one."""
    own = frozenset(search.causes(explanation))
    ranked = first_of_each(search, search.ranking).items()
    fits = {names: fit for names, fit in ranked if len(names) == max(len(own), 1)}
    if not fits:
        return {}
    size = fits.get(own, next(iter(fits.values()))).losses.size
    return {names: fit for names, fit in fits.items() if fit.losses.size == size}


def first_of_each(search: Search, fits: Iterable[ScoredFit]) -> dict[Names, ScoredFit]:
    """Return the names of causes, in whatever order they came -> the first fit of them."""
    found: dict[Names, ScoredFit] = {}
    for fit in fits:
        if names := frozenset(search.causes(fit.explanation)):
            found.setdefault(names, fit)
    return found


def weights(losses: Sequence[Floats], penalties: Sequence[float]) -> Floats:
    """Return the weight of each explanation [-], by its penalty and losses of n stretches."""
    if not losses:
        return np.zeros(0)
    table = np.array(losses)
    n = table.shape[1]
    shares = np.random.default_rng(SEED).dirichlet(np.ones(n), DRAWS)
    density = -n * shares @ table.T - np.array(penalties)
    mean: Floats = softmax(density, axis=1).mean(axis=0)
    return mean
