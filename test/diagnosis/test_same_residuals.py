"""Simulation decides among causes that residuals hardly distinguish."""

import pytest

from pneu_rig_ros.diagnosis.answer.alternatives import indistinguishable
from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit
from pneu_rig_ros.diagnosis.search.scoring import score
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.model import effects as library

from .runs import Timeline, configured, measured, search_in, system_of

ELASTIC, COULOMB = 'seal_elasticity', 'friction.coulomb_force'
CREEPS: Timeline = ((0.34, 1.5), (0.0, 0.5), (-0.34, 1.2))


@pytest.fixture(scope='module')
def search(tmp_path_factory: pytest.TempPathFactory) -> Search:
    """Return the search in two runs of a rig with an elastic seal, which its model lacks."""
    hidden = {ELASTIC: library.load(ELASTIC).parameters(limit=2.0, reach=4e-4)}
    system = system_of(tmp_path_factory.mktemp('seal'), configured('cylinder_2'))
    rigs = [configured('cylinder_2', hidden, seed=seed) for seed in range(2)]
    runs = [measured(system, str(rig.seed), rig, CREEPS) for rig in rigs]
    causes = [each for each in pool(system, runs)[0] if each.name in (ELASTIC, COULOMB)]
    return search_in(system.hypothesis, runs, causes)


@pytest.mark.long
def test_cycles_exchange_a_cause_for_one_that_residuals_hardly_distinguish(search: Search) -> None:
    fits = {}
    for cause in search.pool:
        starts = [search.base.with_part(cause, values) for values in cause.starts]
        each = [fit(start, search.training, ROUNDS) for start in starts]
        best = min(each, key=lambda fitted: fitted.loss)
        fits[cause.name] = score(best, search.data)
    search.best, search.indistinct = fits[COULOMB], [fits[ELASTIC].explanation]
    search.ranking = list(fits.values())
    search.add_cycles()
    assert search.exchanged_by_cycles()
    assert search.best.explanation.name == ELASTIC
    assert indistinguishable(search, search.best) == []
    search.indistinct = [fits[COULOMB].explanation]
    assert not search.exchanged_by_cycles()
