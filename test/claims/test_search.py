"""The search is repeatable, whatever the number of workers, and tells how each setting fares."""

import json
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.claims import search as module
from pneu_rig_ros.claims.readings import load_reading
from pneu_rig_ros.claims.search import draw, search
from pneu_rig_ros.claims.statements import STATEMENTS
from pneu_rig_ros.cli.search import describe, held_by, plain

from .conftest import Run


@pytest.fixture
def one_statement(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure statement 3 only, in batches of two, so that settings next to others come up."""
    monkeypatch.setattr(module, 'STATEMENTS', [s for s in STATEMENTS if s.number == 3])
    monkeypatch.setattr(module, 'WANTED', (3,))
    monkeypatch.setattr(module, 'BATCH', 2)


@pytest.mark.usefixtures('one_statement')
def test_same_seed_same_result_whatever_the_workers() -> None:
    done: list[int] = []
    alone = search(6, 5, 1, done.append)
    assert search(6, 5, 2) == alone
    assert done[-1] == len(alone) == 6
    assert sorted(alone, key=lambda outcome: outcome.rank, reverse=True) == alone
    assert held_by(alone) == {3: sum(outcome.holds[3] for outcome in alone)}


def test_another_seed_draws_other_settings() -> None:
    first, again, second = (list(draw(np.random.default_rng(s), [], 3)) for s in (1, 1, 2))
    assert first == again
    assert all(a != b for a, b in zip(first, second, strict=True))


def test_command_prints_and_writes_the_best(run: Run, tmp_path: Path) -> None:
    file = tmp_path / 'search.json'
    code, out, err = run('--search', 1, '--seed', 5, '--workers', 1, '--out', file)
    assert (code, err) == (0, '')
    data = json.loads(file.read_text())
    outcomes = search(1, 5, 1)
    assert data == plain(outcomes, seed=5)
    assert data['settings_tried'] == len(data['best']) == 1
    numbers = {str(statement.number) for statement in STATEMENTS}
    assert {frozenset(data[key]) for key in ('statements', 'held_by')} == {frozenset(numbers)}
    assert describe(outcomes[0].reading) in out
    assert str(file) in out

    reading = tmp_path / 'best.yaml'
    reading.write_text(json.dumps(data['best'][0]['reading']))
    assert load_reading(reading) == outcomes[0].reading
