"""
Terms that may describe a gap nobody has named: which of them are needed, and how much of each.

The terms are those of the ``described_...`` effects. Some are proposed by sparse regression
(pysindy) of the residual of the balance, or of the gap of the pressures for errors of the sensors;
the others by trying each one, as what holds the piston back at rest shows in no residual, nor
does what has a memory. Their coefficients are then fitted by simulation like those of any effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
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
from pneu_rig_ros.gap.scoring import Scored, Setting, cost_of, fit_from
from pneu_rig_ros.gap.screening import costs_of
from pneu_rig_ros.gap.where import residuals
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.compiled import plain
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.effect import READING_BALANCES, Signals

Floats = NDArray[np.float64]
Terms = Mapping[str, float]
"""Terms of a description -> their coefficients [SI]."""

DESCRIPTIONS = {
    Mode.CHAMBERS: (
        'described_flow',
        'described_heat',
        'described_voltage',
        'described_motion_reading',
        'described_pressure_reading',
    ),
    Mode.CYCLES: ('described_friction', 'described_force'),
}
"""Prediction whose gap is described -> effects that may describe it."""
TRIED_ONLY = ('described_heat', 'described_voltage')
"""Of those, the ones that no residual has the unit of."""
MOST_TERMS = 3
"""Terms of a description at most."""
STRENGTHS = tuple(0.05 * 2.0**i for i in range(10))
"""Multiples of a term's usual size that are tried, of either sign [-]."""
FITTED = 3
"""Terms of those tried that are fitted."""
ROUNDS = 8


def growing(setting: Setting, limit: float, executor: Executor) -> Iterator[Scored]:
    """
    Yield the best fit of each description with one term, then with two, and so on.

    :param limit: cost below which nothing significant is left, so that no more terms are needed
    """
    (mode,) = setting.modes
    chosen: dict[str, Terms] = {name: {} for name in DESCRIPTIONS[mode]}
    for count in range(1, MOST_TERMS + 1):
        names = [name for name in chosen if len(_sizes(name)) >= count]
        starts = [one for name in names for one in more(setting, name, chosen[name], executor)]
        fits = map_tasks(executor, fit_from, starts, setting, ROUNDS)
        best = [
            min((one for one in fits if one.fit.explanation.name == name), key=cost_of)
            for name in names
        ]
        yield from best
        if min(one.worst for one in best) < limit:
            return
        chosen |= {one.fit.explanation.name: terms_of(one.fit.explanation) for one in best}


def more(setting: Setting, name: str, chosen: Terms, executor: Executor) -> list[Explanation]:
    """Return a description with one more term, in some ways from which it may be fitted."""
    found = proposed(setting, name, len(chosen) + 1) + tried(setting, name, chosen, executor)
    return [explained(name, terms) for terms in found]


def proposed(setting: Setting, name: str, count: int) -> list[Terms]:
    """Return so many terms of a description that explain the residual, if it is of their unit."""
    if name in TRIED_ONLY:
        return []
    matrix, target = regression(setting.given, setting.fitted, name)
    terms = sparse_terms(matrix, target, name, count)
    return [terms] if terms else []


def tried(setting: Setting, name: str, chosen: Terms, executor: Executor) -> list[Terms]:
    """
    Return some terms with the one more that leaves least, and those that come next.

    Every other experiment, roughly simulated, has to do for this.
    """
    others = [term for term in _sizes(name) if term not in chosen]
    half = setting.fitted.subset(range(0, len(setting.fitted.experiments), 2))
    found = map_tasks(executor, strength, others, name, chosen, setting._replace(fitted=half))
    ranked = sorted(found, key=lambda one: one[0])
    return [{**chosen, term: value} for _, term, value in ranked[:FITTED]]


def strength(term: str, name: str, chosen: Terms, setting: Setting) -> tuple[float, str, float]:
    """Return the least cost over the coefficients of one more term, the term, and that one."""
    size = _sizes(name)[term]
    values = [sign * factor * size for factor in STRENGTHS for sign in (1.0, -1.0)]
    every = [explained(name, {**chosen, term: value}) for value in values]
    costs = costs_of(every, setting.given.roughly(), setting.fitted, setting.modes)
    index = int(np.argmin(costs))
    return costs[index], term, values[index]


def _sizes(name: str) -> dict[str, float]:
    """Return the terms of a description -> a usual size of their coefficients [SI]."""
    part = effect_candidate(name)
    return {c.name: c.scale for c in part.coordinates}


def explained(name: str, terms: Terms) -> Explanation:
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
