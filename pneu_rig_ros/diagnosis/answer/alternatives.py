"""The ranking of the candidates, and the explanations that compete with the best one."""

from typing import Any

from pneu_rig_ros.diagnosis.answer.probability import first_of_each, of_names
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.search.scoring import ScoredFit, as_good_as, excess
from pneu_rig_ros.diagnosis.search.selection import Search

MOST_ROWS = 20
"""Length of the ranking at most."""
RIVALS = 3
"""Explanations that the next experiment is to separate."""


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
    likely = of_names(search, explanation, named, probability)
    residuals = search.held_out.without_cycles
    before = excess(residuals, search.given)

    def gap_left(explanation: Explanation) -> float | None:
        if before == 0.0:
            return None
        return min(excess(residuals, explanation.hypothesis) / before, 1.0)

    compared = None if best is None else as_compared(search, best)
    ranking = sorted(search.ranking, key=lambda fit: fit.cost)
    fits = first_of_each(search, ranking if best is None else [best, *ranking])
    rows: dict[frozenset[str], dict[str, Any]] = {}
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
    size, own = len(best.explanation.parts), search.causes(best.explanation)
    equivalent = {frozenset(own): own}
    best = as_compared(search, best)
    for fit in search.ranking:
        causes = search.causes(fit.explanation)
        same = len(fit.explanation.parts) == size and fit.losses.size == best.losses.size
        if same and causes and as_good_as(fit, best):
            equivalent.setdefault(frozenset(causes), causes)
    return [['+'.join(causes) for causes in equivalent.values()]] if len(equivalent) > 1 else []


def rivals(search: Search) -> dict[str, Hypothesis]:
    """Return the best explanation and the next ones of the same size."""
    if search.best is None:
        return {}
    size = len(search.best.explanation.parts)
    fits = sorted(search.ranking, key=lambda fit: fit.cost)
    alike = first_of_each(search, (fit for fit in fits if len(fit.explanation.parts) == size))
    first = [fit.explanation for fit in alike.values()][:RIVALS]
    return {' + '.join(search.causes(each)): each.hypothesis for each in first}
