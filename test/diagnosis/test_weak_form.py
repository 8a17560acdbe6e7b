"""Rates of the weak form against closed forms, and what white noise makes of them."""

import numpy as np
import pytest

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.residuals import weak_form

INTERVAL = 1.16e-3
COUNT = 1200
TIME = np.arange(COUNT + 1) * INTERVAL


def functions(power: int, size: int = 86, hop: int = 43) -> weak_form.TestFunctions:
    return weak_form.TestFunctions.of(power, size, hop, COUNT, INTERVAL)


def middles(one: weak_form.TestFunctions) -> Floats:
    """Return the middles of the windows [s]; they are symmetric."""
    middle: Floats = (one.starts + 0.5 * one.size) * INTERVAL
    return middle


@pytest.mark.parametrize('power', [2, 4])
def test_rates_of_parabolas_and_accelerations_of_cubics_are_exact(power: int) -> None:
    one = functions(power)
    np.testing.assert_allclose(
        one.rates(3.0 * TIME**2 - TIME), 6.0 * middles(one) - 1.0, rtol=0.0, atol=1e-10
    )
    cubic = 2.0 * TIME**3 + 5.0 * TIME**2
    np.testing.assert_allclose(
        one.accelerations(cubic), 12.0 * middles(one) + 10.0, rtol=0.0, atol=1e-6
    )


@pytest.mark.parametrize('power', [2, 4])
def test_rate_of_a_signal_is_the_mean_of_its_rate(power: int) -> None:
    """Integration by parts: of a sine, up to the quadrature of the interval."""
    one, omega = functions(power), 2.0 * np.pi * 8.0
    inside = 0.5 * (TIME[1:] + TIME[:-1])
    quadrature = (omega * INTERVAL) ** 2 / 24.0
    rate = one.means(omega * np.cos(omega * inside))
    assert np.abs(one.rates(np.sin(omega * TIME)) - rate).max() < 1.1 * quadrature * omega
    bend = one.means(-(omega**2) * np.sin(omega * inside))
    assert (
        np.abs(one.accelerations(np.sin(omega * TIME)) - bend).max() < 10.0 * quadrature * omega**2
    )


def test_constants_have_no_rate_and_are_their_own_mean() -> None:
    one = functions(2)
    np.testing.assert_allclose(one.means(np.full(COUNT, 7.0)), 7.0, rtol=1e-12)
    assert np.abs(one.rates(np.full(COUNT + 1, 7.0))).max() < 1e-9
    assert np.abs(one.accelerations(np.full(COUNT + 1, 7.0))).max() < 1e-6


def test_windows_lie_within_the_run_and_flags_count_throughout() -> None:
    one = functions(2)
    assert one.starts[-1] + one.size <= COUNT < one.starts[-1] + one.size + 43
    flags = np.ones(COUNT, dtype=np.bool_)
    flags[100] = False
    outside = (one.starts > 100) | (one.starts + one.size <= 100)
    np.testing.assert_array_equal(one.inside(flags), outside)


def test_a_run_shorter_than_a_window_has_none() -> None:
    short = weak_form.TestFunctions.of(2, 86, 43, 50, INTERVAL)
    assert short.means(np.ones(50)).size == 0
    assert short.rates(np.ones(51)).size == 0


@pytest.mark.parametrize('kind', ['weights', 'slope', 'curvature'])
def test_correlation_is_that_of_white_noise(kind: str) -> None:
    power, hop = (2, 43) if kind == 'slope' else (4, 20)
    one = functions(power, 86 if power == 2 else 60, hop)
    weights: Floats = getattr(one, kind)
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((4000, COUNT + 1))
    rows = np.array(
        [
            {'weights': one.means, 'slope': one.rates, 'curvature': one.accelerations}[kind](
                row[:COUNT] if kind == 'weights' else row
            )
            for row in noise
        ]
    )
    assert rows.var() == pytest.approx(float(weights @ weights), rel=0.02)
    for lag, expected in enumerate(one.correlation(weights), start=1):
        found = float(np.mean(rows[:, lag:] * rows[:, :-lag]) / rows.var())
        assert found == pytest.approx(expected, abs=0.02)
    beyond = one.correlation(weights).size + 1
    assert abs(np.mean(rows[:, beyond:] * rows[:, :-beyond]) / rows.var()) < 0.02
