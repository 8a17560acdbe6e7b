"""What the search takes for evidence of a cause: nothing of a true model, nothing weak."""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, rms
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.remainder import ANOTHER_CAUSE_LEAVES
from pneu_rig_ros.diagnosis.search.scoring import (
    MOST_LEFT,
    ScoredFit,
    improves,
    remaining_share,
    score,
)
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.model import effects as library

from .runs import configured, measured, system_of


class Cycling(NamedTuple):
    """A true model, and data of two of its runs with their cycles."""

    hypothesis: Hypothesis
    training: Dataset
    held_out: Dataset
    rng: np.random.Generator


@pytest.fixture(scope='module')
def cycling(tmp_path_factory: pytest.TempPathFactory) -> Cycling:
    system = system_of(tmp_path_factory.mktemp('cycles'), configured('cylinder_1'))
    hypothesis, rng = system.hypothesis, np.random.default_rng(0)
    runs = [measured(system, str(seed), configured('cylinder_1', seed=seed)) for seed in (0, 1)]
    training, held_out = (
        Dataset.of(hypothesis, [Comparison(run)], rng).with_cycles(hypothesis, rng) for run in runs
    )
    return Cycling(hypothesis, training, held_out, rng)


def scored(*losses: float) -> ScoredFit:
    """Return a fit with losses on a training stretch and on a held-out one."""
    return ScoredFit(
        Explanation(),
        0.0,
        np.zeros((0, 0)),
        losses=np.array(losses),
        penalty=0.0,
        held_out=1,
        simulated=False,
    )


@pytest.mark.parametrize(
    ('training', 'held_out', 'better'),
    [
        (12.0, 5.0, True),
        (12.0, 1.0, False),  # in the training data by chance
        (5.0, 4.0, False),
        (150.0, 1.0, True),  # beyond doubt there, and nothing to be seen here
        (150.0, -1.0, False),
    ],
)
def test_cause_has_to_show_in_held_out_data_too(
    training: float, held_out: float, better: bool
) -> None:
    assert improves(scored(200.0 - training, 50.0 - held_out), scored(200.0, 50.0)) is better


def test_cycles_that_join_the_data_of_a_true_model_reproduce_nothing(cycling: Cycling) -> None:
    hypothesis, training, held_out, rng = cycling
    search = Search(given=hypothesis, training=training, held_out=held_out, rng=rng, pool=())
    assert not search.reproduced()
    friction = hypothesis.model.friction
    sticky = friction._replace(breakaway_force=2.0 * friction.breakaway_force)
    wrong = replace(hypothesis, model=hypothesis.model._replace(friction=sticky))
    assert replace(search, given=wrong).reproduced()


def test_what_is_weak_is_no_evidence_on_an_uncalibrated_rig(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    hypothesis, rng = system.hypothesis, np.random.default_rng(0)
    data = Dataset.of(hypothesis, [Comparison(measured(system, 'run', rig))], rng)
    coulomb = hypothesis.model.friction.coulomb_force
    spread, found = [], []
    for factor in (1.04, 1.5):
        given = hypothesis.with_parameter('friction', 'coulomb_force', factor * coulomb)
        search = Search(given=given, training=data, held_out=data, rng=rng, pool=())
        assert search.significant()
        nothing = Fit(Explanation())
        search.calibrated = score(nothing, given, data, data)
        (row,) = data.residuals_by_run(given)
        spread.append(rms(np.concatenate([row.force, row.breakaway])))
        assert search.significant()
        found.append(search.strong())
    weak, strong = spread
    assert 1.1 < weak < 1.8
    assert not found[0]
    assert strong > 1.9
    assert {residual.balance for residual in found[1]} == {'force'}


def test_one_weak_cause_explains_a_balance_alone_and_one_of_two_does_not(tmp_path: Path) -> None:
    """Friction 5 % off is the cause; viscous friction 20 % off beside it, or hardly any change."""
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    right, rng = system.hypothesis, np.random.default_rng(0)
    runs = [measured(system, str(seed), configured('cylinder_1', seed=seed)) for seed in (0, 1)]
    data = [Dataset.of(right, [Comparison(run)], rng) for run in runs]
    friction = right.model.friction
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'friction.coulomb_force')
    value = Explanation().with_part(cause, (friction.coulomb_force,))

    def alone(coulomb: float, viscous: float) -> bool:
        given = right
        for name, factor in (('coulomb_force', coulomb), ('viscous_coefficient', viscous)):
            given = given.with_parameter('friction', name, factor * getattr(friction, name))
        search = Search(given=given, training=data[0], held_out=data[1], rng=rng, pool=())
        search.best = score(Fit(value), given, *data)
        return search.explains_alone(given, data[0])

    assert alone(1.05, 1.0)
    assert not alone(1.05, 1.2)
    assert not alone(1.005, 1.0)


def test_what_a_cause_leaves_in_the_training_data_alone_is_no_evidence(tmp_path: Path) -> None:
    system = system_of(tmp_path, configured('cylinder_1'))
    rng, right = np.random.default_rng(0), system.hypothesis
    coulomb = right.model.friction.coulomb_force
    given = right.with_parameter('friction', 'coulomb_force', 1.5 * coulomb)

    def data(factor: float, seed: int) -> Dataset:
        rig = configured('cylinder_1', seed=seed)
        friction = rig.model.friction._replace(coulomb_force=factor * coulomb)
        rig = replace(rig, model=rig.model._replace(friction=friction))
        run = measured(system, str(seed), rig)
        return Dataset.of(right, [Comparison(run)], rng)

    same, other, far = data(1.0, 0), data(1.06, 1), data(1.2, 2)
    runs = [each.comparisons[0].run for each in (same, other)]
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'friction.coulomb_force')
    found = Fit(Explanation().with_part(cause, (coulomb,)))

    def significant(training: Dataset, held_out: Dataset) -> bool:
        search = Search(given=given, training=training, held_out=held_out, rng=rng, pool=())
        assert search.significant()
        search.best = score(found, given, training, held_out)
        return bool(search.significant())

    assert not significant(same, other)
    assert not significant(other, same)
    assert significant(other, other)
    assert significant(far, same)


def test_share_that_is_left_counts_only_if_the_cycles_of_held_out_data_are_off(
    cycling: Cycling,
) -> None:
    """Of its own cycles a true model leaves all of the excess, or has none: it is noise."""
    hypothesis, training, held_out, rng = cycling

    def leaves_something(given: Hypothesis) -> bool:
        search = Search(given=given, training=training, held_out=held_out, rng=rng, pool=())
        search.best = score(Fit(Explanation()), given, training, held_out)
        assert search.has_cause
        assert search.remaining() in ((0.0, 1.0) if given is hypothesis else (1.0,))
        return search.leaves_something([])

    friction = hypothesis.model.friction
    sticky = hypothesis.with_parameter(
        'friction', 'breakaway_force', 2.0 * friction.breakaway_force
    )
    assert not leaves_something(hypothesis)
    assert leaves_something(sticky)


def test_residual_of_a_balance_on_which_no_cause_acts_is_evidence_however_small(
    tmp_path: Path,
) -> None:
    """A wrong level of friction makes nearly all of the gap, a leak in one recording the rest."""
    system = system_of(tmp_path, configured('cylinder_1'))
    rng, right = np.random.default_rng(0), system.hypothesis
    coulomb = right.model.friction.coulomb_force
    given = right.with_parameter('friction', 'coulomb_force', 3.0 * coulomb)
    leak = library.load('chamber_leak').parameters(0.0, 3e-9)

    def data(effects: dict[str, Any], seed: int) -> Dataset:
        run = measured(system, str(seed), configured('cylinder_1', effects, seed=seed))
        return Dataset.of(right, [Comparison(run)], rng)

    training, held_out = data({'chamber_leak': leak}, 0), data({}, 1)
    runs = [each.comparisons[0].run for each in (training, held_out)]
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'friction.coulomb_force')
    search = Search(given=given, training=training, held_out=held_out, rng=rng, pool=())
    found = Fit(Explanation().with_part(cause, (coulomb,)))
    search.best = score(found, given, training, held_out)
    assert search.left_of(training) < MOST_LEFT
    assert {residual.balance for residual in search.significant()} == {'gas_2'}


def test_cause_has_to_close_the_gap_in_the_balances_on_which_it_acts(tmp_path: Path) -> None:
    """A leak closes nothing of the gap that a wrong level of friction makes, and need not."""
    system = system_of(tmp_path, configured('cylinder_1'))
    rng, right = np.random.default_rng(0), system.hypothesis
    coulomb = right.model.friction.coulomb_force
    given = right.with_parameter('friction', 'coulomb_force', 3.0 * coulomb)
    leak = library.load('chamber_leak').parameters(0.0, 3e-9)

    def data(seed: int) -> Dataset:
        rig = configured('cylinder_1', {'chamber_leak': leak}, seed=seed)
        return Dataset.of(right, [Comparison(measured(system, str(seed), rig))], rng)

    training, held_out = data(0), data(1)
    runs = [each.comparisons[0].run for each in (training, held_out)]
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'chamber_leak')
    search = Search(given=given, training=training, held_out=held_out, rng=rng, pool=())

    def closes(area: float) -> bool:
        found = Fit(Explanation().with_part(cause, (0.0, area)))
        return search.closes_the_gap(given, score(found, given, training, held_out))

    leaking = cause.apply(given, (0.0, 3e-9))
    assert remaining_share(held_out, given, leaking) > ANOTHER_CAUSE_LEAVES
    assert closes(3e-9)
    assert not closes(3e-10)
