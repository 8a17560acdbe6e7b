"""The noise of a sensor, estimated from its readings."""

import numpy as np
import pytest

from pneu_rig_ros.records.reading_noise import noise_of, reading_noise, smallest_step


@pytest.mark.parametrize('motion', [0.0, 0.02])
def test_noise_of_a_reading_is_found_beside_motion(motion: float) -> None:
    rng = np.random.default_rng(0)
    time = np.arange(5000) * 1.16e-3
    signal = motion * np.sin(2.0 * np.pi * time) + 1e-4 * rng.standard_normal(time.size)
    assert reading_noise(signal, 1e-5) == pytest.approx(1e-4, rel=0.05)
    assert noise_of(signal) == pytest.approx(1e-4, rel=0.05)


def test_a_resting_reading_within_one_code_has_the_noise_of_the_data_sheet() -> None:
    assert reading_noise(np.full(1000, 0.1), 3e-5) == 3e-5


@pytest.mark.parametrize('step', [1e-5, 1e-3])
def test_step_of_a_converter_is_seen_and_is_the_least_noise(step: float) -> None:
    read = step * np.round(np.linspace(0.0, 0.1, 50_000) / step)
    assert smallest_step(read) == pytest.approx(step, rel=1e-6)
    assert noise_of(read) == pytest.approx(step / np.sqrt(12.0), rel=0.7)
    assert noise_of(read) >= 0.999 * step / np.sqrt(12.0)


def test_gaps_and_constants_have_no_step() -> None:
    assert smallest_step(np.full(10, np.nan)) == smallest_step(np.full(10, 2.5)) == 0.0
    assert noise_of(np.full(10, np.nan)) == noise_of(np.array([1.0])) == 0.0
