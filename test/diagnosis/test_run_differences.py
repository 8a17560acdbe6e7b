"""A recording that differs from the others is told apart from a model that lacks something."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.repeatability import variation
from pneu_rig_ros.diagnosis.answer.run_differences import spread_between, sufficient_differences
from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.model.effects import causes
from pneu_rig_ros.simulate import simulate

from .runs import checked, configured, measured, rubbing, search_in, system_of

RUNS = 5
WORN = 1.15
"""Ratio of the forces of a worn seal to those of the model."""


def searched(folder: Path, factors: tuple[float, ...], supplies: tuple[float, ...] = ()) -> Search:
    """Return the search in runs of cylinder 1, each with its level of friction and its supply."""
    system = system_of(folder, configured('cylinder_1'))
    stated = system.hypothesis.model.operation.supply_pressure
    runs = []
    for seed, factor in enumerate(factors):
        supply = stated * (supplies[seed] if supplies else 1.0)
        rig = rubbing(configured('cylinder_1', seed=seed, supply_pressure=supply), factor)
        run = measured(system, f'run_{seed}', rig)
        operation = run.operation._replace(supply_pressure=stated)
        runs.append(replace(run, operation=operation))
    return search_in(system.hypothesis, runs, pool(system, runs)[0])


def test_seal_that_is_worn_in_one_recording_is_a_difference_of_that_recording(
    tmp_path: Path,
) -> None:
    (found,) = sufficient_differences(searched(tmp_path, (1.0, 1.0, 1.0, WORN, 1.0)), {})
    assert found.recording == 'run_3'
    assert found.quantity.name == 'conditions.friction_level'
    low, high = found.interval
    assert low < WORN - 1.0 < high
    assert high - low < 0.1


@pytest.mark.long
def test_answer_says_which_recording_differs_and_that_nothing_is_missing(tmp_path: Path) -> None:
    bags = []
    for i in range(RUNS):
        rig = configured('cylinder_1', seed=i, supply_pressure=(5.0 + 0.3 * i) * 1e5)
        factor = WORN if i == 2 else 1.0
        bags.append(simulate(rubbing(rig, factor), 0.34, 3.0, tmp_path / f'run_{i}'))
    system_of(tmp_path, configured('cylinder_1'))
    data = checked(diagnose(bags[:4], tmp_path / 'model.yaml', bags[4:], without=causes()))
    assert data['verdict'] == 'consistent'
    assert data['sentence'].startswith('Except in run_2, model and measurement agree')
    assert {name for residual in data['where'] for name in residual['recordings']} >= {'run_2'}
    levels = {each['recording']: each['value'] for each in data['each_recording']}
    expected = {f'run_{i}': WORN if i == 2 else 1.0 for i in range(RUNS)}
    assert levels == pytest.approx(expected, abs=0.015)
    (row,) = data['differing_recordings']
    assert row['recording'] == 'run_2'
    assert f'its friction_level is {100.0 * row["difference"]:.3g} +- ' in data['sentence']


@pytest.mark.long
@pytest.mark.parametrize('factors', [(1.0,) * RUNS, (WORN,) * RUNS, (1.0, 1.0, WORN)])
def test_recordings_that_are_alike_or_few_do_not_differ(
    tmp_path: Path, factors: tuple[float, ...]
) -> None:
    assert sufficient_differences(searched(tmp_path, factors), {}) == []


def test_two_others_suffice_where_the_spread_of_earlier_recordings_is_known(
    tmp_path: Path,
) -> None:
    search = searched(tmp_path, (1.0, 1.0, WORN))
    (found,) = sufficient_differences(search, {'friction_level': 0.02})
    assert found.recording == 'run_2'
    assert found.interval[0] < WORN - 1.0 < found.interval[1]
    # as it was to be expected
    assert sufficient_differences(search, {'friction_level': WORN - 1.0}) == []


def test_spread_of_the_level_is_that_of_the_recordings(tmp_path: Path) -> None:
    factors = (0.9, 1.1, 1.0, 0.95, 1.05)
    search = searched(tmp_path, factors)
    runs = search.initial.single_runs
    found = variation(search.given, runs, search.pool)
    assert found.spreads == {'friction_level': pytest.approx(np.std(factors, ddof=1), rel=0.25)}
    rows = list(found.rows())
    assert [row['recording'] for row in rows] == [f'run_{i}' for i in range(RUNS)]
    for row, factor in zip(rows, factors, strict=True):
        low, high = row['interval']
        # one of 95 % may miss, one twice as wide does not
        assert factor == pytest.approx(0.5 * (low + high), abs=high - low)
        assert high - low < 0.05
    assert variation(search.given, runs[:3], search.pool).spreads == {}


def test_spread_of_the_supply_is_told_from_that_of_friction(tmp_path: Path) -> None:
    supplies = (0.98, 1.02, 1.01, 1.0, 0.97)
    search = searched(tmp_path, (1.0,) * RUNS, supplies)
    runs = search.initial.single_runs
    found = variation(search.given, runs, search.pool)
    assert found.spreads == {'supply_pressure': pytest.approx(np.std(supplies, ddof=1), rel=0.25)}
    for row, supply in zip(found.rows(), supplies, strict=True):
        assert row['value'] == pytest.approx(supply, abs=0.005)


def test_spread_of_values_of_one_variance_is_that_of_the_sample_beyond_it() -> None:
    values = np.array([1.0, 4.0, -2.0, 0.5, 3.0])
    for variance in (0.0, 1.0, 3.0):
        expected = np.sqrt(values.var(ddof=1) - variance)
        found = spread_between(values, np.full(values.size, variance + 1e-12))
        assert found == pytest.approx(expected, rel=1e-3)
    assert spread_between(values, np.full(values.size, 20.0)) == 0.0
