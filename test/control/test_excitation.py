"""Excitations: the shipped files, what is refused, and the levels of each shape over time."""

import math
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.control.excitation import (
    SHAPES,
    DwellLadder,
    Ramp,
    SineSweep,
    Staircase,
    Step,
    load_excitation,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig.yaml_file import shipped


@pytest.mark.parametrize('name', shipped('excitations/*.yaml'))
def test_shipped_ones_load_and_move_something(name: str) -> None:
    excitation = load_excitation(name)
    levels = {excitation.level(excitation.duration * i / 1000) for i in range(1000)}
    assert len(levels) > 1
    assert excitation.name == name
    if excitation.drives == 'u':
        assert excitation.level(excitation.duration + 1.0) == 0.0
        assert all(abs(level) <= 2.5 for level in levels)
    else:
        assert excitation.level(excitation.duration + 1.0) == pytest.approx(
            excitation.level(excitation.duration - 1e-6), abs=1e-4
        )
        assert all(0.0 <= level <= 0.3 for level in levels)


def test_every_shape_is_shipped() -> None:
    shapes = {type(load_excitation(name).shape).__name__ for name in shipped('excitations/*.yaml')}
    assert shapes == {shape.__name__ for shape in SHAPES.values()}


STEP = """
drives: reference
shape: step
before: 0.02 m
after: 0.1 m
delay: 1.0 s
hold: 2.0 s
"""


def test_a_reference_is_in_metres(tmp_path: Path) -> None:
    path = tmp_path / 'go.yaml'
    path.write_text(STEP)
    excitation = load_excitation(path)
    assert (excitation.drives, excitation.level(0.5), excitation.level(9.0)) == (
        'reference',
        0.02,
        0.1,
    )


@pytest.mark.parametrize(
    ('before', 'after', 'told'),
    [
        ('after: 0.1 m', 'after: 0.1 V', "unit V in '0.1 V', allowed is m"),
        ('drives: reference', 'drives: u', 'allowed is V'),
        ('shape: step', 'shape: stop', "did you mean 'step'"),
        ('shape: step', '', 'missing shape'),
        ('drives: reference', 'drives: [u]', 'drives'),
        ('after: 0.1 m', 'after: 99 m', 'not within 0 to 10 m'),
        ('delay: 1.0 s', 'delay: soon', 'delay'),
        ('delay: 1.0 s', 'wait: 1.0 s', 'wait'),
        ('delay: 1.0 s\nhold: 2.0 s', 'delay: 0 s\nhold: 0 s', 'lasts 0 s'),
        (STEP, '- 1', 'expected a mapping'),
        (STEP, '{', 'not valid YAML'),
    ],
)
def test_what_is_wrong_is_named_in_one_line(
    tmp_path: Path, before: str, after: str, told: str
) -> None:
    path = tmp_path / 'wrong.yaml'
    path.write_text(STEP.replace(before, after))
    with pytest.raises(RigError) as caught:
        load_excitation(path)
    assert told in str(caught.value)
    assert str(path) in str(caught.value)
    assert '\n' not in str(caught.value)


def test_unknown_names_are_answered_with_the_known(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="did you mean 'staircase'"):
        load_excitation('stair_case')
    with pytest.raises(RigError, match='cannot be read'):
        load_excitation(tmp_path / 'none.yaml')


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
