"""Fitted values against those with which recordings were made, and how well they are known."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.intervals import contribution_intervals
from pneu_rig_ros.diagnosis.causes.candidate_pool import _parameter
from pneu_rig_ros.diagnosis.causes.candidates import FORCE, Explanation, effect_candidate
from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.noise import FORGOTTEN, bristle_is_known
from pneu_rig_ros.diagnosis.residuals.replicates import shrunk_mean
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.search.fitting import Fit, fit, scattered
from pneu_rig_ros.model import along
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.recording import Recording

from .parts import BENCH, LEAKING, Floats, bench_run, system_file, vessel_run
from .runs import configured, data_of, diagnosed, measured, system_of

pytestmark = pytest.mark.timeout(600)


def comparison(system: System, interval_ns: int, signals: dict[str, Floats]) -> Comparison:
    return Comparison(prepare_run(Recording('run', 0, interval_ns, signals), system, Path('run')))


@pytest.mark.parametrize(
    'seed', [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (10, 20))]
)
def test_conductance_of_a_vessel_is_within_its_interval_of_half_a_percent(
    tmp_path: Path, seed: int
) -> None:
    """The gas is 35 K warmer than the walls when the recording begins, which nobody states."""
    conductance, fills = 0.5, (6e5, 5e5, 7e5)
    runs = [vessel_run(seed + i, fill, 35.0, 0.0, conductance) for i, fill in enumerate(fills)]
    steady = 'repeatability: {gas_1: 0 kg/s}\n'  # no drift of the temperature
    (effect,) = answer(diagnosed(tmp_path, LEAKING + steady, runs, fitted=2))['effects']
    assert effect['name'] == 'wall_heat_transfer'
    row = effect['parameters']['conductance_1']
    low, high = row['interval']
    assert high - low < 0.02 * conductance
    # three times as wide: of three intervals of 95 % one in seven may miss
    assert row['value'] == pytest.approx(conductance, abs=1.5 * (high - low))
    assert row['value'] == pytest.approx(conductance, rel=6e-3)


def test_gas_that_flows_in_has_the_temperature_at_the_middle_of_an_interval(
    tmp_path: Path,
) -> None:
    """At constant inflow p and m grow in proportion to time: T = p V/(R m) in closed form."""
    system = load_system(system_file(tmp_path, LEAKING))
    gas, volume, interval, inflow = system.hypothesis.model.gas, 1e-3, 0.1, 5e-4
    k, r, supply = gas.heat_capacity_ratio, gas.gas_constant, gas.supply_temperature
    time, start = np.arange(0.0, 5.0, interval), 1.2e5
    growth = k * r * supply * inflow / volume
    shown = comparison(system, 100_000_000, {'pressure_1': start + growth * time})
    heat = effect_candidate('wall_heat_transfer')
    small = 1e-6  # W/K: it must not change the mass
    with_heat = heat.apply(system.hypothesis, (small, 0.0))
    sources = [
        shown.rates(hypothesis)[:, along.SOURCE_1] for hypothesis in (system.hypothesis, with_heat)
    ]
    middle = time[:-1] + 0.5 * interval
    mass = start * volume / (r * supply) + inflow * middle
    temperature = (start + growth * middle) * volume / (r * mass)
    expected = small * (supply - temperature) * (k - 1.0) / (k * r * supply)
    np.testing.assert_allclose(sources[1] - sources[0], expected, rtol=1e-4, atol=1e-15)


def test_number_that_the_data_do_not_show_may_be_anywhere_in_its_range(tmp_path: Path) -> None:
    system = load_system(system_file(tmp_path, BENCH))
    given, rng = system.hypothesis, np.random.default_rng(0)
    shown = comparison(system, 10_000_000, bench_run(0, 3e5, 0.0))
    dataset = Dataset.of(given, [shown], rng)
    # the law of Coulomb has no Stribeck velocity
    unused = _parameter(given.model, 'friction.stribeck_velocity', FORCE)
    start = Explanation(given).with_part(unused, (unused.model_value,))
    (low, high) = unused.coordinates[0].bounds
    assert fit(start, dataset, 3).covariance[0, 0] == pytest.approx((high - low) ** 2 / 12.0)


def test_points_around_a_fit_lie_in_a_box_of_the_shape_of_its_uncertainty() -> None:
    heat = effect_candidate('wall_heat_transfer')
    given = load_system('cylinder_1').hypothesis
    explanation = Explanation(given).with_part(heat, (1.0, 1.0))
    deviations = np.array([1e-3, 1e-1])
    points = scattered(Fit(explanation, 0.0, np.diag(deviations**2)))
    steps = np.array([point.theta - explanation.theta for point in points])
    assert np.abs(steps[:, 0]).max() == pytest.approx(0.04, rel=0.1)
    assert np.abs(steps[:, 1]).max() == pytest.approx(1.5, rel=0.1)
    assert len({point.values for point in points}) == len(points)


def test_mean_of_noise_is_shrunk_and_a_clear_one_is_kept() -> None:
    rng = np.random.default_rng(0)
    means = [shrunk_mean(rng.normal(0.0, 1.0, 90)) for _ in range(200)]
    assert np.mean(np.abs(means)) < 0.5 * np.sqrt(2.0 / np.pi / 90.0)
    assert shrunk_mean(rng.normal(5.0, 1.0, 90)) == pytest.approx(5.0, abs=0.5)


def test_seal_on_a_bench_counts_once_its_bristle_is_known(tmp_path: Path) -> None:
    system = load_system(system_file(tmp_path, BENCH))
    shown = comparison(system, 10_000_000, bench_run(0, 3e5, 0.0))
    friction = system.hypothesis.model.friction
    length = FORGOTTEN * friction.coulomb_force / sum(friction.element_stiffness)
    first = int(np.argmax(bristle_is_known(system.hypothesis, shown)))
    moved = np.abs(np.diff(shown.run.smooth[: first + 2, 0])).sum()
    assert 0.5 * length < moved < 2.0 * length


def test_a_force_larger_than_the_noise_contributes_whenever_the_piston_moves(
    tmp_path: Path,
) -> None:
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    given = system.hypothesis
    run = measured(system, 'run', rig)
    data = data_of(given, run)
    tilted = given.with_effect('inclination', library.load('inclination').parameters(0.5))
    spans = contribution_intervals(given, tilted, data)
    assert {(balance, name) for balance, name, _, _ in spans} == {('force', 'run')}
    contributes = np.zeros(run.size - 1, dtype=bool)
    for _, _, start, end in spans:
        contributes |= (run.time > start) & (run.time < end)
    # however slowly, and close to a breakaway: windows that are no evidence count as well
    assert contributes[run.velocity != 0.0].mean() > 0.9
    assert contributes[run.velocity == 0.0].mean() < 0.4


def test_nothing_contributes_where_nothing_is_added(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    data = data_of(system.hypothesis, measured(system, 'run', rig))
    assert not contribution_intervals(system.hypothesis, system.hypothesis, data)
