"""Free runs show what no window and no cycle does, and which of two causes it is."""

from dataclasses import replace

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.cycles import Cycles, compare_cycles, compare_free_runs
from pneu_rig_ros.diagnosis.residuals.shooting import SIGNALS, MultipleShooting
from pneu_rig_ros.diagnosis.search import selection
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit
from pneu_rig_ros.diagnosis.search.free_runs import free_runs_are_off, preferred_by_free_runs
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE, ScoredFit, best_of_each, score
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.diagnosis.search.state import FREE_RUN
from pneu_rig_ros.model import effects as library

from .runs import Timeline, configured, measured, search_in, system_of

CREEPS: Timeline = ((0.34, 6.0), (0.0, 0.5), (-0.34, 5.0))
"""Many slips, out and back."""
VOLTAGE, LEAK = 'valve.intake_voltage', 'valve_null_leak'
CANDIDATES = (VOLTAGE, LEAK, 'friction.coulomb_force')
SHIFT = 4e-4
"""Of the intake voltage, half of what is significant in the residuals of these runs [V]."""
WEAK_LEAK = {'intake_area': 2e-10, 'exhaust_area': 0.0}


@pytest.fixture(scope='module')
def system(tmp_path_factory: pytest.TempPathFactory) -> System:
    return system_of(tmp_path_factory.mktemp('faint'), configured('cylinder_2'))


@pytest.fixture(scope='module')
def comparisons(system: System) -> list[Comparison]:
    """Return three runs of the true model."""
    rigs = [configured('cylinder_2', seed=seed) for seed in range(3)]
    return [Comparison(measured(system, str(r.seed), r, CREEPS)) for r in rigs]


def shifted(system: System) -> Hypothesis:
    """Return the true model with another intake voltage."""
    voltage = system.hypothesis.model.valve.intake_voltage
    return system.hypothesis.with_parameter('valve', 'intake_voltage', voltage + SHIFT)


def test_free_run_is_started_in_its_first_rest_alone(comparisons: list[Comparison]) -> None:
    for comparison in comparisons:
        free, cycles = MultipleShooting(comparison, free=True), MultipleShooting(comparison)
        counts = [np.count_nonzero(each.restarts(each.run)[0]) for each in (free, cycles)]
        assert counts[0] == 1 < counts[1]
        before = free.places[0][2] // free.block
        assert not free.weights[:before].any()
        assert (free.weights[before + 1 :] == SIGNALS).all()
        assert cycles.weights.sum() == pytest.approx(10.0 * np.unique(cycles.segments).size)


def test_vented_chamber_begins_at_the_pressure_of_the_atmosphere(
    comparisons: list[Comparison],
) -> None:
    """Its sensor reads the noise above its zero; a few pascals more would move every slip."""
    for run in (comparison.run for comparison in comparisons):
        assert run.pressures[:100].mean() > run.span.low
        operation = run.initial_operation
        assert operation.initial_pressure_1 == run.span.low == run.atmospheric_pressure
        assert operation.initial_pressure_2 == run.span.low
        filled = replace(run, pressures=run.pressures + 1e4)
        assert filled.initial_operation.initial_pressure_1 > run.span.low + 9e3


def test_free_run_of_a_true_model_leaves_the_noise_of_its_means(
    system: System, comparisons: list[Comparison]
) -> None:
    cycles = Cycles.of(system.hypothesis, comparisons, np.random.default_rng(0), free=True)
    assert cycles.losses_by_run(system.hypothesis) == pytest.approx([0.25] * 3, abs=0.15)
    assert cycles.excess(system.hypothesis) < 0.05 * cycles.excess(shifted(system))


def test_free_runs_show_more_than_cycles_and_windows(
    system: System, comparisons: list[Comparison]
) -> None:
    wrong, rng = shifted(system), np.random.default_rng(0)
    assert not compare_free_runs(system.hypothesis, comparisons, rng).significant
    free, cycles = (test(wrong, comparisons, rng) for test in (compare_free_runs, compare_cycles))
    assert free.significant
    assert free.p_value < 0.05 * cycles.p_value
    assert not search_of(system, wrong, comparisons).significant()


def test_cause_that_free_runs_alone_show_is_named(
    system: System, comparisons: list[Comparison]
) -> None:
    search = search_of(system, shifted(system), comparisons)
    best = search.run()
    assert best is not None
    assert best.explanation.name == VOLTAGE
    ((value,),) = best.explanation.values
    true = system.hypothesis.model.valve.intake_voltage
    assert value - true == pytest.approx(0.0, abs=0.5 * SHIFT)
    assert {row.regime for row in search.cycle_residuals()} == {FREE_RUN}


@pytest.mark.long
def test_faint_cause_is_named_beside_one_that_leaves_no_residual(
    system: System, comparisons: list[Comparison]
) -> None:
    friction = system.hypothesis.model.friction
    given = shifted(system).with_parameter(
        'friction', 'coulomb_force', 1.1 * friction.coulomb_force
    )
    search = search_of(system, given, comparisons)
    # a leak as weak leaves almost the same, so that the noise would decide
    search.pool = [candidate for candidate in search.pool if candidate.name != LEAK]
    best = search.run()
    assert best is not None
    assert search.training.runs_freely
    found = dict(zip(best.explanation.causes, best.explanation.values, strict=True))
    assert set(found) == {VOLTAGE, 'friction.coulomb_force'}
    assert found['friction.coulomb_force'] == (pytest.approx(friction.coulomb_force, rel=0.02),)
    true = system.hypothesis.model.valve.intake_voltage
    assert found[VOLTAGE][0] - true == pytest.approx(0.0, abs=0.5 * SHIFT)


def test_nothing_is_found_in_free_runs_of_a_true_model(
    system: System, comparisons: list[Comparison]
) -> None:
    search = search_of(system, system.hypothesis, comparisons)
    assert search.run() is None
    assert not search.cycle_residuals()
    assert search.training.cycles is None


def test_explanation_of_the_most_causes_is_kept_whatever_its_free_runs_show(
    system: System, comparisons: list[Comparison], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is fitted again as free runs choose it, and there is no room for another cause."""
    friction = system.hypothesis.model.friction
    given = system.hypothesis.with_parameter(
        'friction', 'coulomb_force', 1.5 * friction.coulomb_force
    )
    search = search_of(system, given, comparisons[:2])

    monkeypatch.setattr(selection, 'free_runs_are_off', lambda search: True)
    monkeypatch.setattr(selection, 'agreeing_with_free_runs', lambda search: None)
    monkeypatch.setattr(search, '_exchanged_by_free_runs', search._renewed)
    monkeypatch.setattr(selection, 'MOST_CAUSES', 1)
    best = search.run()
    assert search.residuals_significant
    assert best is not None
    assert best.explanation.name == 'friction.coulomb_force'
    assert best.explanation.values[0] == (pytest.approx(friction.coulomb_force, rel=0.1),)
    assert search.training.cycles is None


@pytest.mark.long
def test_free_runs_choose_among_causes_that_leave_nothing(
    system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A leak at the valve's centre, of which another intake voltage leaves no residual."""
    search, (wrong, right) = search_in_leaking_rigs(system, WEAK_LEAK)
    search.best = wrong
    assert {residual.balance for residual in search.significant()} <= {'force'}
    # a force that is significant in one of many draws of the noise is, under the truth too
    monkeypatch.setattr(search, 'strong_residuals', list)
    assert wrong.cost - right.cost < DECISIVE
    assert free_runs_are_off(search)
    chosen = preferred_by_free_runs(search, wrong)
    assert chosen.explanation.name == LEAK
    search.best = chosen
    if free_runs_are_off(search):
        again = preferred_by_free_runs(search, chosen)
        assert again.explanation.forms == chosen.explanation.forms


@pytest.mark.long
def test_free_runs_do_not_choose_a_cause_that_leaves_residuals(system: System) -> None:
    """Ten times the leak, of which another intake voltage leaves more."""
    strong = {name: 10.0 * area for name, area in WEAK_LEAK.items()}
    search, (wrong, right) = search_in_leaking_rigs(system, strong)
    assert wrong.cost - right.cost > DECISIVE
    search.best = right
    preferred_by_free_runs(search, right)  # may be another form of the leak
    assert {each.explanation.parts[0].name for each in search.ranking} == {LEAK}


def search_in_leaking_rigs(
    system: System, leak: dict[str, float]
) -> tuple[Search, list[ScoredFit]]:
    """Return the search in two runs with a leak at the centre, and fits of two causes."""
    effects = {LEAK: library.load(LEAK).parameters(**leak)}
    rigs = [configured('cylinder_2', effects, seed=seed) for seed in range(2)]
    leaking = [Comparison(measured(system, str(rig.seed), rig, CREEPS)) for rig in rigs]
    search = search_of(system, system.hypothesis, leaking)
    for law in (law for law in search.pool if law.name in (VOLTAGE, LEAK)):
        starts = [search.base.with_part(law, start) for start in law.starts]
        fits = [fit(start, search.training, ROUNDS) for start in starts]
        best = min(fits, key=lambda each: each.loss)
        search.ranking.append(score(best, search.data))
    first = {each.explanation.name: each for each in reversed(best_of_each(search.ranking))}
    return search, [first[VOLTAGE], first[LEAK]]


def search_of(system: System, given: Hypothesis, comparisons: list[Comparison]) -> Search:
    """Return the search of one of some causes in runs, the last of them held out."""
    runs = [comparison.run for comparison in comparisons]
    candidates, _ = pool(replace(system, hypothesis=given), runs)
    return search_in(given, runs, [each for each in candidates if each.name in CANDIDATES])
