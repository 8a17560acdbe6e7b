"""Effects of another form: monotone factors, and knots where there is something to fit."""

from functools import cache

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidates import effect_candidate
from pneu_rig_ros.diagnosis.causes.shaped_effects import KNOTS, ShapedEffect, knots, shaped_effects
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.shape import Shaped

from .runs import configured, measured

RIG = configured('cylinder_1')


@cache
def measured_run() -> Run:
    """Return a run of the rig, which is not simulated before a test asks for it."""
    return measured(load_system('cylinder_1'), 'run', RIG)


def shapes_of(name: str) -> list[ShapedEffect]:
    return list(shaped_effects(effect_candidate(name), [measured_run()], 293.0))


def test_each_variable_that_drives_an_effect_has_a_rising_and_a_falling_factor() -> None:
    found = shapes_of('wall_heat_transfer')
    drivers = library.load('wall_heat_transfer').drivers
    assert [one.over for one in found] == [name for name in drivers for _ in range(2)]
    assert found[0].name == 'wall_heat_transfer over pressure'
    for rising, falling in zip(found[::2], found[1::2], strict=True):
        for shaped, sign in ((rising, 1.0), (falling, -1.0)):
            for start in shaped.starts:
                assert np.all(sign * np.diff(shaped.shape(start).times) > 0.0)


def test_factor_is_one_in_the_mean_so_that_the_size_stays_that_of_the_effect() -> None:
    shape = shapes_of('wall_heat_transfer')[0].shape((2.0, 3.0, 4.0))
    assert np.prod(shape.times) == pytest.approx(1.0)
    ratios = np.array(shape.times[1:]) / shape.times[:-1]
    assert ratios == pytest.approx([2.0, 3.0, 4.0])


def test_factor_is_put_on_the_effect_as_it_was_fitted() -> None:
    candidate = shapes_of('wall_heat_transfer')[0]
    own = library.load('wall_heat_transfer').probes[0]
    given = Hypothesis(RIG.model).with_effect('wall_heat_transfer', own)
    shaped = candidate.apply(given, (1.5,) * (KNOTS - 1)).effects['wall_heat_transfer']
    assert isinstance(shaped, Shaped)
    assert shaped.parameters == own
    again = candidate.apply(given.with_effect('wall_heat_transfer', shaped), (2.0,) * (KNOTS - 1))
    assert again.effects['wall_heat_transfer'].parameters == own


@pytest.mark.parametrize('over', ['position', 'speed', 'pressure', 'dwell', 'opening'])
def test_knots_lie_where_the_runs_were(over: str) -> None:
    at = knots(over, [measured_run()], 293.0)
    assert at is not None
    assert len(at) == KNOTS
    assert np.all(np.diff(at) > 0.0)


def test_variable_that_does_not_differ_has_no_factor() -> None:
    run = measured_run()
    still = run.with_readings(np.full(run.size, 0.1), run.pressures)
    assert knots('position', [still], 293.0) is None
