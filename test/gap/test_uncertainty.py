"""The intervals told hold the truth about as often as they say, over many measured runs."""

import numpy as np
import pytest

from pneu_rig_ros.executor import Here
from pneu_rig_ros.gap.candidates import effect_candidate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import FINE_STEP, Explanation, Fit, fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.uncertainty import with_spread
from pneu_rig_ros.model import effects as library

from .runs import configured, measured

GIVEN = Hypothesis(configured('cylinder_1').model)
RUNS = 8
LEAST = 6
"""Of so many intervals of 95 % fewer hold the truth once in 170 times."""


def fitted(name: str, truth: tuple[float, ...], mode: Mode, seed: int) -> Fit:
    """Return a fit to a run with an effect hidden."""
    hidden = {name: library.load(name).parameters(*truth)}
    seen = Evidence([measured(effects=hidden, seed=seed)], np.random.default_rng(seed))
    start = Explanation().plus(effect_candidate(name), truth)
    seen.settle_floors(start.apply(GIVEN), [mode])
    result = fit(GIVEN, start, seen, (mode,), 10, FINE_STEP)
    return with_spread(result, GIVEN, seen, (mode,), Here())


@pytest.mark.parametrize(
    ('name', 'truth', 'mode'),
    [
        ('cross_piston_leak', 2e-9, Mode.CHAMBERS),
        ('inclination', 0.05, Mode.CYCLES),
    ],
)
def test_intervals_hold_the_truth_as_often_as_they_say(
    name: str, truth: float, mode: Mode
) -> None:
    told = [fitted(name, (truth,), mode, seed).intervals()[0] for seed in range(RUNS)]
    assert sum(low <= truth <= high for low, high in told) >= LEAST
