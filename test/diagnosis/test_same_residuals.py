"""Simulation decides among causes that residuals hardly distinguish."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit
from pneu_rig_ros.diagnosis.search.scoring import score
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.model import effects as library

from .runs import Timeline, configured, measured, system_of

COULOMB = 'friction.coulomb_force'
CREEPS: Timeline = ((0.34, 5.0), (0.0, 0.5), (-0.34, 4.0))
SEAL = {'limit': 2.0, 'reach': 4e-4}


def search_of(folder: Path, name: str, values: dict[str, float], *candidates: str) -> Search:
    """Return the search in three runs of a rig with an effect, of which the model lacks it."""
    hidden = {name: library.load(name).parameters(**values)}
    system = system_of(folder, configured('cylinder_2'))
    rigs = [configured('cylinder_2', hidden, seed=seed) for seed in range(3)]
    runs = [measured(system, str(rig.seed), rig, CREEPS) for rig in rigs]
    rng = np.random.default_rng(0)
    training, held_out = (
        Dataset.of(system.hypothesis, [Comparison(run) for run in part], rng)
        for part in (runs[:2], runs[2:])
    )
    found, _ = pool(system, runs)
    chosen = [candidate for candidate in found if candidate.name in candidates]
    assert len(chosen) == len(candidates)
    return Search(
        given=system.hypothesis, training=training, held_out=held_out, rng=rng, pool=chosen
    )


def test_cycles_exchange_a_cause_for_one_that_residuals_hardly_distinguish(tmp_path: Path) -> None:
    search = search_of(tmp_path, 'seal_elasticity', SEAL, 'seal_elasticity', COULOMB)
    fits = {}
    for cause in search.pool:
        starts = [Explanation().with_part(cause, values) for values in cause.starts]
        each = [fit(start, search.given, search.training, ROUNDS) for start in starts]
        best = min(each, key=lambda fitted: fitted.loss)
        fits[cause.name] = score(best, search.given, search.training, search.held_out)
    search.best, search.indistinct = fits[COULOMB], [fits['seal_elasticity'].explanation]
    search.add_cycles()
    assert search.exchanged_by_cycles()
    assert search.best.explanation.name == 'seal_elasticity'
    search.indistinct = [fits[COULOMB].explanation]
    assert not search.exchanged_by_cycles()
