"""The shapes of excitations: levels at the times at which something happens."""

import math

import numpy as np
import pytest

from pneu_rig_ros.control.excitation import DwellLadder, Ramp, SineSweep, Staircase, Step


def test_step_changes_after_its_delay() -> None:
    step = Step(before=0.1, after=0.4, delay=2.0, hold=3.0)
    assert step.duration == 5.0
    assert [step.level(t) for t in (0.0, 1.999, 2.0, 4.9)] == [0.1, 0.1, 0.4, 0.4]


def test_ramp_is_linear_and_holds_its_ends() -> None:
    ramp = Ramp(start=-1.0, end=1.0, delay=1.0, rise=4.0, hold=2.0)
    assert ramp.duration == 7.0
    assert [ramp.level(t) for t in (0.5, 1.0, 2.0, 3.0, 5.0, 6.5)] == [-1, -1, -0.5, 0, 1, 1]


def test_staircase_holds_each_level() -> None:
    stairs = Staircase(levels=(0.0, 0.3, -0.3), hold=2.0)
    assert stairs.duration == 6.0
    assert [stairs.level(t) for t in (0.0, 1.9, 2.0, 5.9, 6.0)] == [0, 0, 0.3, -0.3, -0.3]


@pytest.mark.parametrize(('first', 'last'), [(0.5, 8.0), (2.0, 2.0), (5.0, 1.0)])
def test_sweep_runs_through_its_frequencies(first: float, last: float) -> None:
    sweep = SineSweep(
        offset=1.0, amplitude=2.0, start_frequency=first, end_frequency=last, sweep=10.0
    )
    times = np.linspace(0.0, 10.0, 200_001)
    levels = np.array([sweep.level(t) for t in times])
    assert (levels.max(), levels.min()) == (pytest.approx(3.0), pytest.approx(-1.0))
    rising = np.flatnonzero((levels[:-1] < 1.0) & (levels[1:] >= 1.0))
    periods = np.diff(times[rising])
    middles = 0.5 * (times[rising][1:] + times[rising][:-1])
    expected = first * (last / first) ** (middles / 10.0)
    assert 1.0 / periods == pytest.approx(expected, rel=0.06)
    assert math.isclose(sweep.level(0.0), 1.0)


def test_ladder_rests_longer_each_time_and_moves_equally() -> None:
    ladder = DwellLadder(rest=0.0, drive=0.5, move=1.0, dwells=(0.5, 2.0, 4.0))
    assert ladder.duration == 9.5
    times = np.arange(0.0, 9.5, 0.01) + 0.005
    driven = np.array([ladder.level(t) == 0.5 for t in times])
    edges = np.flatnonzero(np.diff(driven)) * 0.01 + 0.01
    assert edges == pytest.approx([0.5, 1.5, 3.5, 4.5, 8.5])
    assert driven[-1]
