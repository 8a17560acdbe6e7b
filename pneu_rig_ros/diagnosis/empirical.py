"""
What nobody has named: a formula of a few empirical terms that describes what remains.

It says where the disagreement is and what would close it, not why. The terms are those of
``model.empirical``, chosen one after the other by orthogonal matching pursuit (Y. C. Pati et al.,
Asilomar Conf. Signals 1993) and then fitted like any cause; as many as the runs left out ask for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.candidates import Candidate, Coordinate, effect_candidate
from pneu_rig_ros.diagnosis.dataset import OUTLIER, Dataset, loss
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.fitting import fit
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.localisation import SignificantResidual
from pneu_rig_ros.diagnosis.scoring import remaining_share
from pneu_rig_ros.diagnosis.selection import ROUNDS, Search
from pneu_rig_ros.executor import map_tasks
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES

Floats = NDArray[np.float64]

MOST_TERMS = 4
"""Terms of a description at most."""
STRENGTHS = (1.0, 4.0, 16.0)
"""Coefficients tried, in units of the one that changes as much as is to be explained [-]."""
LEAST_GAIN = 0.9
"""What leaves up to so much more than the best description is as good, with fewer terms [-]."""
CLOSES = 0.02
"""Share of the gap that is as good as none [-]."""


@dataclass(frozen=True)
class Description:
    """
    A description of what is not known.

    :param balance, regime, unit: where it shows most
    :param term: formula for a person, '' where no simple term closes the gap
    :param gap_left: share of what exceeds the noise that is left on runs not fitted [-]
    :param explanation: what was fitted
    """

    balance: str
    regime: str
    unit: str
    term: str
    gap_left: float
    explanation: Explanation

    def to_dict(self) -> dict[str, Any]:
        """Return what diagnosis.json says of it."""
        return {'balance': self.balance, 'regime': self.regime, 'unit': self.unit,
                'term': self.term, 'gap_left': self.gap_left}  # fmt: skip


class Term(NamedTuple):
    """One coefficient of an empirical effect."""

    effect: Candidate
    coordinate: Coordinate


def describe(search: Search, place: SignificantResidual) -> Description:
    """
    Return the description that closes most of what the best explanation leaves.

    :param place: where that shows most
    """
    known = search.hypothesis
    terms = terms_for(place.balance, search)
    here = search.fitted.residual(known)
    tried_out = map_tasks(search.executor, try_out, terms, known, search.fitted, here)
    sizes, columns = (list(each) for each in zip(*tried_out, strict=True))
    groups, chosen = alike(terms), list[int]()
    tried: list[tuple[float, Explanation]] = [(1.0, Explanation())]
    for _ in range(MOST_TERMS):
        more = next_terms(np.column_stack(columns), here, groups, chosen)
        if not more:
            break
        chosen += more
        start = explained(terms, sizes, columns, chosen, here)
        found = fit(start, known, search.fitted, ROUNDS).explanation
        tried.append((remaining_share(search.held, known, found.apply(known)), found))
        if tried[-1][0] < CLOSES:
            break
    least = min(left for left, _ in tried)
    left, best = next(one for one in tried if one[0] <= max(least / LEAST_GAIN, CLOSES))
    return Description(place.balance, place.regime, place.unit, formula(best), left, best)


def alike(terms: Sequence[Term]) -> list[list[int]]:
    """Return terms in groups: those of both chambers, which are alike, are one."""
    groups: dict[tuple[str, str], list[int]] = {}
    for index, term in enumerate(terms):
        name = term.coordinate.name
        same = min(name, name.translate(str.maketrans('12', '21')))
        groups.setdefault((term.effect.name, same), []).append(index)
    return list(groups.values())


def terms_for(balance: str, search: Search) -> list[Term]:
    """Return the terms that act on a balance, or on the sensors."""
    used = {part.name for part in search.best.explanation.parts} if search.best else set()
    terms = []
    for name in library.names():
        effect = library.load(name)
        of_gas = effect.balance in GAS_BALANCES
        concerned = effect.balance in READING_BALANCES or of_gas == balance.startswith('gas')
        if effect.describes and concerned and name not in used:
            candidate = effect_candidate(name)
            terms += [Term(candidate, coordinate) for coordinate in candidate.coordinates]
    return terms


def size_of(term: Term) -> float:
    """Return a usual size of a coefficient [SI]."""
    index = term.effect.coordinates.index(term.coordinate)
    return max(abs(start[index]) for start in term.effect.starts)


def try_out(term: Term, known: Hypothesis, dataset: Dataset, here: Floats) -> tuple[float, Floats]:
    """
    Return a coefficient of a term [SI], and how the residual changes with it, shape (n,).

    Where a term changes what it depends on, as heat does the temperature, a weak one does not tell
    what a strong one does: the one that explains most is returned.
    """
    size = size_of(term)
    change = _change(term, size, known, dataset, here)
    matching = size * float(np.sqrt(loss(here) / max(loss(change), 1e-9)))
    tried = [(size, change)]
    for times in STRENGTHS:
        larger = min(times * matching, term.coordinate.high)
        tried.append((larger, _change(term, larger, known, dataset, here)))
    weights = _weights(here)
    return max(tried, key=lambda one: _projection(
        (one[1] * weights)[:, np.newaxis], -here * weights))  # fmt: skip


def _weights(here: Floats) -> Floats:
    """Return how much residuals count in a robust regression [-]."""
    weights: Floats = 1.0 / np.sqrt(1.0 + (here / OUTLIER) ** 2)
    return weights


def _change(term: Term, size: float, known: Hypothesis, dataset: Dataset, here: Floats) -> Floats:
    part = replace(term.effect, coordinates=(term.coordinate,), starts=())
    changed: Floats = dataset.residual(part.apply(known, (size,))) - here
    return changed


def next_terms(
    columns: Floats, here: Floats, groups: Sequence[Sequence[int]], chosen: Sequence[int]
) -> list[int]:
    """Return the group of terms that explains most of what the chosen ones leave, or none."""
    weights = _weights(here)
    scaled, target = columns * weights[:, np.newaxis], -here * weights
    if chosen:
        basis, _ = np.linalg.qr(scaled[:, list(chosen)])
        scaled = scaled - basis @ (basis.T @ scaled)
        target = target - basis @ (basis.T @ target)
    fresh = np.linalg.norm(scaled, axis=0) > 1e-6 * np.linalg.norm(columns, axis=0)
    fresh[list(chosen)] = False
    open_groups = [kept for group in groups if (kept := [one for one in group if fresh[one]])]
    return max(open_groups, key=lambda group: _projection(scaled[:, group], target), default=[])


def _projection(columns: Floats, target: Floats) -> float:
    """Return the norm of a target's projection on the span of columns, shape (n, k) [-]."""
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    kept = sizes > 1e-6 * max(sizes[0], 1e-9)
    return float(np.linalg.norm(directions[:, kept].T @ target))


def explained(
    terms: Sequence[Term], sizes: Sequence[float], columns: Sequence[Floats],
    chosen: Sequence[int], here: Floats,
) -> Explanation:  # fmt: skip
    """Return chosen terms with coefficients by robust linear regression, within their ranges."""
    matrix = np.column_stack([columns[index] for index in chosen])
    weights = _weights(here)
    shares, *_ = np.linalg.lstsq(matrix * weights[:, np.newaxis], -here * weights, rcond=None)
    parts: dict[str, list[tuple[Coordinate, float]]] = {}
    candidates = {terms[index].effect.name: terms[index].effect for index in chosen}
    for index, share in zip(chosen, shares, strict=True):
        term = terms[index]
        value = float(np.clip(share * sizes[index], term.coordinate.low, term.coordinate.high))
        parts.setdefault(term.effect.name, []).append((term.coordinate, value))
    explanation = Explanation()
    for name, pairs in parts.items():
        coordinates = tuple(replace(c, scale=max(abs(v), 1e-3 * c.scale)) for c, v in pairs)
        part = replace(candidates[name], coordinates=coordinates, starts=())
        explanation = explanation.with_part(part, [value for _, value in pairs])
    return explanation


def formula(explanation: Explanation) -> str:
    """Return a description's terms for a person, '' for none."""
    texts = []
    for part, values in zip(explanation.parts, explanation.values, strict=True):
        terms = [f'{value:+.3g} {c.quantity.unit} {c.name}'
                 for c, value in zip(part.coordinates, values, strict=True)]  # fmt: skip
        texts.append(f'{part.name}: {" ".join(terms).removeprefix("+")}')
    return '; '.join(texts)
