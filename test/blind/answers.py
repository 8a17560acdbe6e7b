"""
Carrying out a trial: recordings and a model file go into the workflow, an answer comes out.

The workflow is handed the paths of recordings, mapping and model, a seed, and what its library is
to lack; what was hidden is joined to its answer only after it has been given.
"""

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import Executor
from pneu_rig_ros.records.description import git_revision

from . import cases, places
from .files import Files
from .foreign_trials import SEVERAL_FORMS
from .trials import Trial

Answer = dict[str, Any]
FOLDER = 'blind_answers'
"""Beside the page: a file for each revision, with one answer a line."""
LONGEST_RANKING = 6
"""Candidates kept of the ranking."""
Ask = Callable[[Files, Trial, Executor | None], Answer]


def kept(store: Path, trials: list[Trial]) -> list[Answer]:
    """Return the answers of a file to some trials, in its order."""
    keys = {trial.key for trial in trials}
    if not store.exists():
        return []
    lines = [json.loads(line) for line in store.read_text().splitlines()]
    return [answer for answer in lines if answer['key'] in keys]


def ask(files: Files, trial: Trial, executor: Executor | None) -> Answer:
    """Return what the workflow says, the content of diagnosis.json."""
    from pneu_rig_ros.diagnosis.result import answer
    from pneu_rig_ros.diagnosis.workflow import diagnose

    diagnosis = diagnose(
        files.fit,
        files.model,
        files.verify,
        seed=1,
        without=trial.without,
        executor=executor,
        mapping=files.mapping,
    )
    return answer(diagnosis)


def carry_out(trial: Trial, executor: Executor | None = None, ask: Ask = ask) -> Answer:
    """
    Return one line of the results: the trial, the answer, and how the two compare.

    :param executor: where the workflow may run its tasks; this process if it is not said
    """
    with tempfile.TemporaryDirectory(prefix='blind_', ignore_cleanup_errors=True) as folder:
        files = cases.make_files(Path(folder) / 'recordings', trial)
        begin = time.perf_counter()
        try:
            said = ask(files, trial, executor)
        except ImportError:  # there is no workflow to judge
            raise
        except RigError as error:  # the recordings cannot be those of the model: one line
            said = {'verdict': 'refused', 'error': str(error)}
        except Exception as error:  # a crash is a wrong answer, not the end of the matrix
            said = {'verdict': 'crashed', 'error': f'{type(error).__name__}: {error}'}
        said = {**said, 'seconds': time.perf_counter() - begin}
    return {**joined(trial, said), 'workers': executor.workers if executor else 1}


def joined(trial: Trial, said: Answer) -> Answer:
    """
    Return the answer with the truth beside it, cut down to what the tables need.

    Of what was fitted it has the relative error, and whether its interval holds the truth.
    """
    line = {
        'key': trial.key,
        'part': trial.part,
        'cylinder': trial.cylinder,
        'noise': trial.noise,
        'strength': trial.strength,
        'names': list(trial.names),
        'visibility': cases.visibility(trial),
    }
    if trial.part in SEVERAL_FORMS:
        line['least_visibility'] = cases.least_visibility(trial)
    ranking = ['+'.join(row['names']) for row in said.get('candidates', [])]
    gap, unknown = said.get('gap') or {}, said.get('unknown') or {}
    fitted = list(_fitted(trial, said))
    # of its name, or of its verdict without one
    chosen = [row['probability'] for row in said.get('candidates', []) if row['chosen']]
    return line | {
        'verdict': said['verdict'],
        'error': said.get('error', ''),
        'ranking': ranking[:LONGEST_RANKING],
        'effects': [effect['name'] for effect in said.get('effects', [])],
        'parameters': [parameter['name'] for parameter in said.get('parameters', [])],
        'conditions': [condition['name'] for condition in said.get('conditions', [])],
        'alike': said.get('indistinguishable', []),
        'balance': unknown.get('balance', ''),
        'where': [place['balance'] for place in said.get('where', [])],
        'times': places.times(trial.names, cases.truth(trial), said.get('intervals', [])),
        'null_scores': said.get('null_scores', []) if not trial.names else [],
        'before': gap.get('before'),
        'after': gap.get('after'),
        'cut': gap.get('cut'),
        'errors': {
            name: abs(row['value'] - truth) / abs(truth)
            for name, truth, row in fitted
            if truth != 0.0
        },
        'covered': {
            name: bool(row['interval'][0] <= truth <= row['interval'][1])
            for name, truth, row in fitted
        },
        'seconds': said.get('seconds'),
        'probability': chosen[0] if chosen else said.get('probability'),
        'revision': git_revision(),
    }


def _fitted(trial: Trial, said: Answer) -> Iterator[tuple[str, float, dict[str, Any]]]:
    """Yield name, true value and what was said of each hidden parameter that was fitted."""
    rows = {p['name']: p for p in said.get('parameters', [])}
    for effect in said.get('effects', []):
        rows |= {f'{effect["name"]}.{name}': row for name, row in effect['parameters'].items()}
    truth = cases.hidden_values(trial)
    yield from ((name, value, rows[name]) for name, value in truth.items() if name in rows)
