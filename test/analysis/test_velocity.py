"""The velocity from measured positions: exact for polynomials, its noise, the peak of a slip."""

import numpy as np
import pytest

from pneu_rig_ros.analysis.velocity import (
    CUBIC,
    NOISE,
    WINDOW,
    adaptive_velocity,
    speed_noise,
    velocity_of,
)

INTERVAL = 1.16e-3
TIME = INTERVAL * np.arange(1000)
INSIDE = slice(60, -60)


@pytest.mark.parametrize('degree', [1, CUBIC])
def test_polynomial_of_a_degree_has_its_exact_slope(degree: int) -> None:
    slope = velocity_of((TIME - 0.3) ** degree, INTERVAL, WINDOW, degree)[INSIDE]
    true = degree * (TIME[INSIDE] - 0.3) ** (degree - 1)
    np.testing.assert_allclose(slope, true, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize('degree', [1, CUBIC])
def test_noise_of_a_slope_is_that_of_least_squares(degree: int) -> None:
    readings = NOISE * np.random.default_rng(0).standard_normal((200, TIME.size))
    slopes = np.array([velocity_of(each, INTERVAL, WINDOW, degree) for each in readings])
    expected = speed_noise(WINDOW, INTERVAL, NOISE, degree)
    assert slopes[:, INSIDE].std() == pytest.approx(expected, rel=0.05)


def test_cubics_keep_the_peak_of_a_slip_that_lines_of_the_same_noise_flatten() -> None:
    """50 mm/s for 0.1 s: lines half as long as cubics leave the same noise."""
    peak, width = 0.05, 0.05
    phase = np.clip((TIME - 0.5) / width, -1.0, 1.0)
    true = 0.5 * peak * (1.0 + np.cos(np.pi * phase))
    position = 0.5 * peak * width * (1.0 + phase + np.sin(np.pi * phase) / np.pi)
    rng, errors = np.random.default_rng(0), []
    for shortest, degree in ((0.5 * WINDOW, 1), (WINDOW, CUBIC)):
        fits = [
            adaptive_velocity(position + NOISE * rng.standard_normal(TIME.size), *each)
            for each in [(INTERVAL, shortest, NOISE, degree)] * 40
        ]
        errors.append(np.abs(np.mean(fits, axis=0) - true).max())
    of_lines, of_cubics = errors
    assert of_cubics < 0.8 * of_lines
