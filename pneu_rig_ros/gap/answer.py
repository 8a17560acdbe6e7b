"""The answer of a diagnosis as plain data: diagnosis.json, schema in docs/."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain, zip_longest
from typing import Any

import numpy as np

from pneu_rig_ros.gap.candidates import CALIBRATION, Candidate
from pneu_rig_ros.gap.diagnosis import Diagnosis
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Scored
from pneu_rig_ros.gap.selection import ALIKE
from pneu_rig_ros.gap.shrink import (
    above_floor,
    measured_run,
    predicted_run,
    signal_shrink,
)
from pneu_rig_ros.gap.where import Disagreement
from pneu_rig_ros.model import effects as library

VERSION = 1
MOST_CANDIDATES = 20
"""Candidates that are told."""


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return diagnosis.json as plain data."""
    return {
        'version': VERSION,
        'model': diagnosis.configuration.name,
        'bags': {
            'fit': [one.name for one in diagnosis.fitted.experiments],
            'verify': [one.name for one in diagnosis.held.experiments],
        },
        'seed': diagnosis.seed,
        'seconds': diagnosis.seconds,
        'verdict': diagnosis.verdict,
        'sentence': sentence(diagnosis),
        'where': [disagreement(one) for one in diagnosis.where],
        'candidates': ranked(diagnosis),
        'indistinguishable': indistinguishable(diagnosis),
        'calibration': next(
            (p for part, p in _estimates(diagnosis) if part.name == CALIBRATION), {}
        ),
        'parameters': [
            p
            for part, p in _estimates(diagnosis)
            if not part.is_effect and part.name != CALIBRATION
        ],
        'effects': [p for part, p in _estimates(diagnosis) if part.is_effect],
        'unknown': diagnosis.unknown and diagnosis.unknown.to_dict(),
        'gap': gap_table(diagnosis),
        'next_experiment': diagnosis.next_experiment and diagnosis.next_experiment.to_dict(),
    }


def sentence(diagnosis: Diagnosis) -> str:
    """Return the verdict in one sentence."""
    if diagnosis.verdict == 'consistent':
        return 'Model and measurement agree within the noise: nothing is missing.'
    if diagnosis.verdict == 'unknown':
        chambers = diagnosis.unexplained is Mode.CHAMBERS
        what = 'pressures do' if chambers else 'motion does'
        gap = 'nothing in the library closes the gap'
        return f'The measured {what} not agree with the model, and {gap}.'
    names = [
        f'{part.name} ({library.load(part.name).title})' if part.is_effect
        else f'{part.name} has another value'
        for part in diagnosis.explanation.parts
        if part.name != CALIBRATION
    ]  # fmt: skip
    kind = 'The model lacks ' if diagnosis.verdict == 'effect' else 'A parameter is wrong: '
    return kind + ' and '.join(names) + '.'


def disagreement(one: Disagreement) -> dict[str, Any]:
    """Return a disagreement as plain data."""
    return {
        'balance': one.balance,
        'regime': one.regime,
        'unit': one.unit,
        'rms': one.rms,
        'noise': one.noise,
        'significance': one.significance,
        'bags': list(one.bags),
        'intervals': [{'bag': bag, 'from': a, 'to': b} for bag, a, b in one.intervals],
    }


def ranked(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """
    Return the candidates as plain data, best first: fitted ones, then those screened.

    The searches take turns, as each has a gap of its own to close.
    """
    spans = [(one.level, diagnosis.costs[mode]) for mode, one in diagnosis.searches.items()]
    searches = list(zip(diagnosis.searches.values(), spans, strict=True))
    fitted = [[_fitted(one, span) for one in search.ranking] for search, span in searches]
    screened = [
        [_row([one.candidate.name], 'screened', one.cost, span, {}) for one in search.screened]
        for search, span in searches
    ]
    rows: dict[tuple[str, ...], dict[str, Any]] = {}
    for row in chain(*zip_longest(*fitted), *zip_longest(*screened)):
        if row is not None:
            rows.setdefault(tuple(row['names']), row)
    return list(rows.values())[:MOST_CANDIDATES]


def _fitted(one: Scored, span: tuple[float, float]) -> dict[str, Any]:
    explanation = one.fit.explanation
    values = {
        f'{part.name}.{coordinate.name}' if part.is_effect else part.name: value
        for part, values in zip(explanation.parts, explanation.values, strict=True)
        for coordinate, value in zip(part.coordinates, values, strict=True)
    }
    return _row(explanation.causes, 'fitted', one.worst, span, values)


def _row(
    names: list[str], stage: str, cost: float, span: tuple[float, float], values: dict[str, float]
) -> dict[str, Any]:
    """Return a candidate; ``span`` is from the cost of a true hypothesis to that at the start."""
    left = max(cost - span[0], 0.0) / max(span[1] - span[0], 1e-9)
    return {'names': names, 'stage': stage, 'cost': cost, 'gap_left': left, 'parameters': values}


def indistinguishable(diagnosis: Diagnosis) -> list[list[str]]:
    """Return sets of explanations of equal size whose costs are alike, the best among them."""
    sets = []
    for search in diagnosis.searches.values():
        best = search.best
        if best is None:
            continue
        alike = [one for one in search.ranking if _alike(one, best)]
        if len(alike) > 1:
            sets.append(['+'.join(one.fit.explanation.causes) for one in alike])
    return sets


def _alike(one: Scored, best: Scored) -> bool:
    same_size = len(one.fit.explanation.parts) == len(best.fit.explanation.parts)
    return same_size and one.worst < best.worst + ALIKE


def _estimates(diagnosis: Diagnosis) -> list[tuple[Candidate, dict[str, Any]]]:
    """Return each part of the explanation with its values and intervals as plain data."""
    if diagnosis.final is None:
        return []
    parts, values = diagnosis.explanation.parts, diagnosis.explanation.values
    intervals = iter(diagnosis.final.intervals())
    told = []
    for one, fitted in zip(parts, values, strict=True):
        rows: dict[str, dict[str, Any]] = {
            coordinate.name: {
                'value': value, 'interval': list(next(intervals)), 'unit': coordinate.quantity.unit
            }
            for coordinate, value in zip(one.coordinates, fitted, strict=True)
        }  # fmt: skip
        row: dict[str, Any]
        if one.name == CALIBRATION:
            row = rows
        elif one.is_effect:
            row = {'name': one.name, 'title': library.load(one.name).title,
                   'balance': one.balance, 'parameters': rows}  # fmt: skip
        else:
            row = {'name': one.name, 'was': one.was, **next(iter(rows.values()))}
        told.append((one, row))
    return told


def gap_table(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the gap on the runs left out, before and after, as plain data."""
    given, improved, held = diagnosis.given, diagnosis.best, diagnosis.held
    before, after = above_floor(given, improved, held)
    signals = signal_shrink(given, improved, held, Mode.CYCLES)
    free = signal_shrink(given, improved, held, Mode.FREE)
    return {
        'before': before,
        'after': after,
        'cut': 1.0 - after / before if before > 0.0 else 0.0,
        'signals': {name: dict(one.__dict__) for name, one in signals.items()},
        'free_run': {name: dict(one.__dict__) for name, one in free.items()},
        **events(given, improved, held),
        'bags': [one.name for one in held.experiments],
    }


def events(given: Hypothesis, improved: Hypothesis, held: Evidence) -> dict[str, Any]:
    """Return cycles, dwells and stroke time, measured, before and after, as plain data."""
    rows: dict[str, list[list[float]]] = {'cycles': [], 'dwell': [], 'stroke_time': []}
    for experiment in held.experiments:
        runs = [
            measured_run(experiment, given),
            predicted_run(experiment, given, Mode.CYCLES),
            predicted_run(experiment, improved, Mode.CYCLES),
        ]
        every = [run.events for run in runs]
        rows['cycles'].append([float(len(one.cycles)) for one in every])
        rows['dwell'].append([_mean([c.dwell for c in one.cycles]) for one in every])
        rows['stroke_time'].append(
            [math.nan if one.stroke_time is None else one.stroke_time for one in every]
        )
    units = {'cycles': '-', 'dwell': 's', 'stroke_time': 's'}
    sums: dict[str, Any] = {'cycles': np.sum, 'dwell': _mean_known, 'stroke_time': _mean_known}
    return {name: _told(units[name], sums[name](np.array(table), axis=0))
            for name, table in rows.items()}  # fmt: skip


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else math.nan


def _mean_known(table: Any, axis: int) -> Any:
    known = np.isfinite(table).all(axis=1)
    return table[known].mean(axis=axis) if known.any() else np.full(3, np.nan)


def _told(unit: str, triple: Any) -> dict[str, Any]:
    measured, before, after = (float(v) if np.isfinite(v) else None for v in triple)
    return {'unit': unit, 'measured': measured, 'before': before, 'after': after}
