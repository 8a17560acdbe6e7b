"""What the tests of the diagnosis share."""

from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np
import pytest

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.along import MOVES
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration


@pytest.fixture(autouse=True, scope='session')
def _compiled_once(one_worker: Callable[[str], AbstractContextManager[None]]) -> None:
    """Let one worker compile the plants of all diagnoses."""
    model = load_configuration('cylinder_1').model
    measured, voltages = np.full((2, 3), 1e5), np.full((1, 2), 2.5)
    with one_worker('plants'):
        for chosen in ({}, effects.nulls()):
            plant = Plant(model, chosen)
            plant.run(voltages, 1e-3)
            plant.along(measured, np.zeros(1), np.full(1, MOVES), voltages, 1e-3)
