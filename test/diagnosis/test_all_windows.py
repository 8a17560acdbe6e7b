"""All windows together show a faint cause, and nothing of a true model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.search.chance import gains_by_chance
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE, LARGEST_CHANCE, Grown, score
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.executor import SerialExecutor

from .runs import configured, recorded, search_in, system_of

LOAD, MASS, STATED = 'conditions.load_mass', 2.0, 0.9
"""The true load [kg], and by what factor it is stated."""
CANDIDATES = (LOAD, 'chamber_leak', 'friction.coulomb_force', 'valve.intake_coefficient')


def run_of(system: System, seed: int, stated: float) -> Run:
    """Return a run whose load is stated by a factor of the true one."""
    recording = recorded(str(seed), configured('cylinder_1', seed=seed, load_mass=MASS))
    conditions = dict(recording.conditions)
    conditions['load_mass'] *= stated
    return prepare_run(replace(recording, conditions=conditions), system, Path(str(seed)))


def search_of(folder: Path, stated: float) -> Search:
    """Return the search of a cause in six runs, two of them held out."""
    system = system_of(folder, configured('cylinder_1'))
    runs = [run_of(system, seed, stated) for seed in range(6)]
    candidates = [each for each in pool(system, runs)[0] if each.name in CANDIDATES]
    return search_in(system.hypothesis, runs, candidates, held_out=2)


@pytest.fixture(scope='module')
def heavier(tmp_path_factory: pytest.TempPathFactory) -> Search:
    """Return the search where the load is heavier than stated."""
    return search_of(tmp_path_factory.mktemp('heavier'), STATED)


def test_all_windows_together_show_another_load(heavier: Search) -> None:
    grown = heavier.grown_by_all_windows()
    assert grown.is_better
    assert heavier.beyond_chance(grown)
    best = grown.chosen
    assert best.explanation.name == LOAD
    ((factor,),) = best.explanation.values
    assert factor == pytest.approx(1.0 / STATED, rel=0.05)


def test_of_a_true_model_they_show_nothing(tmp_path: Path) -> None:
    search = search_of(tmp_path, 1.0)
    grown = search.grown_by_all_windows()
    assert not (grown.is_better and search.beyond_chance(grown))


@pytest.mark.long
def test_what_a_cause_gains_counts_beyond_what_it_gains_by_chance(heavier: Search) -> None:
    (load,) = (each for each in heavier.pool if each.name == LOAD)
    smaller = Explanation(heavier.given)
    larger = smaller.with_part(load, load.starts[0])
    before, chosen = (score(Fit(each), heavier.data) for each in (smaller, larger))
    chosen = replace(chosen, penalty=before.penalty)
    draws, workers = np.random.default_rng(5), SerialExecutor()
    chance = max(gains_by_chance(larger, smaller, heavier.training, draws, workers))
    assert 0.0 < chance < LARGEST_CHANCE - 2.0 * DECISIVE

    def counts(improvement: float) -> bool:
        shift = (before.cost - chosen.cost - improvement) / chosen.losses.size
        gaining = replace(chosen, losses=chosen.losses + shift)
        search = replace(heavier, rng=np.random.default_rng(5))
        return search.beyond_chance(Grown([gaining], before))

    assert not counts(DECISIVE + 0.9 * chance)
    assert counts(DECISIVE + 1.1 * chance)


def test_recordings_that_differ_are_not_pooled(heavier: Search) -> None:
    runs = []
    for data in heavier.training.runs:
        run = replace(data.comparison.run, repeatability={'force': 0.5})
        runs.append(replace(data, comparison=Comparison(run)))
    training = replace(heavier.training, runs=tuple(runs))
    data = heavier.data._replace(training=training)
    assert replace(heavier, data=data).grown_by_all_windows().fits == []
