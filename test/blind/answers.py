"""
Carrying out a trial: bags and a model file go into the workflow, an answer comes out.

The workflow is handed the paths of bags and model, a seed, and what its library is to lack; what
was hidden is joined to its answer only after it has been given.
"""

import json
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pneu_rig_ros.gap.answer import answer
from pneu_rig_ros.gap.diagnosis import diagnose
from pneu_rig_ros.records.description import git_revision

from .baselines import cuts
from .hidden import true_parameters
from .rig import make_bags, visibility
from .settings import settings
from .trials import Trial, matrix

Answer = dict[str, Any]
KEPT = 'blind_answers.jsonl'
"""File beside the page with one answer a line."""
LONGEST_RANKING = 6
"""Candidates kept of the ranking."""


def kept(store: Path) -> list[Answer]:
    """Return the answers given so far, of trials that are still in the matrix."""
    keys = {trial.key for trial in matrix()}
    if not store.exists():
        return []
    lines = [json.loads(line) for line in store.read_text().splitlines()]
    return [answer for answer in lines if answer['key'] in keys]


def ask(fit: list[Path], verify: list[Path], model: Path, compare: bool, **options: Any) -> Answer:
    """Return what the workflow says, the content of diagnosis.json, and what baselines reach."""
    start = time.perf_counter()
    diagnosis = diagnose(fit, model, verify, **options)
    said = answer(diagnosis)
    said['seconds'] = time.perf_counter() - start
    said['baselines'] = cuts(diagnosis) if compare else {}
    return said


def carry_out(trial: Trial) -> Answer:
    """Return one line of the results: the trial, the answer, and how the two compare."""
    with tempfile.TemporaryDirectory(prefix='blind_', ignore_cleanup_errors=True) as folder:
        try:
            bags = make_bags(
                Path(folder) / 'bags',
                trial.cylinder,
                trial.secret,
                trial.noise,
                trial.seed,
                trial.gains,
            )
            said = ask(*bags, trial.compared, seed=1, without=trial.without)
        except Exception as error:  # a crash is a wrong answer, not the end of the matrix
            said = {'verdict': 'crashed', 'error': f'{type(error).__name__}: {error}'}
    return joined(trial, said)


def joined(trial: Trial, said: Answer) -> Answer:
    """Return the answer with the truth beside it, cut down to what the tables need."""
    line = {
        'key': trial.key, 'part': trial.part, 'cylinder': trial.cylinder, 'noise': trial.noise,
        'strength': trial.strength, 'names': list(trial.names),
        'visibility': visibility(trial.cylinder, trial.secret, trial.noise),
    }  # fmt: skip
    ranking = ['+'.join(row['names']) for row in said.get('candidates', [])]
    gap, unknown = said.get('gap') or {}, said.get('unknown') or {}
    return line | {
        'verdict': said['verdict'],
        'error': said.get('error', ''),
        'ranking': ranking[:LONGEST_RANKING],
        'effects': [effect['name'] for effect in said.get('effects', [])],
        'parameters': [parameter['name'] for parameter in said.get('parameters', [])],
        'alike': said.get('indistinguishable', []),
        'balance': unknown.get('balance', ''),
        'where': [place['balance'] for place in said.get('where', [])],
        'before': gap.get('before'), 'after': gap.get('after'), 'cut': gap.get('cut'),
        'errors': _errors(trial, said),
        'covered': _covered(trial, said),
        'baselines': said.get('baselines', {}),
        'seconds': said.get('seconds'),
        'revision': git_revision(),
    }  # fmt: skip


def _truth(trial: Trial) -> dict[str, float]:
    """Return effect.parameter or section.key -> true value [SI] of what was hidden."""
    friction = settings(trial.cylinder)['friction']
    truth: dict[str, float] = {}
    for name in trial.names:
        if '.' in name:
            value = trial.secret.truth[name]
            truth[name] = sum(value) if isinstance(value, list) else value
        else:
            own = true_parameters(name, trial.secret, friction)
            truth |= {f'{name}.{parameter}': value for parameter, value in own.items()}
    return truth


def _fitted(trial: Trial, said: Answer) -> Iterator[tuple[str, float, dict[str, Any]]]:
    """Yield name, true value and what was said of each hidden parameter that was fitted."""
    told = {p['name']: p for p in said.get('parameters', [])}
    for effect in said.get('effects', []):
        told |= {f'{effect["name"]}.{name}': row for name, row in effect['parameters'].items()}
    yield from ((name, value, told[name]) for name, value in _truth(trial).items() if name in told)


def _errors(trial: Trial, said: Answer) -> dict[str, float]:
    """Return parameter -> relative error of what was fitted."""
    return {
        name: abs(row['value'] - truth) / abs(truth)
        for name, truth, row in _fitted(trial, said)
        if truth != 0.0
    }


def _covered(trial: Trial, said: Answer) -> dict[str, bool]:
    """Return parameter -> whether its true value is within the interval told."""
    return {
        name: bool(row['interval'][0] <= truth <= row['interval'][1])
        for name, truth, row in _fitted(trial, said)
    }
