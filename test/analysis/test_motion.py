"""Rests, breakaways and end stops are found in readings of any noise and sampling."""

import numpy as np
import pytest

from pneu_rig_ros.analysis.motion import breakaways, end_stops, find_rests, strokes
from pneu_rig_ros.analysis.velocity import NOISE, RESOLUTION, WINDOW, window_for
from pneu_rig_ros.arrays import Floats

INTERVAL = 1.16e-3
STROKE = 0.3
PLACES = {0.0: 0.0, 1.0: 0.0, 2.0: 0.1, 3.0: 0.1, 5.0: 0.3, 7.0: 0.3, 9.0: 0.1, 10.0: 0.1}
"""Time [s] -> position [m]: at 0, out, at rest, on to L, held there, half the way back."""


def readings(noise: float = 2e-5, step: float = RESOLUTION, interval: float = INTERVAL) -> Floats:
    """Return what a sensor says of a piston that goes to ``PLACES``."""
    time = np.arange(0.0, 10.0, interval)
    position = np.interp(time, list(PLACES), list(PLACES.values()))
    return step * np.round(
        (position + np.random.default_rng(0).normal(0.0, noise, time.size)) / step
    )


CASES = [
    (2e-5, RESOLUTION, INTERVAL),
    (2e-4, RESOLUTION, INTERVAL),
    (1e-3, RESOLUTION, INTERVAL),
    (1e-5, 1e-3, INTERVAL),
    (2e-5, RESOLUTION, 10e-3),
    (3e-4, 5e-4, 5e-3),
]
"""Noise [m], step of the converter [m], interval [s]."""


@pytest.mark.parametrize(('noise', 'step', 'interval'), CASES)
def test_rests_are_found_whatever_the_sensor(noise: float, step: float, interval: float) -> None:
    position = readings(noise, step, interval)
    level = float(np.hypot(noise, step / np.sqrt(12.0)))
    found = [
        (rest.first * interval, rest.end * interval)
        for rest in find_rests(position, interval, level)
    ]
    slack = 0.06 + window_for(interval, level)
    expected = [(0.0, 1.0), (2.0, 3.0), (5.0, 7.0), (9.0, 10.0)]
    assert len(found) == len(expected), found
    for pair, true in zip(found, expected, strict=True):
        assert pair == pytest.approx(true, abs=slack)


def test_noise_that_is_taken_for_the_rigs_breaks_rests_up() -> None:
    assert len(find_rests(readings(1e-3), INTERVAL)) != 4


def test_windows_lengthen_with_noise_and_interval_only() -> None:
    assert window_for(INTERVAL) == window_for(INTERVAL, 0.1 * NOISE) == WINDOW
    assert window_for(INTERVAL, 8.0 * NOISE) == pytest.approx(4.0 * WINDOW, rel=0.15)
    assert window_for(10e-3) > WINDOW


@pytest.mark.parametrize(('noise', 'step', 'interval'), CASES)
def test_piston_at_an_end_is_held(noise: float, step: float, interval: float) -> None:
    time = np.arange(0.0, 10.0, interval)
    level = float(np.hypot(noise, step / np.sqrt(12.0)))
    position = readings(noise, step, interval)
    held = end_stops(position, STROKE, interval, None, level, step)
    inside = (time > 5.5) & (time < 6.5)
    assert np.mean(held[inside] == 1) > 0.98
    assert not held[(time < 4.5) | (time > 7.5)].any()  # nothing pushes it to 0 at first


def test_driving_force_says_whether_a_piston_is_held() -> None:
    time = np.arange(0.0, 10.0, INTERVAL)
    push = np.where(time < 1.0, -20.0, np.where(time < 6.0, 30.0, -30.0))
    held = end_stops(readings(), STROKE, INTERVAL, push)
    assert np.all(held[(time > 0.05) & (time < 0.95)] == -1)
    assert np.all(held[(time > 5.1) & (time < 5.9)] == 1)
    assert not held[time > 6.05].any()


def test_end_of_a_rest_is_a_breakaway_once_no_end_stop_holds_the_piston() -> None:
    time, read = np.arange(0.0, 10.0, INTERVAL), readings()
    rests = find_rests(read, INTERVAL)
    for let_go, count in ((6.0, 2), (8.0, 1)):
        push = np.where(time < 1.5, -20.0, np.where(time < let_go, 30.0, -30.0))
        sides = end_stops(read, STROKE, INTERVAL, push)
        found = [rest.end * INTERVAL for rest in breakaways(rests, sides, INTERVAL)]
        assert found == pytest.approx([3.0, 7.0][:count], abs=0.06)


def test_gain_error_of_the_sensor_hides_no_end_stop() -> None:
    time = np.arange(0.0, 10.0, INTERVAL)
    for gain in (0.992, 1.008):
        sides = end_stops(gain * readings(), STROKE, INTERVAL, np.full(time.size, 30.0))
        assert np.all(sides[(time > 5.1) & (time < 6.9)] == 1)


def test_strokes_end_where_the_direction_changes() -> None:
    (first, turn), (again, end) = strokes(readings(), INTERVAL)
    assert (first, end) == (0, readings().size)
    assert turn == again
    assert 5.0 <= turn * INTERVAL <= 7.05
    assert strokes(np.full(2000, 0.1), INTERVAL) == [(0, 2000)]
