"""The answer of a diagnosis as a JSON-compatible dict: diagnosis.json, schema in docs/."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any, cast

import numpy as np

from pneu_rig_ros.diagnosis.answer.alternatives import indistinguishable, ranking_rows
from pneu_rig_ros.diagnosis.answer.improvement import signal_tables
from pneu_rig_ros.diagnosis.answer.intervals import (
    Spans,
    contribution_intervals,
    residual_intervals,
    value_intervals,
)
from pneu_rig_ros.diagnosis.answer.repeatability import nuisance_rows
from pneu_rig_ros.diagnosis.answer.run_differences import key_of
from pneu_rig_ros.diagnosis.answer.verdict import CONSISTENT, UNKNOWN, of_balances, probability_of
from pneu_rig_ros.diagnosis.causes.candidates import CALIBRATION, Candidate, Explanation
from pneu_rig_ros.diagnosis.causes.shaped_effects import ShapedEffect
from pneu_rig_ros.diagnosis.measured.hypothesis import POSITION_ZERO, SENSOR_CLOCK
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, UNITS
from pneu_rig_ros.diagnosis.residuals.dataset import rms
from pneu_rig_ros.diagnosis.residuals.localisation import (
    NOISE_ERROR,
    SignificantResidual,
    localise,
)
from pneu_rig_ros.diagnosis.residuals.windows import Windows, windows_of
from pneu_rig_ros.diagnosis.search.profiles import Profile
from pneu_rig_ros.diagnosis.search.scoring import excess
from pneu_rig_ros.diagnosis.sentence import sentence
from pneu_rig_ros.diagnosis.workflow import Diagnosis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import Friction, Operation
from pneu_rig_ros.model.quantity import Choice, specifications
from pneu_rig_ros.model.shape import DRIVERS

Rows = dict[str, dict[str, Any]]
"""Coordinate -> value, interval, unit."""
Estimates = list[tuple[Candidate, Rows]]
"""Parts of an explanation with their values."""

VERSION = 3
MOST_INTERVALS = 6
"""Intervals of each significant residual, longest first."""
UNEXPLAINED = 3.0
"""Local means from which on a residual without a cause is listed [standard deviations]."""
DISPLAYED = {
    'supply_pressure': (1e-5, 'bar'),
    'load_mass': (1.0, 'kg'),
    POSITION_ZERO: (1e3, 'mm'),
    SENSOR_CLOCK: (1e3, 'ms'),
}
"""Condition -> factor on its SI value, unit for a reader."""


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return diagnosis.json as a JSON-compatible dict."""
    search, best, unknown = diagnosis.search, diagnosis.best, diagnosis.unknown
    estimates = _estimates(diagnosis)
    parameters = [
        {'name': part.name, 'was': part.model_value, **row}
        for part, rows in estimates
        if part.is_parameter
        for row in rows.values()
        if _changed(part, row, diagnosis)
    ]
    effects = [
        _effect(part, rows, diagnosis.explanation) for part, rows in estimates if part.is_effect
    ]
    conditions = _conditions(diagnosis, estimates)
    likely = probability_of(diagnosis.verdict, diagnosis.system.uncalibrated)
    fitted, verified = ([each.run for each in data.comparisons] for data in search.initial)
    return {
        'version': VERSION,
        'model': diagnosis.system.name,
        'seed': diagnosis.seed,
        'seconds': diagnosis.seconds,
        'recordings': {
            'fit': [run.name for run in fitted],
            'verify': [run.name for run in verified],
        },
        'notes': [
            {'recording': run.name, 'note': note}
            for run in fitted + verified
            for note in run.notes
        ],
        'verdict': diagnosis.verdict,
        'probability': likely,
        'sentence': sentence(diagnosis, parameters, effects, conditions),
        'balances': _balances(diagnosis),
        'where': [_residual(residual) for residual in diagnosis.significant],
        'intervals': _rows(_intervals(diagnosis), 'balance', 'recording'),
        'null_scores': _null_scores(diagnosis.windows),
        'candidates': ranking_rows(search, best, diagnosis.verdict, likely),
        'indistinguishable': indistinguishable(search, best),
        'calibration': next((rows for part, rows in estimates if part.name == CALIBRATION), {}),
        'conditions': conditions,
        'parameters': parameters,
        'effects': effects,
        'unknown': unknown and unknown.to_dict(),
        'each_recording': [
            *(row for data in search.data for row in nuisance_rows(diagnosis.improved, data)),
            *diagnosis.variation.rows(),
        ],
        'differing_recordings': [each.to_dict() for each in diagnosis.differing],
        'gap': _gap(diagnosis),
        'next_experiment': diagnosis.next_experiment and asdict(diagnosis.next_experiment),
    }


def _balances(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return each balance with its verdict and the remaining share of its excess."""
    held_out, verdicts = diagnosis.held_out, _verdicts(diagnosis)
    windows = [windows_of(held_out, each) for each in (diagnosis.given, diagnosis.improved)]
    rows = []
    for name in BALANCES:
        before, after = (_excess_rms(name, groups) for groups in windows)
        missing = held_out.comparisons[0].run.missing[name]
        row = {'name': name, 'unit': UNITS[name], 'open': not missing, 'why': missing}
        row['verdict'] = None if missing else verdicts[name]
        row['left'] = after / before if before > 0.0 and not missing else None
        rows.append(row)
    return rows


def _verdicts(diagnosis: Diagnosis) -> dict[str, str]:
    """
    Return balance -> verdict; significant residuals that show no cause are unknown.

    Beside a cause they have to stay so under the improved model: while a strong cause makes many
    regimes significant, one in twenty of those that are listed may be false.
    """
    significant = {each.balance for each in diagnosis.significant}
    if diagnosis.verdict in (CONSISTENT, UNKNOWN) or diagnosis.misstatement is not None:
        return {n: diagnosis.verdict if n in significant else CONSISTENT for n in BALANCES}
    left = localise(windows_of(diagnosis.training, diagnosis.improved))
    disagrees = significant & {each.balance for each in left}
    training, cycles = diagnosis.training, diagnosis.search.training.cycles
    verdicts = of_balances(diagnosis.explanation, training, cycles)
    return {
        name: UNKNOWN if name in disagrees and each == CONSISTENT else each
        for name, each in verdicts.items()
    }


def _excess_rms(balance: str, windows: Sequence[Windows]) -> float:
    """Return the RMS of a balance's whitened residuals beyond that of noise [-]."""
    parts = [group.whitened for group in windows if group.balance == balance]
    if not parts:
        return 0.0
    excess = float(np.mean(np.concatenate(parts) ** 2)) - NOISE_ERROR**2
    return float(np.sqrt(max(excess, 0.0)))


def _residual(residual: SignificantResidual) -> dict[str, Any]:
    spans = sorted(residual.intervals, key=lambda span: span[1] - span[2])[:MOST_INTERVALS]
    return {
        'balance': residual.balance,
        'regime': residual.regime,
        'direction': residual.direction,
        'unit': residual.unit,
        'mean': residual.mean,
        'noise': float(residual.noise),
        'significance': float(residual.significance),
        'p_value': float(residual.p_value),
        'variable': residual.variable,
        'from': residual.low,
        'to': residual.high,
        'parts': _rows(residual.parts, 'variable'),
        'recordings': list(residual.recordings),
        'intervals': _rows(spans, 'recording'),
    }


def _rows(spans: Iterable[tuple[Any, ...]], *names: str) -> list[dict[str, Any]]:
    """Return ranges with their names, which stand before both ends."""
    return [dict(zip((*names, 'from', 'to'), span, strict=True)) for span in spans]


def _intervals(diagnosis: Diagnosis) -> Spans:
    """Return when the explanation contributes more than the noise, else when residuals do."""
    if diagnosis.verdict == CONSISTENT:
        return []
    if not diagnosis.explanation.parts:
        return residual_intervals(diagnosis.windows, UNEXPLAINED)
    explained = diagnosis.explanation.hypothesis
    return contribution_intervals(diagnosis.given, explained, diagnosis.training)


def _null_scores(windows: Sequence[Windows]) -> list[dict[str, Any]]:
    """Return mean and RMS of the whitened residuals of the given model, by balance and regime."""
    rows = []
    for balance in BALANCES:
        groups = [group for group in windows if group.balance == balance]
        for regime in sorted({str(regime) for group in groups for regime in group.regime}):
            z = np.concatenate([group.whitened[group.regime == regime] for group in groups])
            place = {'balance': balance, 'regime': regime}
            rows.append({**place, 'mean': float(z.mean()), 'rms': rms(z), 'count': int(z.size)})
    return rows


def _estimates(diagnosis: Diagnosis) -> Estimates:
    """Return each part of the explanation with its values and confidence intervals."""
    if diagnosis.best is None:
        return []
    training, explanation = diagnosis.search.training, diagnosis.explanation
    spans = iter(value_intervals(diagnosis.best, training, diagnosis.errors))
    rows: Estimates = [(part, {}) for part in explanation.parts]
    for (_, row), (part, values) in zip(rows, explanation.by_part, strict=True):
        for c, value in zip(part.coordinates, values, strict=True):
            row[c.name] = {'value': value, 'interval': [*next(spans)], 'unit': c.quantity.unit}
    return rows


def _changed(part: Candidate, row: dict[str, Any], diagnosis: Diagnosis) -> bool:
    """Return whether a parameter is another one: of those refitted anyway, significantly."""
    low, high = row['interval']
    return part.name not in diagnosis.system.refit or not low <= part.model_value <= high


def _conditions(diagnosis: Diagnosis, estimates: Estimates) -> list[dict[str, Any]]:
    """
    Return the conditions that are not as stated: as a whole, then those with a fitted value.

    The value is a ratio to what is stated, or a difference from zero.
    """
    rows: list[dict[str, Any]] = []
    if (other := diagnosis.misstatement) is not None:
        row = {'name': other.name, 'stated': other.stated, 'true': other.true}
        rows.append({**row, 'value': None, 'interval': None, 'unit': ''})
    operations = [each.run.operation for each in diagnosis.training.comparisons]
    for part, values in estimates:
        if not part.is_condition:
            continue
        (estimate,) = values.values()
        name, value = key_of(part), estimate['value']
        stated, true = [0.0], [value]
        if name in Operation._fields:
            stated = [float(getattr(each, name)) for each in operations]
            true = [value * each for each in stated]
        texts = {'stated': _range(stated, name), 'true': _range(true, name)}
        rows.append({'name': name, **texts, **estimate})
    return rows


def _range(values: Sequence[float], name: str) -> str:
    """Return the values [SI] of a condition in all recordings for a reader."""
    factor, unit = DISPLAYED[name]
    texts = [f'{factor * value:.3g}' for value in (min(values), max(values))]
    return f'{" to ".join(dict.fromkeys(texts))} {unit}'


def _effect(part: Candidate, rows: Rows, explanation: Explanation) -> dict[str, Any]:
    choices = cast(dict[str, Choice], specifications(Friction))
    return {
        'name': part.name,
        'title': library.load(part.name).title,
        'balance': part.balance,
        # single knots mean nothing: their mean is also a level of the model
        'parameters': {} if isinstance(part, Profile) else rows,
        'readings': {name: choices[name].format(value) for name, value in part.readings},
        'shape': _shape(part.name, explanation),
    }


def _shape(effect: str, explanation: Explanation) -> dict[str, Any] | None:
    """Return the factor by which an effect differs from its formula, None without one."""
    for part, values in explanation.by_part:
        if isinstance(part, ShapedEffect | Profile) and part.effect == effect:
            shape = part.shape(values)
            return {
                'variable': shape.over,
                'unit': DRIVERS[shape.over].unit,
                'x': list(shape.at),
                'y': [part.size * factor for factor in shape.times],
                'y_unit': part.unit,
            }
    return None


def _gap(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the excess and the RMSE on held-out data, before and after."""
    given, improved, held_out = diagnosis.given, diagnosis.improved, diagnosis.search.held_out
    before, after = excess(held_out, given), diagnosis.search.excess_beyond_noise(improved)
    if improved == given:  # what remains is not noise: something is missing, and was not found
        after = before
    if diagnosis.misstatement is not None:
        before = diagnosis.misstatement.excess
    return {
        'of': 'residuals' if held_out.cycles is None else 'cycles',
        'before': before,
        'after': after,
        'cut': 1.0 - after / before if before > 0.0 else None,
        **signal_tables(given, improved, held_out),
        'bags': [each.run.name for each in held_out.comparisons],
    }
