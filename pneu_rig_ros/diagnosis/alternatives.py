"""The ranking of candidates as plain data, and the explanations as likely as the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.fitting import Screened
from pneu_rig_ros.diagnosis.scoring import ScoredFit, as_good_as, remaining_share
from pneu_rig_ros.diagnosis.selection import Search
from pneu_rig_ros.diagnosis.workflow import Diagnosis

MOST = 20
"""Length of the ranking at most."""


def candidates(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return the candidates as plain data: the answer, other fitted ones, those screened."""
    search, best = diagnosis.search, diagnosis.best
    rows: dict[tuple[str, ...], dict[str, Any]] = {}
    fitted = sorted(search.ranking, key=lambda one: one.total)
    if best is not None and search.causes(best.explanation):
        fitted = [best, *fitted]
    for one in fitted:
        names = tuple(search.causes(one.explanation))
        if names and names not in rows and len(rows) < MOST:
            rows[names] = _fitted(one, search, one is best and diagnosis.unknown is None)
    for tried in search.screened[: MOST - len(rows)]:
        rows.setdefault((tried.candidate.name,), _screened(tried, search))
    return list(rows.values())


def _fitted(one: ScoredFit, search: Search, chosen: bool) -> dict[str, Any]:
    parts = zip(one.explanation.parts, one.explanation.values, strict=True)
    values = {
        part.name if part.is_parameter else f'{part.name}.{c.name}': value
        for part, fitted in parts
        for c, value in zip(part.coordinates, fitted, strict=True)
    }
    best = search.best
    same = best is not None and best.losses.size == one.losses.size
    error = one.behind(best)[1] if same and best is not None else 0.0
    return {'names': search.causes(one.explanation), 'chosen': chosen,
            'stage': 'simulation' if one.simulated else 'regression', 'score': -one.total,
            'error': error, 'gap_left': gap_left(one.explanation, search),
            'parameters': values}  # fmt: skip


def _screened(tried: Screened, search: Search) -> dict[str, Any]:
    alone = Explanation().with_part(tried.candidate, tried.values)
    return {'names': [tried.candidate.name], 'chosen': False, 'stage': 'screened',
            'score': -tried.loss, 'error': 0.0, 'gap_left': gap_left(alone, search),
            'parameters': {}}  # fmt: skip


def gap_left(explanation: Explanation, search: Search) -> float:
    """Return the share of the held-out excess over the noise that remains, at most 1 [-]."""
    residuals = replace(search.held, cycles=None)
    return min(remaining_share(residuals, search.given, explanation.apply(search.given)), 1.0)


def indistinguishable(diagnosis: Diagnosis) -> list[list[str]]:
    """Return the explanations of equal size that are as likely as the best, that one first."""
    search, best = diagnosis.search, diagnosis.best
    if best is None or not search.causes(best.explanation):
        return []
    size = len(best.explanation.parts)
    alike = {joined(search.causes(best.explanation)): None}
    for one in search.ranking:
        same = len(one.explanation.parts) == size and one.losses.size == best.losses.size
        if same and search.causes(one.explanation) and as_good_as(one, best):
            alike[joined(search.causes(one.explanation))] = None
    return [list(alike)] if len(alike) > 1 else []


def joined(names: Sequence[str]) -> str:
    """Return the names of an explanation as one."""
    return '+'.join(names)
