"""
What nobody has named yet: a sparse term that describes the gap, and can be added and simulated.

The terms are those of the ``described_...`` effects. Which of them are needed is found by sparse
regression (pysindy) of the residual of the balance, or of the gap of the pressures for errors of
the sensors; their coefficients are then fitted by simulation like those of any effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.candidates import Candidate, effect_candidate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.fitting import Explanation, Fit, fit, scanned
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, block_means
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
ALWAYS = {'described_friction': ('static',)}
"""Coefficients that sliding cannot show."""
MOST_TERMS = 3
"""Terms of a description at most."""
LEAST_GAIN = 0.9
"""One more term that leaves more than this share of the cost is left out [-]."""
ROUNDS = 8


@dataclass(frozen=True)
class Description:
    """
    A description of what is not known.

    :param balance, regime, unit: where it shows
    :param term: formula for a person
    :param gap_left: share of the cost above the floor that is left on runs not fitted [-]
    :param hypothesis: with the description as an effect
    :param fit: of its coefficients
    """

    balance: str
    regime: str
    unit: str
    term: str
    gap_left: float
    hypothesis: Hypothesis
    fit: Fit

    def to_dict(self) -> dict[str, Any]:
        """Return what diagnosis.json says of it."""
        return {'balance': self.balance, 'regime': self.regime, 'unit': self.unit,
                'term': self.term, 'gap_left': self.gap_left}  # fmt: skip


def describe(
    known: Hypothesis, fitted: Evidence, held: Evidence, mode: Mode, at_floor: float, limit: float
) -> Description:
    """
    Return the description that shrinks the gap of a prediction most.

    The sensors are blamed only where their errors leave nothing significant: a share of any gap
    can be put on them.

    :param at_floor: cost of a true hypothesis [-]
    :param limit: cost below which nothing significant is left [-]
    """

    def worst(one: Fit) -> float:
        return max(one.cost, held.cost(one.explanation.apply(known), (mode,)))

    tried = [
        one for name in DESCRIPTIONS[mode] for one in growing(known, fitted, held, name, mode)
    ]
    best = min((one for one in tried if not _of_sensors(one) or worst(one) < limit), key=worst)
    hypothesis = best.explanation.apply(known)
    before, after = (held.cost(one, (mode,)) for one in (known, hypothesis))
    balance, regime, unit = _place(best, known, fitted, mode)
    left = max(after - at_floor, 0.0) / max(before - at_floor, 1e-9)
    return Description(balance, regime, unit, formula(best.explanation), left, hypothesis, best)


def _place(best: Fit, known: Hypothesis, fitted: Evidence, mode: Mode) -> tuple[str, str, str]:
    """Return the balance that a description acts on, the regime where it shows, and the unit."""
    where = [one for one in disagreements(known, fitted) if _shows(one.balance, mode)]
    regime = where[0].regime if where else 'sliding'
    if _of_sensors(best):
        part = best.explanation.parts[0]
        return part.balance, regime, part.coordinates[0].quantity.unit
    if where:
        return where[0].balance, regime, where[0].unit
    return _default(mode)


def _of_sensors(one: Fit) -> bool:
    """Return whether a description is of errors of the sensors."""
    return library.load(one.explanation.parts[0].name).balance in READING_BALANCES


def _shows(balance: str, mode: Mode) -> bool:
    return balance.startswith('gas') == (mode is Mode.CHAMBERS)


def _default(mode: Mode) -> tuple[str, str, str]:
    if mode is Mode.CHAMBERS:
        return 'gas mass 1', 'sliding out', 'kg/s'
    return 'force', 'breakaway', 'N'


def growing(
    known: Hypothesis, fitted: Evidence, held: Evidence, name: str, mode: Mode
) -> Iterator[Fit]:
    """Yield the fits of a description with more and more terms, as long as they are worth it."""
    matrix, target = regression(known, fitted, name)
    reached = held.cost(known, (mode,))
    for count in range(1, MOST_TERMS + 1):
        terms = sparse_terms(matrix, target, name, count)
        part = _only(effect_candidate(name), terms)
        start = Explanation().plus(part, tuple(terms[c.name] for c in part.coordinates))
        _, start = scanned((start,), known, fitted, (mode,))
        result = fit(known, start, fitted, (mode,), ROUNDS)
        cost = held.cost(result.explanation.apply(known), (mode,))
        if cost > LEAST_GAIN * reached:
            if count == 1:
                yield result
            return
        reached = cost
        yield result


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
    optimizer.fit(matrix[:, known] / size, target[:, np.newaxis])
    order = np.argsort(-np.abs(np.ravel(optimizer.coef_)))[:count]
    chosen = known[order]
    values, *_ = np.linalg.lstsq(matrix[:, chosen], target, rcond=None)
    found = {names[int(i)]: float(value) for i, value in zip(chosen, values, strict=True)}
    return dict.fromkeys(ALWAYS.get(name, ()), 0.0) | found


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


def _only(candidate: Candidate, terms: Mapping[str, float]) -> Candidate:
    """Return the candidate with some of its coordinates alone, the others at their null."""
    kept = tuple(c for c in candidate.coordinates if c.name in terms)
    return replace(candidate, coordinates=kept, starts=())


def formula(explanation: Explanation) -> str:
    """Return a description's formula for a person."""
    part, values = explanation.parts[0], explanation.values[0]
    texts = [f'{value:+.3g} {c.quantity.unit} {c.name}'
             for c, value in zip(part.coordinates, values, strict=True)]  # fmt: skip
    return ' '.join(texts).removeprefix('+')
