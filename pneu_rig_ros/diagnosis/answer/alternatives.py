"""The ranking of the candidates, and the explanations that compete with the best one."""

from __future__ import annotations

from typing import Any

from pneu_rig_ros.diagnosis.answer import probability
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.search.scoring import ScoredFit, as_good_as, excess
from pneu_rig_ros.diagnosis.search.selection import Search

MOST_ROWS = 20
"""Length of the ranking at most."""
RIVALS = 3
"""Explanations that the next experiment is to separate."""


def ranking_rows(search: Search, best: ScoredFit | None, verdict: str) -> list[dict[str, Any]]:
    """
    Return the candidates of diagnosis.json: the answer, other fitted ones, screened ones.

    :param best: the fit of the answer, None where nothing is missing
    :param verdict: of the answer, which may be none of the causes
    """
    rows: dict[frozenset[str], dict[str, Any]] = {}  # whatever the order in which causes came
    explanation = Explanation() if best is None else best.explanation
    likely = probability.of_names(search, explanation, verdict)
    residuals = search.held_out.without_cycles
    before = excess(residuals, search.given)

    def gap_left(explanation: Explanation) -> float:
        after = excess(residuals, explanation.apply(search.given))
        return min(after / before, 1.0) if before > 0.0 else 0.0

    fits = sorted(search.ranking, key=lambda fit: fit.cost)
    if best is not None and search.causes(best.explanation):
        fits = [best, *fits]
    for fit in fits:
        names = search.causes(fit.explanation)
        if not names or frozenset(names) in rows or len(rows) == MOST_ROWS:
            continue
        parts = zip(fit.explanation.parts, fit.explanation.values, strict=True)
        values = {
            part.name if part.is_parameter else f'{part.name}.{c.name}': value
            for part, fitted in parts
            for c, value in zip(part.coordinates, fitted, strict=True)
        }
        comparable = search.best is not None and search.best.losses.size == fit.losses.size
        rows[frozenset(names)] = {
            'names': names,
            'chosen': fit is best and verdict != 'unknown',
            'probability': likely.get(frozenset(names)),
            'stage': 'simulation' if fit.simulated else 'regression',
            'score': -fit.cost,
            'error': fit.difference(search.best)[1] if search.best and comparable else 0.0,
            'gap_left': gap_left(fit.explanation),
            'parameters': values,
        }
    for result in search.screened[: MOST_ROWS - len(rows)]:
        name = result.candidate.name
        if frozenset({name}) not in rows:
            alone = Explanation().with_part(result.candidate, result.values)
            rows[frozenset({name})] = {
                'names': [name],
                'chosen': False,
                'probability': None,
                'stage': 'screened',
                'score': -result.loss,
                'error': 0.0,
                'gap_left': gap_left(alone),
                'parameters': {},
            }
    return list(rows.values())


def indistinguishable(search: Search, best: ScoredFit | None) -> list[list[str]]:
    """Return the explanations of equal size that are as good as the best, that one first."""
    if best is None or not search.causes(best.explanation):
        return []
    size, own = len(best.explanation.parts), search.causes(best.explanation)
    equivalent = {frozenset(own): own}
    # as it was compared with the others: since then the noise has been estimated again
    best = next((fit for fit in search.ranking if search.causes(fit.explanation) == own), best)
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
    found: dict[frozenset[str], Explanation] = {}
    for fit in sorted(search.ranking, key=lambda fit: fit.cost):
        causes = search.causes(fit.explanation)
        if len(fit.explanation.parts) == size and causes:
            found.setdefault(frozenset(causes), fit.explanation)
    first = list(found.values())[:RIVALS]
    return {' + '.join(search.causes(each)): each.apply(search.given) for each in first}
