"""
What nobody has named yet: a sparse term that describes the gap, and can be added and simulated.

The terms are those of the ``described_...`` effects. Which of them are needed is proposed by
sparse regression (pysindy) of the residual of the balance, or of the gap of the pressures for
errors of the sensors, and by trying each one: what holds the piston back at rest shows in no
residual. Their coefficients are then fitted by simulation like those of any effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.gap.candidates import effect_candidate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.fitting import Explanation
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, block_means
from pneu_rig_ros.gap.scoring import Scored, Setting, fit_from
from pneu_rig_ros.gap.screening import costs_of
from pneu_rig_ros.gap.shrink import above_floor
from pneu_rig_ros.gap.where import disagreements, residuals
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.compiled import plain
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.effect import READING_BALANCES, Signals

Floats = NDArray[np.float64]

DESCRIPTIONS = {
    Mode.CHAMBERS: (
        'described_flow',
        'described_motion_reading',
        'described_pressure_reading',
    ),
    Mode.CYCLES: ('described_friction', 'described_force'),
}
"""Prediction whose gap is described -> effects that may describe it."""
MOST_TERMS = 3
"""Terms of a description at most."""
LEAST_GAIN = 0.9
"""More terms that leave more than this share of the cost are left out [-]."""
STRENGTHS = tuple(0.05 * 2.0**i for i in range(10))
"""Multiples of a term's usual size that are tried, of either sign [-]."""
TRIED = 3
"""Terms of those tried that are fitted."""
ROUNDS = 8


@dataclass(frozen=True)
class Description:
    """
    A description of what is not known.

    :param balance, regime, unit: where it shows
    :param term: formula for a person, '' where no simple term shrinks the gap
    :param gap_left: share of the cost above the floor that is left on runs not fitted [-]
    :param hypothesis: with the description as an effect
    :param explanation: what was fitted
    """

    balance: str
    regime: str
    unit: str
    term: str
    gap_left: float
    hypothesis: Hypothesis
    explanation: Explanation

    def to_dict(self) -> dict[str, Any]:
        """Return what diagnosis.json says of it."""
        return {'balance': self.balance, 'regime': self.regime, 'unit': self.unit,
                'term': self.term, 'gap_left': self.gap_left}  # fmt: skip


def describe(
    known: Hypothesis, fitted: Evidence, held: Evidence, mode: Mode, at_floor: float, limit: float,
    executor: Executor,
) -> Description:  # fmt: skip
    """
    Return the description that shrinks the gap of a prediction most.

    The sensors are blamed only where their errors leave nothing significant: a share of any gap
    can be put on them. One that shrinks nothing on runs not fitted is left out.

    :param at_floor: cost of a true hypothesis [-]
    :param limit: cost below which nothing significant is left [-]
    """
    setting = Setting(known, fitted, held, (mode,))
    tried = [one for name in DESCRIPTIONS[mode] for one in growing(setting, name, executor)]
    tried = [one for one in tried if not _of_sensors(one) or one.worst < limit]
    before = held.cost(known, (mode,)) - at_floor
    best = next(shrinking(tried, setting), None)
    where = _place(best or sparsest(tried), known, fitted, mode)
    if best is None:
        return Description(*where, '', 1.0, known, Explanation())
    explanation, after = best.fit.explanation, best.held_out - at_floor
    left = max(after, 0.0) / max(before, 1e-9)
    return Description(*where, formula(explanation), left, explanation.apply(known), explanation)


def shrinking(tried: Sequence[Scored], setting: Setting) -> Iterator[Scored]:
    """Yield those that make the gap smaller on runs not fitted, the one to be preferred first."""
    left = list(tried)
    while left:
        one = sparsest(left)
        before, after = above_floor(
            setting.given, one.fit.explanation.apply(setting.given), setting.held
        )
        if after < before:
            yield one
        left.remove(one)


def sparsest(tried: Sequence[Scored]) -> Scored:
    """Return the one of the fewest terms that leaves hardly more than the best."""
    least = min(one.worst for one in tried)
    good = [one for one in tried if LEAST_GAIN * one.worst <= least]
    return min(good, key=lambda one: (len(one.fit.explanation.coordinates), one.worst))


def _place(best: Scored, known: Hypothesis, fitted: Evidence, mode: Mode) -> tuple[str, str, str]:
    """Return the balance that a description acts on, the regime where it shows, and the unit."""
    where = [one for one in disagreements(known, fitted) if _shows(one.balance, mode)]
    regime = where[0].regime if where else 'sliding'
    if _of_sensors(best):
        part = best.fit.explanation.parts[0]
        return part.balance, regime, part.coordinates[0].quantity.unit
    if where:
        return where[0].balance, regime, where[0].unit
    return _default(mode)


def _of_sensors(one: Scored) -> bool:
    """Return whether a description is of errors of the sensors."""
    return library.load(one.fit.explanation.parts[0].name).balance in READING_BALANCES


def _shows(balance: str, mode: Mode) -> bool:
    return balance.startswith('gas') == (mode is Mode.CHAMBERS)


def _default(mode: Mode) -> tuple[str, str, str]:
    if mode is Mode.CHAMBERS:
        return 'gas mass 1', 'sliding out', 'kg/s'
    return 'force', 'breakaway', 'N'


def growing(setting: Setting, name: str, executor: Executor) -> Iterator[Scored]:
    """Yield the best fits of a description with one term, with two, and so on."""
    matrix, target = regression(setting.given, setting.fitted, name)
    chosen: dict[str, float] = {}
    for count in range(1, min(MOST_TERMS, matrix.shape[1]) + 1):
        found = [sparse_terms(matrix, target, name, count)]
        found += one_more(name, chosen, setting, executor)
        starts = [explained(name, terms) for terms in found if terms]
        fits = map_tasks(executor, fit_from, starts, setting, ROUNDS)
        best = min(fits, key=lambda one: one.fit.cost)
        chosen = terms_of(best.fit.explanation)
        yield best


def one_more(
    name: str, chosen: Mapping[str, float], setting: Setting, executor: Executor
) -> list[dict[str, float]]:
    """Return some terms with the one more that leaves least, and those that come next."""
    others = [term for term in _sizes(name) if term not in chosen]
    tried = map_tasks(executor, strengths_of, others, name, chosen, setting)
    ranked = sorted(tried, key=lambda one: one[0])
    return [{**chosen, term: value} for _, term, value in ranked[:TRIED]]


def strengths_of(
    term: str, name: str, chosen: Mapping[str, float], setting: Setting
) -> tuple[float, str, float]:
    """Return the least cost over the coefficients of one more term, the term, and that one."""
    size = _sizes(name)[term]
    values = [sign * factor * size for factor in STRENGTHS for sign in (1.0, -1.0)]
    every = [explained(name, {**chosen, term: value}) for value in values]
    costs = costs_of(every, setting.given, setting.fitted, setting.modes)
    index = int(np.argmin(costs))
    return costs[index], term, values[index]


def _sizes(name: str) -> dict[str, float]:
    """Return the terms of a description -> a usual size of their coefficients [SI]."""
    part = effect_candidate(name)
    return {c.name: c.scale for c in part.coordinates}


def explained(name: str, terms: Mapping[str, float]) -> Explanation:
    """Return a description with some terms, coefficients in SI and in range; the others are 0."""
    whole = effect_candidate(name)
    kept = tuple(c for c in whole.coordinates if c.name in terms)
    values = tuple(min(max(terms[c.name], c.low), c.high) for c in kept)
    return Explanation().plus(replace(whole, coordinates=kept, starts=()), values)


def terms_of(explanation: Explanation) -> dict[str, float]:
    """Return the terms of a description -> their coefficients [SI]."""
    names = [c.name for c in explanation.coordinates]
    return dict(zip(names, explanation.values[0], strict=True))


def regression(known: Hypothesis, evidence: Evidence, name: str) -> tuple[Floats, Floats]:
    """Return the terms of a description and the residual that they are to explain, stacked."""
    if library.load(name).balance in READING_BALANCES:
        return sensitivity(known, evidence, name)
    columns, targets = [], []
    floors = evidence.floors[Mode.CHAMBERS]
    for experiment, floor in zip(evidence.experiments, floors, strict=True):
        tables = term_values(known, experiment, name)
        concerned = _concerned(residuals(known, experiment, floor), name)
        for residual, table in zip(concerned, tables, strict=True):
            good = np.isfinite(residual.values)
            columns.append(table[good])
            targets.append(residual.values[good])
    return np.concatenate(columns), np.concatenate(targets)


def sensitivity(known: Hypothesis, evidence: Evidence, name: str) -> tuple[Floats, Floats]:
    """Return what each coefficient takes off the gap of the pressures, and the gap, in floors."""
    part, mode = effect_candidate(name), Mode.CHAMBERS
    gap = np.concatenate(evidence.gaps(known, mode)).ravel()
    columns = []
    for values in np.diag(part.starts[0]):
        moved = np.concatenate(evidence.gaps(part.apply(known, tuple(values)), mode)).ravel()
        columns.append((gap - moved) / values.sum())
    return np.column_stack(columns), gap


def sparse_terms(matrix: Floats, target: Floats, name: str, count: int) -> dict[str, float]:
    """
    Return the coefficients of a description with so many terms [SI].

    The terms are chosen one after the other by forward regression with orthogonal least squares.
    """
    try:
        from pysindy import FROLS
    except ImportError:
        raise RigError(
            'pysindy is needed to describe what is not known: pip install pneu_rig_ros[diagnosis]'
        ) from None

    names = list(library.load(name).parameters._fields)
    known = np.flatnonzero(np.any(matrix != 0.0, axis=0))
    size = np.sqrt(np.mean(matrix[:, known] ** 2, axis=0))
    optimizer = FROLS(max_iter=count, alpha=1e-6)
    try:
        optimizer.fit(matrix[:, known] / size, target[:, np.newaxis])
    except ValueError:  # all that are left depend on those chosen
        return sparse_terms(matrix, target, name, count - 1) if count > 1 else {}
    order = np.argsort(-np.abs(np.ravel(optimizer.coef_)))[:count]
    chosen = known[order]
    values, *_ = np.linalg.lstsq(matrix[:, chosen], target, rcond=None)
    return {names[int(i)]: float(value) for i, value in zip(chosen, values, strict=True)}


def _concerned(every: Sequence[Any], name: str) -> Sequence[Any]:
    return every[:2] if name == 'described_flow' else every[2:]


def term_values(known: Hypothesis, experiment: Experiment, name: str) -> list[Floats]:
    """
    Return what each coefficient of a description multiplies, block by block.

    The contribution is linear in its coefficients, so that it gives the terms one by one.

    :return: one table, shape (blocks, coefficients), for each residual concerned
    """
    effect = library.load(name)
    signals = _signals(experiment)
    gas = known.model.gas._replace(atmospheric_pressure=experiment.atmospheric_pressure)
    model = known.model._replace(operation=experiment.operation, gas=gas)
    signs = {'described_friction': np.sign(signals.velocity), 'described_force': -1.0}
    sign = signs.get(name, 1.0)
    term = plain(effect.contribution)
    tables: tuple[list[Floats], list[Floats]] = [], []
    for unit in np.eye(len(effect.null)):
        pair = term(signals, compiled_model(model), effect.parameters(*unit), None, None)
        for table, value in zip(tables, pair, strict=True):
            table.append(np.broadcast_to(sign * value, signals.velocity.shape))
    concerned = tables if name == 'described_flow' else tables[:1]
    return [np.column_stack(table) for table in concerned]


def _signals(experiment: Experiment) -> Any:
    """Return the measured signals block by block, as a contribution takes them."""
    x, v, p1, p2 = block_means(experiment.measured[1:], experiment.block).T
    u1, u2 = block_means(experiment.voltages, experiment.block).T
    supply: Any = np.full(x.size, experiment.operation.supply_pressure)
    unseen: Any = np.full(x.size, np.nan)
    return Signals(unseen, x, v, p1, p2, unseen, unseen, unseen, unseen, u1, u2, supply, supply,
                   unseen, unseen, unseen, unseen, unseen, unseen)  # fmt: skip


def formula(explanation: Explanation) -> str:
    """Return a description's formula for a person."""
    pairs = zip(explanation.coordinates, explanation.values[0], strict=True)
    texts = [f'{value:+.3g} {c.quantity.unit} {c.name}' for c, value in pairs]
    return ' '.join(texts).removeprefix('+')
