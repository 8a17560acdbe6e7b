"""What the search takes for evidence of a cause: nothing of a true model, nothing weak."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, rms
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.scoring import (
    ANOTHER_CAUSE_LEAVES,
    LITTLE_LEFT,
    Data,
    Grown,
    ScoredFit,
    closes_the_gap,
    explains_alone,
    improves,
    preferred,
    remaining_share,
    score,
    stands_out,
)
from pneu_rig_ros.model import effects as library

from .runs import changed, configured, data_of, measured, search_of, system_of

COULOMB, LEAK = 'friction.coulomb_force', 3e-9


class Cycling(NamedTuple):
    """A true model, and data of two of its runs with their cycles."""

    hypothesis: Hypothesis
    training: Dataset
    held_out: Dataset
    rng: np.random.Generator


@pytest.fixture(scope='module')
def system(tmp_path_factory: pytest.TempPathFactory) -> System:
    return system_of(tmp_path_factory.mktemp('model'), configured('cylinder_1'))


@pytest.fixture(scope='module')
def cycling(system: System) -> Cycling:
    hypothesis, rng = system.hypothesis, np.random.default_rng(0)
    runs = [measured(system, str(seed), configured('cylinder_1', seed=seed)) for seed in (0, 1)]
    training, held_out = (
        data_of(hypothesis, run, rng=rng).with_cycles(hypothesis, rng) for run in runs
    )
    return Cycling(hypothesis, training, held_out, rng)


def times(hypothesis: Hypothesis, name: str, factor: float) -> Hypothesis:
    """Return a hypothesis with a parameter of friction multiplied."""
    value = factor * getattr(hypothesis.model.friction, name)
    return hypothesis.with_parameter('friction', name, value)


def caused(
    given: Hypothesis,
    system: System,
    data: Sequence[Dataset],
    name: str,
    values: tuple[float, ...],
) -> Fit:
    """Return a cause with some values as a fit."""
    runs = [comparison.run for each in data for comparison in each.comparisons]
    (cause,) = (each for each in pool(system, runs)[0] if each.name == name)
    return Fit(Explanation(given).with_part(cause, values))


def scored(*losses: float) -> ScoredFit:
    """Return a fit with losses on a training stretch and on a held-out one."""
    return ScoredFit(
        Explanation(load_system('cylinder_1').hypothesis),
        0.0,
        np.zeros((0, 0)),
        losses=np.array(losses),
        penalty=0.0,
        held_out=1,
        simulated=False,
    )


def scored_cause(system: System, cycling: Cycling, name: str, *losses: float) -> ScoredFit:
    """Return a cause with its first start and some losses."""
    runs = [comparison.run for comparison in cycling.training.comparisons]
    (cause,) = (each for each in pool(system, runs)[0] if each.name == name)
    explanation = Explanation(cycling.hypothesis).with_part(cause, cause.starts[0])
    return replace(scored(*losses), explanation=explanation)


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


@pytest.mark.parametrize(
    ('losses', 'first'),
    [
        ({'valve.intake_voltage': 0.0, 'valve_null_leak': 1.0}, 'valve_null_leak'),
        ({'valve.intake_voltage': 0.0, 'valve_null_leak': 11.0}, 'valve.intake_voltage'),
        ({'chamber_leak': 0.0, 'cross_piston_leak': 1.0}, 'cross_piston_leak'),
        ({'valve.intake_voltage': 0.0, 'valve.exhaust_voltage': 1.0}, 'valve.intake_voltage'),
    ],
)
def test_effect_goes_before_a_parameter_that_is_alike_and_one_value_before_two(
    system: System, cycling: Cycling, losses: dict[str, float], first: str
) -> None:
    by_chance = np.where(np.arange(20) % 2, 1.0, -1.0)
    fits = [
        scored_cause(system, cycling, name, *(by_chance * index + more / 20))
        for index, (name, more) in enumerate(losses.items())
    ]
    assert [part.name for part in preferred(fits).explanation.parts] == [first]


@pytest.mark.parametrize(
    ('first', 'without', 'second', 'loss', 'alone'),
    [
        ('valve_null_leak', 120.0, 'valve.intake_voltage', 15.0, True),
        ('valve_null_leak', 120.0, 'valve.intake_voltage', 5.0, False),  # as good a cause
        ('valve_null_leak', 120.0, 'valve_null_leak', 5.0, True),  # the same in another form
        ('valve_null_leak', 90.0, 'valve.intake_voltage', 15.0, False),  # weak
        ('valve.intake_voltage', 120.0, 'valve_null_leak', 15.0, False),  # a parameter
    ],
)
def test_weak_effect_stands_out_if_no_other_cause_explains_as_much(
    system: System,
    cycling: Cycling,
    first: str,
    without: float,
    second: str,
    loss: float,
    alone: bool,
) -> None:
    chosen = scored_cause(system, cycling, first, 0.0, 0.0)
    grown = Grown(
        [chosen, scored_cause(system, cycling, second, loss, 0.0)],
        scored(without / 2, without / 2),
    )
    assert grown.chosen is chosen
    assert stands_out(grown) is alone


def test_cycles_that_join_the_data_of_a_true_model_reproduce_nothing(cycling: Cycling) -> None:
    hypothesis, training, held_out, rng = cycling
    search = search_of(hypothesis, Data(training, held_out), rng)
    assert not search.reproduced()
    assert replace(
        search, base=Explanation(times(hypothesis, 'breakaway_force', 2.0))
    ).reproduced()


def test_what_is_weak_is_no_evidence_on_an_uncalibrated_rig(system: System) -> None:
    rng = np.random.default_rng(0)
    run = measured(system, 'run', configured('cylinder_1'))
    data = data_of(system.hypothesis, run, rng=rng)
    spread, found = [], []
    for factor in (1.04, 1.5):
        given = times(system.hypothesis, 'coulomb_force', factor)
        search = search_of(given, Data(data, data), rng)
        assert search.significant()
        search.calibrated = score(Fit(search.base), search.data)
        (row,) = data.residuals_by_run(given)
        spread.append(rms(np.concatenate([row.force, row.breakaway])))
        assert search.significant()
        found.append(search.strong_residuals())
    weak, strong = spread
    assert 1.1 < weak < 1.8
    assert not found[0]
    assert strong > 1.9
    assert {residual.balance for residual in found[1]} == {'force'}


def test_one_weak_cause_explains_a_balance_alone_and_one_of_two_does_not(system: System) -> None:
    """Friction 5 % off is the cause; viscous friction 20 % off beside it, or hardly any change."""
    right, rng = system.hypothesis, np.random.default_rng(0)
    runs = [measured(system, str(seed), configured('cylinder_1', seed=seed)) for seed in (0, 1)]
    data = Data(*(data_of(right, run, rng=rng) for run in runs))
    level = (right.model.friction.coulomb_force,)

    def alone(coulomb: float, viscous: float) -> bool:
        given = times(times(right, 'coulomb_force', coulomb), 'viscous_coefficient', viscous)
        return explains_alone(caused(given, system, data, COULOMB, level), given, data[0], data)

    assert alone(1.05, 1.0)
    assert not alone(1.05, 1.2)
    assert not alone(1.005, 1.0)


def test_what_a_cause_leaves_in_the_training_data_alone_is_no_evidence(system: System) -> None:
    rng, right = np.random.default_rng(0), system.hypothesis
    coulomb = right.model.friction.coulomb_force
    given = times(right, 'coulomb_force', 1.5)

    def data(factor: float, seed: int) -> Dataset:
        rig = changed(
            configured('cylinder_1', seed=seed), 'friction', coulomb_force=factor * coulomb
        )
        return data_of(right, measured(system, str(seed), rig), rng=rng)

    same, other, far = data(1.0, 0), data(1.06, 1), data(1.2, 2)
    found = caused(given, system, (same, other), COULOMB, (coulomb,))

    def significant(training: Dataset, held_out: Dataset) -> bool:
        search = search_of(given, Data(training, held_out), rng)
        assert search.significant()
        search.best = score(found, search.data)
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
        search = search_of(given, Data(training, held_out), rng)
        search.best = score(Fit(search.base), search.data)
        assert search.has_cause
        assert search.remaining() in ((0.0, 1.0) if given is hypothesis else (1.0,))
        return search.leaves_something([])

    assert not leaves_something(hypothesis)
    assert leaves_something(times(hypothesis, 'breakaway_force', 2.0))


def leaking(system: System, area: float, seed: int, rng: np.random.Generator) -> Dataset:
    """Return a run of a rig with a leak of chamber 2 [m^2]."""
    leak = library.load('chamber_leak').parameters(0.0, area)
    rig = configured('cylinder_1', {'chamber_leak': leak} if area else {}, seed=seed)
    return data_of(system.hypothesis, measured(system, str(seed), rig), rng=rng)


def test_residual_of_a_balance_on_which_no_cause_acts_is_evidence_however_small(
    system: System,
) -> None:
    """A wrong level of friction makes nearly all of the gap, a leak in one recording the rest."""
    rng = np.random.default_rng(0)
    given = times(system.hypothesis, 'coulomb_force', 3.0)
    data = Data(leaking(system, LEAK, 0, rng), leaking(system, 0.0, 1, rng))
    search = search_of(given, data, rng)
    value = (system.hypothesis.model.friction.coulomb_force,)
    search.best = score(caused(given, system, data, COULOMB, value), data)
    assert search.left_of(data[0]) < LITTLE_LEFT
    assert {residual.balance for residual in search.significant()} == {'gas_2'}


def test_cause_has_to_close_the_gap_in_the_balances_on_which_it_acts(system: System) -> None:
    """A leak closes nothing of the gap that a wrong level of friction makes, and need not."""
    rng = np.random.default_rng(0)
    given = times(system.hypothesis, 'coulomb_force', 3.0)
    data = Data(leaking(system, LEAK, 0, rng), leaking(system, LEAK, 1, rng))

    def fitted(area: float) -> Fit:
        return caused(given, system, data, 'chamber_leak', (0.0, area))

    def closes(area: float) -> bool:
        return closes_the_gap(data.held_out, given, fitted(area))

    true = fitted(LEAK).hypothesis
    assert remaining_share(data[1], given, true) > ANOTHER_CAUSE_LEAVES
    assert closes(LEAK)
    assert not closes(0.1 * LEAK)


def test_earlier_causes_are_exchanged_or_dropped_once_a_later_one_is_known(system: System) -> None:
    """A leak past the piston in place of one of a chamber, and viscous friction that is right."""
    rng, right = np.random.default_rng(0), system.hypothesis
    given = times(right, 'coulomb_force', 3.0)
    data = Data(leaking(system, LEAK, 0, rng), leaking(system, LEAK, 1, rng))
    names = 'cross_piston_leak', 'chamber_leak', 'friction.viscous_coefficient', COULOMB
    runs = [comparison.run for each in data for comparison in each.comparisons]
    candidates = {each.name: each for each in pool(system, runs)[0] if each.name in names}
    friction = right.model.friction
    values = (LEAK,), (friction.viscous_coefficient,), (friction.coulomb_force,)
    explanation = Explanation(given)
    for name, value in zip(('cross_piston_leak', *names[2:]), values, strict=True):
        explanation = explanation.with_part(candidates[name], value)
    search = search_of(given, data, rng, list(candidates.values()))
    found = search.reconsidered(score(Fit(explanation), data))
    assert set(found.explanation.causes) == {'chamber_leak', COULOMB}
    assert search.best is found
