"""Whitened residuals of a true model are independent, of mean 0 and standard deviation 1."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.reading import positive_mean, unclipped
from pneu_rig_ros.diagnosis.residuals.balances import Comparison, Residuals
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss, pseudo_huber
from pneu_rig_ros.diagnosis.residuals.replicates import bench_force, inflation, simulate_replicate
from pneu_rig_ros.diagnosis.residuals.whitening import Source, whitener
from pneu_rig_ros.scenarios.hidden import CYLINDERS

from .parts import BENCH, LEAKING, bench_run, system_file
from .runs import configured, data_of, measured, runs_of, system_of

REPLICATES = 8
SUPPLIES = (5e5, 6e5)


@pytest.fixture(
    scope='module',
    params=[
        pytest.param(name, marks=[] if name == 'cylinder_2' else [pytest.mark.long])
        for name in CYLINDERS
    ],
)
def whitened(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Residuals]:
    """Return the whitened residuals of replicates of two runs."""
    name = request.param
    system = system_of(tmp_path_factory.mktemp(name), configured(name))
    runs = [
        measured(system, f'run_{i}', configured(name, seed=i, supply_pressure=supply))
        for i, supply in enumerate(SUPPLIES)
    ]
    every = []
    for seed in range(REPLICATES):
        rng = np.random.default_rng(seed)
        replicates = [Comparison(simulate_replicate(system.hypothesis, run, rng)) for run in runs]
        every += Dataset.of(system.hypothesis, replicates, rng).residuals_by_run(system.hypothesis)
    return name, Residuals(*(np.concatenate(column) for column in zip(*every, strict=True)))


@pytest.mark.parametrize('balance', ['gas_1', 'gas_2'])
def test_gas_residuals_of_a_true_model_are_noise(
    whitened: tuple[str, Residuals], balance: str
) -> None:
    z = getattr(whitened[1], balance)
    assert z.size > 500
    assert abs(z.mean()) < 0.1
    assert 0.8 < z.std() < 1.1  # a share of white noise is added, which makes it smaller
    neighbours = float(np.mean(z[1:] * z[:-1]) / z.var())
    assert abs(neighbours) < 0.2


def test_force_residuals_of_a_true_model_are_noise(whitened: tuple[str, Residuals]) -> None:
    name, residuals = whitened
    z = residuals.force
    assert z.size > 400
    assert abs(z.mean()) < 0.15
    # 0.5 N of friction: what errors of the speed make at 10 to 30 mm/s counts, 1.2 with it
    widest = 1.4 if name == 'cylinder_2' else 1.15
    assert 0.8 < z.std() < widest


@pytest.mark.parametrize(
    'other',
    [
        lambda given: given.with_parameter('gas', 'supply_temperature', 400.0),
        lambda given: given.with_parameter('cylinder', 'cap_dead_volume', 2e-3),
        lambda given: replace(given, gains=(1.0, 1.3, 1.0)),
    ],
    ids=['temperature', 'volume', 'gain'],
)
def test_noise_alone_prefers_no_hypothesis(
    tmp_path: Path, other: Callable[[Hypothesis], Hypothesis]
) -> None:
    """A tight vessel shows noise alone, whatever converts its pressure to a gas source."""
    noise = 500.0 * np.random.default_rng(0).standard_normal(4000)
    system = load_system(system_file(tmp_path, LEAKING + 'repeatability: {gas_1: 0 kg/s}\n'))
    (run,) = runs_of(system, tmp_path, [{'pressure_1': 5e5 + noise}], 0.01)
    given = system.hypothesis
    data = data_of(given, run)
    (expected,), (found,) = (data.residuals_by_run(each) for each in (given, other(given)))
    as_given, otherwise = (Comparison(run).residuals(each) for each in (given, other(given)))
    ratio = otherwise.gas_1 / as_given.gas_1
    assert abs(ratio.mean() - 1.0) > 0.2
    # a part of the variance is found by copies, and not scaled
    assert found.gas_1.std() == pytest.approx(expected.gas_1.std(), rel=0.06)


@pytest.mark.parametrize(
    ('way', 'speed', 'least'),
    # of so slow a motion the noise of the bristle is taken to be a quarter larger than it is
    [(2e-4, 4.7e-4, 0.65), (3e-4, 1.9e-3, 0.85), (2e-2, 1.3e-2, 0.85)],
)
def test_force_residuals_of_a_bench_are_noise_however_slow_it_is(
    tmp_path: Path, way: float, speed: float, least: float
) -> None:
    system = load_system(system_file(tmp_path, BENCH))
    slow = {'way': way, 'speed': speed, 'noise': 3e-6}
    signals = [bench_run(seed, 3e5, 0.0, **slow) for seed in range(6)]
    runs = runs_of(system, tmp_path, signals, 0.01)
    dataset = data_of(system.hypothesis, *runs)
    z = np.concatenate([r.force for r in dataset.residuals_by_run(system.hypothesis)])
    assert z.size > 750
    assert abs(z.mean()) < 0.1
    assert least < z.std() < 1.15


def test_modelled_force_of_a_bench_accelerates_the_mass_that_its_file_gives(
    tmp_path: Path,
) -> None:
    """Of two masses, in the same sine, it differs by M a."""
    time = 0.01 * np.arange(800)
    sine = 0.01 * np.sin(2.0 * np.pi * time)
    noise = np.random.default_rng(0).standard_normal((2, time.size))
    signals = {'position': 0.03 + sine, 'pressure_2': 3e5 + noise[0], 'force': noise[1]}
    forces = []
    for mass in (2.0, 5.0):
        text = BENCH.replace('stroke: 0.1 m', f'stroke: 0.1 m, moving_mass: {mass} kg')
        system = load_system(system_file(tmp_path, text))
        (run,) = runs_of(system, tmp_path, [signals], 0.01)
        forces.append(bench_force(system.hypothesis, Comparison(run)))
    middle = 0.5 * (sine[1:] + sine[:-1])
    expected = -3.0 * (2.0 * np.pi) ** 2 * middle
    difference = forces[1] - forces[0]
    np.testing.assert_allclose(difference[20:-20], expected[20:-20], atol=0.02)


def test_breakaways_of_a_true_model_are_within_the_noise(whitened: tuple[str, Residuals]) -> None:
    z = whitened[1].breakaway
    assert z.size > 25
    assert abs(z.mean()) < 0.5
    assert z.std() < 1.1


def test_whitening_takes_out_correlation_and_what_windows_share() -> None:
    rng = np.random.default_rng(0)
    size, lags = 400, np.array([-0.3])
    rows = rng.standard_normal((200, size + 1))
    # moving average: variance 1, neighbours correlated by lags
    a = 0.5 * (np.sqrt(1.0 + 2.0 * lags[0]) + np.sqrt(1.0 - 2.0 * lags[0]))
    b = np.sqrt(1.0 - a**2) * np.sign(lags[0])
    noise = 2.0 * (a * rows[:, 1:] + b * rows[:, :-1])
    assert np.mean(noise[:, 1:] * noise[:, :-1]) == pytest.approx(4.0 * lags[0], abs=0.05)
    white = whitener(
        np.ones(size, dtype=np.bool_), [Source(np.full(size, 4.0), lags)], np.zeros(size)
    )
    shared = np.sin(np.arange(size))[:, np.newaxis]
    common = white.with_shared(5.0 * shared)
    z = np.array([common(one + 5.0 * rng.standard_normal() * shared[:, 0]) for one in noise])
    assert z.std() == pytest.approx(1.0, abs=0.02)
    assert abs(np.mean(z[:, 1:] * z[:, :-1])) < 0.02
    # what is shared counts as one number, however many windows have it
    assert np.linalg.norm(common(50.0 * shared[:, 0])) == pytest.approx(10.0, rel=0.05)


def test_noise_that_is_cut_off_is_put_right() -> None:
    rng = np.random.default_rng(0)
    for true in (0.0, 0.5, 1.0, 3.0):
        readings = np.maximum(true + rng.standard_normal(200_000), 0.0)
        assert readings.mean() == pytest.approx(
            float(positive_mean(np.array([true]))[0]), abs=0.01
        )
        found = unclipped(np.array([1e5 + 150.0 * readings.mean()]), 1e5, 150.0)
        assert found[0] == pytest.approx(1e5 + 150.0 * true, abs=3.0)


def test_spread_is_never_less_than_the_noise_and_not_told_by_a_few() -> None:
    assert inflation(np.full(11, 9.0)) == 1.0
    assert inflation(np.full(12, 0.1)) == 1.0
    assert inflation(np.full(12, 2.0)) == pytest.approx(2.0)
    assert inflation(np.full(12, 900.0)) == pytest.approx(3.0)


def test_losses_are_half_the_squares_and_grow_linearly() -> None:
    small, large = np.array([0.01, -0.02]), np.array([1e3, 2e3])
    np.testing.assert_allclose(pseudo_huber(small), 0.5 * small**2, rtol=1e-4)
    np.testing.assert_allclose(pseudo_huber(large), 3.0 * np.abs(large), rtol=0.01)
    assert loss(small) == pytest.approx(float(pseudo_huber(small).sum()))
