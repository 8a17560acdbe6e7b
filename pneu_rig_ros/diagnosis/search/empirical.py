"""
Empirical terms that describe what no cause explains: a formula, not a physical cause.

The terms are those of ``model.empirical``, selected by orthogonal matching pursuit (Y. C. Pati et
al., Asilomar Conf. Signals 1993) and fitted like any cause; their number minimises the excess on
held-out data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import lombscargle

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import (
    Candidate,
    Coordinate,
    Explanation,
    effect_candidate,
)
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import STOP_UNIT
from pneu_rig_ros.diagnosis.residuals.dataset import OUTLIER, Dataset, loss
from pneu_rig_ros.diagnosis.residuals.localisation import SignificantResidual
from pneu_rig_ros.diagnosis.residuals.windows import SLIDING, Windows, windows_of
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.executor import map_tasks
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES, Balance

MOST_TERMS = 4
"""Steps of the matching pursuit at most."""
STRENGTHS = (1.0, 4.0, 16.0)
"""Coefficients tried, relative to that whose change is as large as the residual [-]."""
AS_GOOD = 0.9
"""The smallest description is taken whose share, times this, does not exceed the least [-]."""
WAVE = ('sine', 'cosine')
"""Coefficients of one wave, whose phase is unknown."""
EXPLAINED = 0.02
"""Remaining share at which a description needs no further term [-]."""
SHORTEST = 4e-3
"""Shortest wavelength [m]: windows of 70 ms average over as much at 60 mm/s."""
GRID = 0.25
"""Of the number of waves in the covered positions, an oversampled grid [-]."""


@dataclass(frozen=True)
class Description:
    """
    Empirical terms in place of an unknown cause.

    :param balance, regime, unit: where the residual is most significant
    :param term: formula for a reader, '' where no simple term closes the gap
    :param gap_left: remaining share of the excess on held-out data [-]
    :param explanation: the fitted terms
    """

    balance: str
    regime: str
    unit: str
    term: str
    gap_left: float
    explanation: Explanation

    def to_dict(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        return {name: value for name, value in vars(self).items() if name != 'explanation'}


class Term(NamedTuple):
    """
    One coefficient of an empirical effect.

    :param constants: wavelength or time constant of the term, if it has one
    :param starts: value of that [SI]
    """

    effect: Candidate
    coordinate: Coordinate
    constants: tuple[Coordinate, ...] = ()
    starts: tuple[float, ...] = ()

    def apply(self, hypothesis: Hypothesis, value: float) -> Hypothesis:
        """Return the hypothesis with this term alone of its effect."""
        alone = only(self.effect, [self.coordinate, *self.constants])
        return alone.apply(hypothesis, [value, *self.starts])

    def joins(self, other: Term) -> bool:
        """Whether both may be in one description: of an effect, with one constant only."""
        return self.effect.name != other.effect.name or self.starts == other.starts


def only(effect: Candidate, coordinates: Sequence[Coordinate]) -> Candidate:
    """Return an effect with some of its coordinates, the others being zero."""
    return replace(effect, coordinates=tuple(coordinates), starts=())


def describe(search: Search, residual: SignificantResidual) -> Description:
    """Return the empirical terms that leave least of what the best explanation leaves."""
    given, training = search.hypothesis, search.training
    terms = terms_for(residual, search)
    target = training.residual(given)
    strongest = map_tasks(search.executor, strongest_change, terms, given, training, target)
    values = [value for value, _ in strongest]
    changes = np.column_stack([change for _, change in strongest])
    groups, selected = groups_of(terms), list[int]()
    descriptions = [(1.0, Explanation(given))]
    for _ in range(MOST_TERMS):
        joining = [g for g in groups if all(terms[g[0]].joins(terms[i]) for i in selected)]
        group = best_group(changes, target, joining, selected)
        if not group:
            break
        selected += group
        start = regression(given, terms, values, changes, selected, target)
        found = fit(start, training, ROUNDS)
        share = search.left_by(found)
        descriptions.append((share, found.explanation))
        if share < EXPLAINED:
            break
    least = min(share for share, _ in descriptions)
    enough = max(least / AS_GOOD, EXPLAINED)
    share, best = next(pair for pair in descriptions if pair[0] <= enough)
    place = residual.balance, residual.regime, residual.unit
    return Description(*place, formula(best), share, best)


def terms_for(residual: SignificantResidual, search: Search) -> list[Term]:
    """Return the terms that act on the balance of a residual, or on the sensors."""
    used = {part.name for part in search.best.explanation.parts} if search.best else set()
    fixed = search.training.comparisons[0].run.noise.position <= 0.0
    terms = []
    for name in library.names():
        effect = library.load(name)
        acts = _acts(effect.balance, residual)
        acts &= not (fixed and effect.balance is Balance.MOTION_READING)
        if effect.describes and acts and name not in used:
            terms += _terms_of(effect_candidate(name), search)
    return terms


def _acts(balance: Balance, residual: SignificantResidual) -> bool:
    """Return whether effects on a balance, or on the sensors, change a residual."""
    if residual.unit == STOP_UNIT:  # no force moves a stop
        return balance is Balance.MOTION_READING
    on_gas = balance in GAS_BALANCES
    return balance in READING_BALANCES or on_gas == residual.balance.startswith('gas')


def _terms_of(effect: Candidate, search: Search) -> list[Term]:
    """Return the terms of an effect, for each value from which a fit of its constant starts."""
    linear = effect.strengths
    constants = tuple(c for c in effect.coordinates if c not in linear)
    if not constants:
        return [Term(effect, coordinate) for coordinate in linear]
    (constant,) = constants
    place = effect.coordinates.index(constant)
    starts = sorted({start[place] for start in effect.starts})
    if constant.quantity.unit == 'm':
        starts = dominant_wavelengths(windows_of(search.training, search.hypothesis))
    return [Term(effect, c, constants, (float(start),)) for start in starts for c in linear]


def dominant_wavelengths(groups: Sequence[Windows]) -> list[float]:
    """
    Return the wavelength that explains most of the force while the piston slides [m].

    By a periodogram of the residuals, weighted by their noise (M. Zechmeister, M. Kuerster,
    Astron. Astrophys. 496 (2009) 577); none where the windows cover less than two waves.
    """
    columns = [
        np.column_stack([group.variables['position'], group.residual, group.deviation])[
            group.regime == SLIDING
        ]
        for group in groups
        if group.balance == 'force'
    ]
    position, residual, deviation = np.concatenate([*columns, np.zeros((0, 3))]).T
    span = float(np.ptp(position)) if position.size else 0.0
    if span < 2.0 * SHORTEST:
        return []
    waves = np.arange(1.0, span / SHORTEST, GRID) / span
    angular = 2.0 * np.pi * waves
    weights = deviation**-2
    power = lombscargle(position, residual, angular, weights=weights, floating_mean=True)
    return [1.0 / float(waves[np.argmax(power)])]


def groups_of(terms: Sequence[Term]) -> list[list[int]]:
    """Return the terms in groups: one term of both chambers, or sine and cosine, is a group."""
    groups: dict[tuple[str, str, tuple[float, ...]], list[int]] = {}
    for index, term in enumerate(terms):
        name = 'wave' if term.coordinate.name in WAVE else term.coordinate.name
        either = min(name, name.translate(str.maketrans('12', '21')))
        groups.setdefault((term.effect.name, either, term.starts), []).append(index)
    return list(groups.values())


def strongest_change(
    term: Term, given: Hypothesis, dataset: Dataset, residual: Floats
) -> tuple[float, Floats]:
    """
    Return the coefficient [SI] with which a term explains most, and its change of the residual.

    A strong term is no multiple of a weak one where it changes what it depends on, as heat does
    the temperature.
    """

    def change(value: float) -> Floats:
        return dataset.residual(term.apply(given, value)) - residual

    size = term.coordinate.scale
    results = [(size, change(size))]
    matching = size * float(np.sqrt(loss(residual) / max(loss(results[0][1]), 1e-9)))
    for strength in STRENGTHS[:1] if term.constants else STRENGTHS:
        value = min(strength * matching, term.coordinate.high)
        results.append((value, change(value)))
    weights = robust_weights(residual)
    target = -residual * weights
    return max(results, key=lambda pair: projection((pair[1] * weights)[:, np.newaxis], target))


def robust_weights(residual: Floats) -> Floats:
    """Return the weights of the residuals in a robust linear regression [-], shape (n,)."""
    return 1.0 / np.sqrt(1.0 + (residual / OUTLIER) ** 2)


def projection(columns: Floats, target: Floats) -> float:
    """Return the norm of the projection of a target on the span of columns, shape (n, k) [-]."""
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    kept = sizes > 1e-6 * max(sizes[0], 1e-9)
    return float(np.linalg.norm(directions[:, kept].T @ target))


def best_group(
    changes: Floats, residual: Floats, groups: Sequence[Sequence[int]], selected: Sequence[int]
) -> list[int]:
    """Return the group of terms that explains most of what the selected leave, or none."""
    weights = robust_weights(residual)
    scaled, target = changes * weights[:, np.newaxis], -residual * weights
    if selected:
        basis, _ = np.linalg.qr(scaled[:, list(selected)])
        scaled = scaled - basis @ (basis.T @ scaled)
        target = target - basis @ (basis.T @ target)
    independent = np.linalg.norm(scaled, axis=0) > 1e-6 * np.linalg.norm(changes, axis=0)
    independent[list(selected)] = False
    left = [[index for index in group if independent[index]] for group in groups]
    return max(filter(None, left), key=lambda g: projection(scaled[:, g], target), default=[])


def regression(
    given: Hypothesis,
    terms: Sequence[Term],
    values: Sequence[float],
    changes: Floats,
    selected: Sequence[int],
    residual: Floats,
) -> Explanation:
    """Return selected terms with coefficients by robust linear regression, within their ranges."""
    weights = robust_weights(residual)
    matrix = changes[:, list(selected)] * weights[:, np.newaxis]
    shares, *_ = np.linalg.lstsq(matrix, -residual * weights, rcond=None)
    parts: dict[str, tuple[Candidate, list[Coordinate], list[float]]] = {}
    for index, share in zip(selected, shares, strict=True):
        effect, c, constants, starts = terms[index]
        value = float(np.clip(share * values[index], c.low, c.high))
        new = effect, [*constants], [*starts]
        _, coordinates, coefficients = parts.setdefault(effect.name, new)
        coordinates.append(replace(c, scale=max(abs(value), 1e-3 * c.scale)))
        coefficients.append(value)
    explanation = Explanation(given)
    for effect, coordinates, coefficients in parts.values():
        explanation = explanation.with_part(only(effect, coordinates), coefficients)
    return explanation


def formula(explanation: Explanation) -> str:
    """Return the terms for a reader, '' for none."""
    texts = []
    for part, values in explanation.by_part:
        terms = ' '.join(
            f'{value:+.3g} {c.quantity.unit} {c.name}'
            for c, value in zip(part.coordinates, values, strict=True)
        )
        texts.append(f'{part.name}: {terms.removeprefix("+")}')
    return '; '.join(texts)
