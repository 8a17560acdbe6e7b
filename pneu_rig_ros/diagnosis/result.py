"""The answer of a diagnosis as plain data: diagnosis.json version 2, schema in docs/."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.alternatives import candidates, indistinguishable
from pneu_rig_ros.diagnosis.candidates import CALIBRATION, Candidate, Condition
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.each_recording import each_recording
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.families import Family
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.improvement import signal_tables
from pneu_rig_ros.diagnosis.intervals import (
    contribution_intervals,
    residual_intervals,
    value_intervals,
)
from pneu_rig_ros.diagnosis.localisation import (
    BALANCES,
    UNITS,
    SignificantResidual,
    Windows,
    windows_of,
)
from pneu_rig_ros.diagnosis.scoring import above, excess
from pneu_rig_ros.diagnosis.workflow import (
    CONSISTENT,
    UNCALIBRATED,
    UNKNOWN,
    Diagnosis,
)
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.shape import DRIVERS, Shape

Floats = NDArray[np.float64]
Rows = Sequence[Mapping[str, Any]]

VERSION = 2
MOST_INTERVALS = 6
"""Intervals that are told of each disagreement, longest first."""


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return diagnosis.json as plain data."""
    estimates = list(_estimates(diagnosis))
    parameters = [row for part, row in estimates if part.is_parameter]
    effects = [row for part, row in estimates if part.is_effect and not part.describes]
    conditions = [row for part, row in estimates if isinstance(part, Condition)]
    return {
        'version': VERSION,
        'model': diagnosis.system.name,
        'seed': diagnosis.seed,
        'seconds': diagnosis.seconds,
        'recordings': {
            'fit': [one.run.name for one in diagnosis.fitted.comparisons],
            'verify': [one.run.name for one in diagnosis.held.comparisons],
        },
        'verdict': diagnosis.verdict,
        'sentence': sentence(diagnosis, parameters, effects, conditions),
        'balances': balances(diagnosis),
        'where': [disagreement(one) for one in told(diagnosis)],
        'intervals': [
            {'balance': balance, 'recording': name, 'from': a, 'to': b}
            for balance, name, a, b in intervals(diagnosis)
        ],
        'null_scores': null_scores(diagnosis.windows),
        'candidates': candidates(diagnosis),
        'indistinguishable': indistinguishable(diagnosis),
        'calibration': next((row for part, row in estimates if part.name == CALIBRATION), {}),
        'conditions': conditions,
        'parameters': parameters,
        'effects': effects,
        'unknown': diagnosis.unknown and diagnosis.unknown.to_dict(),
        'each_recording': each_recording(diagnosis),
        'gap': gap(diagnosis),
        'next_experiment': diagnosis.next_experiment and diagnosis.next_experiment.to_dict(),
    }


def sentence(diagnosis: Diagnosis, parameters: Rows, effects: Rows, conditions: Rows) -> str:
    """
    Return the verdict in one sentence.

    :param parameters, effects, conditions: those that are told
    """
    verdict = diagnosis.verdict
    if verdict == CONSISTENT:
        return 'Model and measurement agree within the noise: nothing is missing.'
    if verdict == UNCALIBRATED:
        return 'Errors of the sensors within their class explain what differs; nothing is missing.'
    if verdict == UNKNOWN:
        places = ' and '.join(dict.fromkeys(one.balance for one in told(diagnosis)))
        return (
            f'Model and measurement disagree in {places}, and nothing in the library explains it.'
        )
    lacks = [f'{one["name"]} ({one["title"]}){form_text(one["shape"])}' for one in effects]
    texts = ['The model lacks ' + ' and '.join(lacks)] if effects else []
    wrong = ' and '.join(one['name'] for one in parameters)
    texts += [f'{wrong} {"have" if len(parameters) > 1 else "has"} another value'] * bool(wrong)
    texts += [f'{one["name"]} is {one["value"]:.3g} times what the recordings state'
              for one in conditions]  # fmt: skip
    left = diagnosis.search.left()
    texts += [f'{left:.0%} of what exceeds the noise remains'] * (left >= 0.01)
    return '; '.join(texts) + '.'


def form_text(shape: Mapping[str, Any] | None) -> str:
    """Return how an effect differs from its formula for a sentence, '' where it does not."""
    if shape is None:
        return ''
    way = 'grows' if shape['y'][-1] > shape['y'][0] else 'falls'
    return f', which {way} with {shape["variable"].replace("_", " ")}'


def form_of(effect: str, explanation: Explanation) -> Shape | None:
    """Return the factor by which an effect differs from its formula, None where it does not."""
    for part, values in zip(explanation.parts, explanation.values, strict=True):
        if isinstance(part, Family) and part.effect == effect:
            return part.shape(values)
    return None


def told(diagnosis: Diagnosis) -> Sequence[SignificantResidual]:
    """
    Return where the model disagrees.

    Where only simulation from rest to rest shows it, that is at the breakaways.
    """
    return diagnosis.where or (diagnosis.simulated if diagnosis.verdict != CONSISTENT else [])


def disagreement(one: SignificantResidual) -> dict[str, Any]:
    """Return a disagreement as plain data."""
    spans = sorted(one.intervals, key=lambda span: span[1] - span[2])[:MOST_INTERVALS]
    return {
        'balance': one.balance, 'regime': one.regime, 'direction': one.direction,
        'unit': one.unit, 'mean': one.mean, 'noise': float(one.noise),
        'significance': float(one.significance), 'p_value': float(one.p_value),
        'variable': one.variable,
        'from': one.low, 'to': one.high, 'recordings': list(one.recordings),
        'intervals': [{'recording': name, 'from': a, 'to': b} for name, a, b in spans],
    }  # fmt: skip


def intervals(diagnosis: Diagnosis) -> list[tuple[str, str, float, float]]:
    """Return when the explanation contributes more than the noise; or what is unexplained does."""
    if diagnosis.verdict == CONSISTENT:
        return []
    if diagnosis.explanation.parts:
        known = diagnosis.explanation.apply(diagnosis.given)
        return contribution_intervals(diagnosis.given, known, diagnosis.fitted)
    return residual_intervals(diagnosis.windows, 3.0)


def null_scores(windows: Sequence[Windows]) -> list[dict[str, Any]]:
    """Return mean and RMS of the whitened residuals of the given model, by balance and regime."""
    rows = []
    for balance in BALANCES:
        here = [one for one in windows if one.balance == balance]
        regimes = {str(regime) for one in here for regime in one.regime}
        for regime in sorted(regimes):
            z = np.concatenate([one.whitened[one.regime == regime] for one in here])
            rows.append({'balance': balance, 'regime': regime, 'mean': float(z.mean()),
                         'rms': float(np.sqrt(np.mean(z**2))), 'count': int(z.size)})  # fmt: skip
    return rows


def balances(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return each balance, whether it is open, what is said of it and what is left."""
    closed = diagnosis.missing
    left = left_of_each(diagnosis.held, diagnosis.given, diagnosis.improved)
    found = {one.balance for one in told(diagnosis)}
    rows = []
    for name in BALANCES:
        is_open = not closed[name]
        verdict = (diagnosis.verdict if name in found else CONSISTENT) if is_open else None
        rows.append({'name': name, 'unit': UNITS[name], 'open': is_open, 'why': closed[name],
                     'verdict': verdict, 'left': left[name] if is_open else None})  # fmt: skip
    return rows


def left_of_each(
    dataset: Dataset, given: Hypothesis, improved: Hypothesis
) -> dict[str, float | None]:
    """Return balance -> share of what exceeds the noise that is left, None where nothing does."""
    rows: dict[str, float | None] = {}
    both = [windows_of(dataset, one) for one in (given, improved)]
    for name in BALANCES:
        before, after = (above(whitened_of(name, windows)) for windows in both)
        rows[name] = after / before if before > 0.0 else None
    return rows


def whitened_of(balance: str, windows: Sequence[Windows]) -> Floats:
    """Return the whitened residuals of a balance, shape (n,)."""
    own = [one.whitened for one in windows if one.balance == balance]
    return np.concatenate([np.zeros(0), *own])


def _estimates(diagnosis: Diagnosis) -> Iterator[tuple[Candidate, dict[str, Any]]]:
    """Yield each part of the explanation with its values and intervals as plain data."""
    if diagnosis.best is None:
        return
    spans = iter(value_intervals(diagnosis.best.fit, diagnosis.given, diagnosis.search.fitted))
    explanation = diagnosis.explanation
    for one, fitted in zip(explanation.parts, explanation.values, strict=True):
        rows: dict[str, dict[str, Any]] = {
            c.name: {'value': value, 'interval': list(next(spans)), 'unit': c.quantity.unit}
            for c, value in zip(one.coordinates, fitted, strict=True)
        }
        if one.name == CALIBRATION:
            yield one, rows
        elif one.is_effect:
            yield one, {'name': one.name, 'title': library.load(one.name).title,
                        'balance': one.balance, 'parameters': rows,
                        'shape': _shape(form_of(one.name, explanation))}  # fmt: skip
        elif isinstance(one, Condition):
            runs = [c.run for c in diagnosis.fitted.comparisons]
            stated = [float(getattr(run.operation, one.condition)) for run in runs]
            yield one, {'name': one.condition, 'stated': stated, **rows['times']}
        elif one.is_parameter:
            row = next(iter(rows.values()))
            low, high = row['interval']
            if one.name not in diagnosis.system.refit or not low <= one.was <= high:
                yield one, {'name': one.name, 'was': one.was, **row}


def _shape(shape: Shape | None) -> dict[str, Any] | None:
    """Return a factor over a variable as plain data."""
    if shape is None:
        return None
    unit = DRIVERS[shape.over].unit
    return {'variable': shape.over, 'unit': unit, 'x': list(shape.at), 'y': list(shape.times)}


def gap(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the gap on the recordings left out, before and after, as plain data."""
    given, improved, held = diagnosis.given, diagnosis.improved, diagnosis.search.held
    before, after = (excess(held, one) for one in (given, improved))
    return {
        'of': 'residuals' if held.cycles is None else 'cycles',
        'before': before,
        'after': after,
        'cut': 1.0 - after / before if before > 0.0 else 0.0,
        **signal_tables(given, improved, held),
        'bags': [one.run.name for one in held.comparisons],
    }
