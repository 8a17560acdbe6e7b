"""What no experiment tells apart: the proof of docs/diagnose.md, by numbers."""

import numpy as np
import pytest

from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, predict
from pneu_rig_ros.model import effects

from .runs import configured, measured


@pytest.mark.parametrize('cylinder', ['cylinder_1', 'cylinder_2', 'cylinder_3'])
@pytest.mark.parametrize('mode', [Mode.CYCLES, Mode.FREE])
def test_fluid_inertia_is_an_added_mass(cylinder: str, mode: Mode) -> None:
    run, time_constant = measured(cylinder), 0.01
    given = Hypothesis(configured(cylinder).model)
    mass = given.model.friction.viscous_coefficient * time_constant
    fluid = given.with_effect(
        'fluid_inertia', effects.load('fluid_inertia').parameters(time_constant)
    )
    heavy = given.with_parameter(
        'cylinder', 'moving_mass', given.model.cylinder.moving_mass + mass
    )
    plain, one, other = (predict(which, run, mode).readings for which in (given, fluid, heavy))
    same, moved = (np.abs(which - one).max(axis=0) for which in (other, plain))
    assert np.all(same < 1e-3 * moved)
