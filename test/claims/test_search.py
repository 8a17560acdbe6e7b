"""The search is repeatable, whatever the number of workers, and tells how each setting fares."""

import json
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.claims import search as module
from pneu_rig_ros.claims import sensitivity as variation
from pneu_rig_ros.claims.readings import load_reading
from pneu_rig_ros.claims.search import (
    CHOICES,
    LINEAR_RANGES,
    LOG_RANGES,
    START,
    Outcome,
    anywhere,
    breed,
    draw,
    evaluate,
    search,
)
from pneu_rig_ros.claims.sensitivity import sensitivity, variations
from pneu_rig_ros.claims.statements import STATEMENTS
from pneu_rig_ros.cli.search import describe, held_by, plain
from pneu_rig_ros.executor import Here, executor

from .conftest import Run

FIRST = STATEMENTS[:3]


@pytest.fixture
def soon_bred(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw settings in batches of four, so that they are soon bred."""
    monkeypatch.setattr(module, 'BATCH', 4)
    monkeypatch.setattr(module, 'PARENTS', 2)


@pytest.mark.usefixtures('soon_bred')
def test_same_seed_same_result_whatever_the_workers() -> None:
    done: list[int] = []
    alone = search(12, 5, Here(), done.append, FIRST)
    with executor(2) as processes:
        assert search(12, 5, processes, statements=FIRST) == alone
    assert done[-1] == len(alone) == 12
    assert sorted(alone, key=lambda outcome: outcome.score, reverse=True) == alone
    assert alone[0].pursued
    assert held_by(alone)[3] == sum(outcome.holds.get(3, False) for outcome in alone)


def test_another_seed_draws_other_settings() -> None:
    first, again, second = (draw(np.random.default_rng(s), [], 2) for s in (1, 1, 2))
    assert first == again
    assert first[0] == second[0]  # the setting that each search tries first
    assert first[1] != second[1]


def test_bred_settings_stay_in_range() -> None:
    rng = np.random.default_rng(1)
    parents = [anywhere(rng) for _ in range(4)]
    for _ in range(100):
        child = breed(rng, parents)
        assert set(child) == set(parents[0])
        assert all(0.0 <= child[name] <= 1.0 for name in (*LOG_RANGES, *LINEAR_RANGES))
        assert all(child[name] in range(size) for name, size in CHOICES.items())


def test_hopeless_setting_is_given_up_early() -> None:
    genes = anywhere(np.random.default_rng(1))
    hopeless = evaluate(genes, bar=float(len(STATEMENTS)))
    assert len(hopeless.margins) < len(STATEMENTS)
    assert not hopeless.pursued


def test_kept_statement_counts_before_the_others() -> None:
    def outcome(keep: int | None, *held: int) -> Outcome:
        margins = {number: 0.1 if number in held else -0.1 for number in range(1, 5)}
        return Outcome(START, margins, {n: max(0.0, -m) for n, m in margins.items()}, True, keep)

    assert outcome(None, 2, 3, 4).score > outcome(None, 1, 2).score
    assert outcome(1, 2, 3, 4).score < outcome(1, 1, 2).score
    first = evaluate(START, bar=len(STATEMENTS) - 1.0, statements=FIRST, keep=1)
    assert set(first.margins) == {1}, 'the default does not hold it: the rest is not measured'


def test_one_quantity_at_a_time_is_varied(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(variation, 'PLACES', 2)
    settings = list(variations(START))
    for name, genes in settings:
        assert set(genes.items()) - set(START.items()) <= {(name, genes[name])}
    best = sensitivity(START, Here(), statements=FIRST)
    assert all(set(margins) == {1, 2, 3} for margins in best.values())


def test_command_prints_and_writes_the_best(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    some = list(variations(START))[:2]
    monkeypatch.setattr(variation, 'variations', lambda _: iter(some))
    file = tmp_path / 'search.json'
    code, out, err = run('--search', 1, '--seed', 5, '--workers', 1, '--out', file)
    assert (code, err) == (0, '')
    data = json.loads(file.read_text())
    outcomes = search(1, 5, Here())
    moved = data.pop('one_at_a_time')
    assert set(moved) == {name for name, _ in some}
    assert data == plain(outcomes, seed=5)
    assert data['settings_tried'] == len(data['best']) == 1
    numbers = {str(statement.number) for statement in STATEMENTS}
    assert {frozenset(data[key]) for key in ('statements', 'held_by')} == {frozenset(numbers)}
    assert describe(outcomes[0].reading) in out
    assert str(file) in out

    reading = tmp_path / 'best.yaml'
    reading.write_text(json.dumps(data['best'][0]['reading']))
    assert load_reading(reading) == outcomes[0].reading
