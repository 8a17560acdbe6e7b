"""The residual of each balance: under a true hypothesis it is the noise, whatever the law."""

import numpy as np
import pytest

from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.where import force_residual
from pneu_rig_ros.model.parameters import FRICTION_MODELS

from .runs import configured, measured


@pytest.mark.parametrize('law', FRICTION_MODELS)
@pytest.mark.parametrize('cylinder', ['cylinder_1', 'cylinder_2'])
def test_forces_on_the_sliding_piston_balance_under_every_law(cylinder: str, law: str) -> None:
    configuration = configured(cylinder, friction=law)
    experiment = measured(cylinder, friction=law, timeline=((0.5, 1.5), (0.0, 0.7), (-0.5, 2.0)))
    residual = force_residual(Hypothesis(configuration.model), experiment)
    seen = np.isfinite(residual.values)
    assert seen.sum() > 10
    rms = float(np.sqrt(np.mean(residual.values[seen] ** 2)))
    assert 0.1 < rms / residual.noise[0] < 3.0
