"""Noise floors: of a reading, of a mean, of a whole prediction."""

import numpy as np
import pytest

from pneu_rig_ros.gap.floors import noise_floor
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.noise import mean_noise, reading_noise
from pneu_rig_ros.gap.prediction import Mode, gap, within_span

from .runs import configured, measured


@pytest.mark.parametrize('motion', [0.0, 0.02])
def test_noise_of_a_reading_is_found_beside_motion(motion: float) -> None:
    rng = np.random.default_rng(0)
    time = np.arange(5000) * 1.16e-3
    signal = motion * np.sin(2.0 * np.pi * time) + 1e-4 * rng.standard_normal(time.size)
    assert reading_noise(signal, 1e-5) == pytest.approx(1e-4, rel=0.05)


def test_a_resting_reading_within_one_code_has_the_noise_of_the_data_sheet() -> None:
    assert reading_noise(np.full(1000, 0.1), 3e-5) == 3e-5


def test_rounding_does_not_average_out() -> None:
    assert mean_noise(1.0, 0.0, 100) == pytest.approx(0.1)
    assert mean_noise(0.0, 1.0, 10**6) == pytest.approx(0.5 / np.sqrt(12.0))


def test_readings_near_the_zero_of_a_sensor_are_cut_off_on_one_side() -> None:
    experiment = measured(timeline=((0.0, 1.2),))
    zero, noise = experiment.zero, experiment.noise[1]
    true = zero + noise * np.array([-3.0, -1.0, 0.0, 1.0, 4.0])
    readings = np.column_stack([np.full(5, 0.1), true, true])
    drawn = true + noise * np.random.default_rng(1).standard_normal((200_000, 5))
    expected = np.maximum(drawn, zero).mean(axis=0)
    assert within_span(readings, experiment)[:, 1] == pytest.approx(expected, abs=0.01 * noise)


@pytest.mark.parametrize('mode', [Mode.CHAMBERS, Mode.CYCLES])
@pytest.mark.parametrize('cylinder', ['cylinder_1', 'cylinder_2', 'cylinder_3'])
def test_a_true_hypothesis_stays_within_its_noise_floor(cylinder: str, mode: Mode) -> None:
    experiment = measured(cylinder)
    truth = Hypothesis(configured(cylinder).model)
    floor = noise_floor(truth, experiment, mode, np.random.default_rng(0))
    multiples = gap(truth, experiment, mode) / floor
    columns = multiples[:, 1:] if mode is Mode.CHAMBERS else multiples
    rms = np.sqrt(np.mean(columns**2, axis=0))
    assert (rms < 1.5).all()
    assert (rms > 0.3).all()  # a floor too high would hide what is missing
