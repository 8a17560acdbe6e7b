"""Rests and cycles are found in quantised, noisy positions; creep or steady motion is neither."""

from itertools import pairwise

import numpy as np
import pytest

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.analysis.motion import find_cycles, find_rests
from pneu_rig_ros.analysis.velocity import RESOLUTION
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

INTERVAL = 1.16e-3


def staircase(breakaways: list[float], slip: float, creep: float = 0.0) -> Floats:
    """Return positions [m] that step by `slip` in 60 ms at each breakaway and creep [m/s]."""
    time = np.arange(0.0, breakaways[-1] + 1.0, INTERVAL)
    steps = [0.5 - 0.5 * np.cos(np.pi * np.clip((time - t) / 0.06, 0, 1)) for t in breakaways]
    return 0.01 + slip * np.sum(steps, axis=0) + creep * time


def measured(position: Floats, seed: int = 1) -> Floats:
    """Return what a 12-bit sensor with 20 um of noise says [m]."""
    noise = np.random.default_rng(seed).normal(0.0, 2e-5, position.size)
    return RESOLUTION * np.round((position + noise) / RESOLUTION)


TIMES = [1.0, 1.6, 2.1, 2.9, 3.4, 4.4]


@pytest.mark.parametrize('slip', [0.5e-3, 2e-3, 10e-3])
@pytest.mark.parametrize('direction', [1, -1])
def test_steps_are_found_with_their_times_and_sizes(slip: float, direction: int) -> None:
    cycles = find_cycles(measured(0.1 + direction * staircase(TIMES, slip)), INTERVAL)
    assert len(cycles) == 6
    for cycle, time in zip(cycles, TIMES, strict=True):
        assert cycle.breakaway_time == pytest.approx(time, abs=0.03)
        assert cycle.slip == pytest.approx(slip, abs=0.05 * slip + 2 * RESOLUTION)
    for cycle, (before, after) in zip(cycles[1:], pairwise(TIMES), strict=True):
        assert cycle.dwell == pytest.approx(after - before - 0.06, abs=0.06)


def test_slow_creep_between_slips_is_rest_with_travel() -> None:
    cycles = find_cycles(measured(staircase(TIMES, 4e-3, creep=0.5e-3)), INTERVAL)
    assert len(cycles) == 6
    for cycle in cycles:
        assert cycle.creep == pytest.approx(0.5e-3 * cycle.dwell, abs=3 * RESOLUTION)


def test_creep_faster_than_rest_interrupts_the_dwell_but_not_the_sticking_phase() -> None:
    # at rest 0 to 1 s, creep of 2 mm/s to 1.5 s, at rest to 2.5 s; then a slip of 6 mm
    time = np.arange(0.0, 4.0, INTERVAL)
    position = 0.05 + np.interp(
        time, [0.0, 1.0, 1.5, 2.5, 2.56, 4.0], [0.0, 0.0, 1e-3, 1e-3, 7e-3, 7e-3]
    )
    (cycle,) = find_cycles(measured(position), INTERVAL)
    assert cycle.dwell == pytest.approx(2.0, abs=0.12)
    assert cycle.creep == pytest.approx(1e-3, abs=2 * RESOLUTION)
    assert cycle.slip == pytest.approx(6e-3, abs=2 * RESOLUTION)
    assert cycle.breakaway_time == pytest.approx(2.5, abs=0.03)


@pytest.mark.parametrize(('pause', 'rests'), [(0.03, 0), (0.1, 1), (0.5, 1)])
def test_rest_lasts_at_least_60_ms(pause: float, rests: int) -> None:
    time = np.arange(0.0, 2.0, INTERVAL)
    moving = np.clip(time, 0.0, 1.0) + np.clip(time - 1.0 - pause, 0.0, None)
    assert len(find_rests(measured(0.01 + 0.05 * moving), INTERVAL)) == rests


@pytest.mark.parametrize(('speed', 'at_rest'), [(0.0, True), (0.7e-3, True), (1.4e-3, False)])
def test_rest_is_slower_than_1_mm_per_second(speed: float, at_rest: bool) -> None:
    time = np.arange(0.0, 5.0, INTERVAL)
    rests = find_rests(measured(0.05 + speed * time), INTERVAL)
    share = sum(rest.end - rest.first for rest in rests) / time.size
    assert share > 0.98 if at_rest else share < 0.15


@pytest.mark.parametrize('speed', [2e-3, 1e-2, 0.1])
def test_steady_motion_has_at_most_its_breakaway(speed: float) -> None:
    time = np.arange(0.0, 5.0, INTERVAL)
    position = 0.01 + speed * np.clip(time - 1.0, 0.0, None)
    assert len(find_cycles(measured(position), INTERVAL)) <= 1


def test_piston_that_never_rests_has_no_cycle() -> None:
    time = np.arange(0.0, 5.0, INTERVAL)
    assert find_cycles(measured(0.01 + 0.02 * time), INTERVAL) == []
    assert find_rests(measured(0.01 + 0.02 * time), INTERVAL) == []


def test_resting_piston_has_no_cycle() -> None:
    assert find_cycles(measured(np.full(5000, 0.0503)), INTERVAL) == []


@pytest.mark.parametrize('size', [1, 2, 3, 10])
def test_short_record_is_taken(size: int) -> None:
    assert find_cycles(np.linspace(0.0, 1e-4, size), INTERVAL) == []


def test_peak_friction_is_that_of_each_cycle() -> None:
    position = staircase(TIMES, 4e-3)
    time = np.arange(position.size) * INTERVAL
    friction = np.interp(time, [0.0, 1.0, 1.05, 1.6, 1.65, 9.0], [0, 20.0, 5, 12.0, 5, 5])
    cycles = find_cycles(measured(position), INTERVAL, friction)
    assert cycles[0].peak_friction == pytest.approx(20.0, abs=1.0)
    assert cycles[1].peak_friction == pytest.approx(12.0, abs=1.0)


def test_quantised_sensors_give_the_cycles_of_perfect_ones(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    cycles = {}
    for sensors in ('rig', 'ideal'):
        configuration = load_configuration('cylinder_2', sensors=sensors)
        bag = simulate(configuration, 0.34, 15.0, tmp_path_factory.mktemp('bags') / sensors)
        record = read_recording(bag)
        cycles[sensors] = find_cycles(record.position, record.interval, friction_of(record))
    assert len(cycles['rig']) == len(cycles['ideal']) > 5
    for emulated, perfect in zip(cycles['rig'], cycles['ideal'], strict=True):
        # it creeps off and takes 0.3 s from 0.5 to 2 mm/s; the noise is 0.4 mm/s
        assert emulated.breakaway_time == pytest.approx(perfect.breakaway_time, abs=0.1)
        assert emulated.slip == pytest.approx(perfect.slip, abs=3e-4)
        assert emulated.peak_friction == pytest.approx(perfect.peak_friction, abs=1.0)
