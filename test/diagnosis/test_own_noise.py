"""Noise that a cause makes smaller or larger: the one is no evidence, the other hides it."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidates import Explanation, effect_candidate
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss, rms
from pneu_rig_ros.diagnosis.search.chance import noise_gains, under_own_noise
from pneu_rig_ros.diagnosis.search.fitting import fit
from pneu_rig_ros.diagnosis.search.scoring import Data, score
from pneu_rig_ros.model.parameters import HELD_TO_NEXT_BREAKAWAY, REVISED_LUGRE

from .parts import BENCH, system_file
from .runs import changed, configured, data_of, measured, runs_of, system_of

MASS, SPEED, INTERVAL, POSITION_NOISE = 20.0, 0.04, 1e-3, 3e-5


class Steady(NamedTuple):
    """A heavy carriage that a bench moves at constant speed, read with a noisy position."""

    given: Hypothesis
    data: Dataset

    def with_mass(self, mass: float) -> Hypothesis:
        """Return the hypothesis with another mass [kg]."""
        return self.given.with_parameter('cylinder', 'moving_mass', mass)

    def gain(self, other: Hypothesis) -> float:
        """Return by how much less the measured noise costs with another mass."""
        costs = []
        for hypothesis in (self.given, other):
            (residuals,) = self.data.residuals_by_run(hypothesis)
            costs.append(loss(residuals.force - residuals.force.mean()))
        return costs[0] - costs[1]


@pytest.fixture(scope='module')
def steady(tmp_path_factory: pytest.TempPathFactory) -> Steady:
    """Return the carriage, whose acceleration is zero."""
    folder = tmp_path_factory.mktemp('steady')
    text = BENCH.replace('stroke: 0.1 m', f'stroke: 0.1 m, moving_mass: {MASS} kg')
    system = load_system(system_file(folder, text))
    noise = np.random.default_rng(0).standard_normal((3, 2000))
    position = 0.01 + SPEED * INTERVAL * np.arange(2000) + POSITION_NOISE * noise[0]
    signals = {'position': position, 'pressure_2': 3e5 + noise[1], 'force': 6.0 + 0.1 * noise[2]}
    (run,) = runs_of(system, folder, [signals], INTERVAL)
    given = system.hypothesis
    return Steady(given, data_of(given, run))


def test_gain_of_a_lighter_carriage_is_that_of_the_noise(steady: Steady) -> None:
    lighter = steady.with_mass(0.5 * MASS)
    (expected,) = noise_gains([lighter], steady.given, [steady.data], np.random.default_rng(1))
    assert steady.gain(lighter) > 3.0
    assert expected == pytest.approx(steady.gain(lighter), rel=0.3)


@pytest.mark.parametrize('factor', [1.0, 2.0])
def test_mass_that_does_not_shrink_gains_nothing(steady: Steady, factor: float) -> None:
    other = steady.with_mass(factor * MASS)
    gains = noise_gains([other], steady.given, [steady.data], np.random.default_rng(1))
    assert gains == [0.0]


def test_gains_do_not_depend_on_what_else_is_judged(steady: Steady) -> None:
    masses = [steady.with_mass(factor * MASS) for factor in (0.25, 0.5, 1.0)]

    def gains(*judged: Hypothesis) -> list[float]:
        return noise_gains(judged, steady.given, [steady.data], np.random.default_rng(1))

    together = gains(*masses)
    assert together == [gains(mass)[0] for mass in masses]
    assert together[0] > together[1] > together[2] == 0.0


def test_cause_that_makes_friction_steep_is_judged_by_its_own_noise(tmp_path: Path) -> None:
    """Static friction that grows with the dwell falls steeply when the piston slips."""
    reading = {'static_friction_reading': HELD_TO_NEXT_BREAKAWAY}
    rig = changed(configured('cylinder_2'), 'friction', **reading)
    true = rig.model.friction
    system = system_of(tmp_path, changed(rig, 'friction', model=REVISED_LUGRE))
    given, rng = system.hypothesis, np.random.default_rng(0)
    first, second = (
        data_of(given, measured(system, name, replace(rig, seed=seed)), rng=rng)
        for seed, name in enumerate(('first', 'second'))
    )
    cause = effect_candidate('dwell_static_friction')
    values = 1.0, true.dwell_coefficient, true.dwell_exponent, 1.0
    explanation = Explanation(given).with_part(cause, values)
    before = score(fit(explanation, first, 1), Data(first, second))
    assert rms(first.whitened(explanation.hypothesis)) > 2.0
    after, left = under_own_noise(before, Data(first, second), 1)
    assert left < 1.2
    assert after.cost < before.cost
