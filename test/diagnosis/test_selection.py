"""What the search makes of a true model: nothing."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.selection import Search

from .runs import configured, measured, system_of


def test_cycles_that_join_the_data_of_a_true_model_reproduce_nothing(tmp_path: Path) -> None:
    system = system_of(tmp_path, configured('cylinder_1'))
    hypothesis, rng = system.hypothesis, np.random.default_rng(0)
    runs = [measured(system, str(seed), configured('cylinder_1', seed=seed)) for seed in (0, 1)]
    training, held_out = (
        Dataset.of(hypothesis, [Comparison(run)], rng).with_cycles(hypothesis, rng) for run in runs
    )
    search = Search(given=hypothesis, training=training, held_out=held_out, rng=rng, pool=())
    assert not search.reproduced()
    friction = hypothesis.model.friction
    sticky = friction._replace(breakaway_force=2.0 * friction.breakaway_force)
    wrong = replace(hypothesis, model=hypothesis.model._replace(friction=sticky))
    assert replace(search, given=wrong).reproduced()
