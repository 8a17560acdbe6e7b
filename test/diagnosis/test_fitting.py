"""Fits of causes whose loss has several minima."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.residuals.dataset import loss
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit, over_ridges
from pneu_rig_ros.diagnosis.search.screening import changes, screen
from pneu_rig_ros.executor import SerialExecutor
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.scenarios.experiments import FIT, levels, set_up

from .runs import configured, data_of, measured, system_of


def test_a_weakly_damped_load_is_found_beyond_the_ridges_of_its_phases(tmp_path: Path) -> None:
    compliance, damping, heavy = 3e-4, 5.0, FIT[2]
    effect = library.load('load_compliance')
    system = system_of(tmp_path, configured('cylinder_1'))
    given = system.hypothesis
    stroke = given.model.cylinder.stroke
    hidden = {'load_compliance': effect.parameters(compliance, damping)}
    rig = configured('cylinder_1', hidden, **set_up(heavy, 'cylinder_1', stroke))
    timeline = tuple((u, time) for time, u in levels(heavy, 'cylinder_1'))
    runs = [measured(system, 'run', rig, timeline)]
    data = data_of(given, *runs)
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'load_compliance')

    start = Explanation(given).with_part(cause, (1.02 * compliance, 4.0 * damping))
    near = fit(start, data, ROUNDS)
    best = over_ridges(near, data, SerialExecutor())
    assert near.explanation.values[0][1] > 2.0 * damping  # a fit alone does not cross them
    assert best.loss < 0.6 * near.loss
    np.testing.assert_allclose(best.explanation.values[0], (compliance, damping), rtol=0.1)


def test_other_causes_help_a_candidate_within_their_bounds_alone(tmp_path: Path) -> None:
    """Of a level of friction that is 50 % too high: it may fall with the candidate, or not."""
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    right = system.hypothesis
    runs = [measured(system, 'run', rig)]
    data = data_of(right, *runs)
    found = {each.name: each for each in pool(system, runs)[0]}
    level = found['friction.coulomb_force']
    viscous = found['friction.viscous_coefficient']
    wrong = right.with_parameter('friction', 'coulomb_force', 1.5 * level.model_value)
    base = Explanation(right).with_part(level, (1.5 * level.model_value,))
    residual, free = data.residual(wrong), changes(base, data)

    def left(room: float) -> float:
        sides = np.array([-room]), np.array([room])
        return screen(viscous, wrong, data, residual, free, sides).loss

    nothing = np.zeros((residual.size, 0)), (np.zeros(0), np.zeros(0))
    alone = screen(viscous, wrong, data, residual, *nothing).loss
    assert left(0.0) == pytest.approx(alone, rel=1e-9)
    assert left(1.0) < 0.5 * alone
    low, high = base.bounds
    assert low < base.theta < high


def test_weak_cause_of_a_curved_law_is_screened_as_what_it_is(tmp_path: Path) -> None:
    """A Stribeck curve of 1/25 of the weakest start, whose change is no multiple of that."""
    rig = configured('cylinder_1', friction='coulomb_viscous')
    system = system_of(tmp_path, rig)
    given = system.hypothesis
    curve = library.load('stribeck').parameters(0.08, 0.016, 1.3)
    runs = [measured(system, 'run', replace(rig, effects={'stribeck': curve}))]
    data = data_of(given, *runs)
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'stribeck')
    residual, nothing = data.residual(given), (np.zeros(0), np.zeros(0))
    found = screen(cause, given, data, residual, np.zeros((residual.size, 0)), nothing)
    excess = loss(residual) - loss(data.residual(cause.apply(given, tuple(curve))))
    assert excess > 10.0
    assert loss(residual) - found.loss > 0.5 * excess


def test_strength_that_the_residuals_show_is_a_start_beside_simulated_cycles(
    tmp_path: Path,
) -> None:
    """A cushion of a fifth of the weakest probe: in simulation each probe is worse than none."""
    cushion = library.load('end_cushion').parameters(0.01, 100.0, 10.0)
    system = system_of(tmp_path, configured('cylinder_1'))
    given, rng = system.hypothesis, np.random.default_rng(0)
    # creep into the cushion of the outer end, back, and into it once more
    timeline = ((0.34, 4.0), (0.0, 1.0), (-0.45, 2.0), (0.34, 2.5), (0.0, 1.0))
    rig = configured('cylinder_1', {'end_cushion': cushion}, initial_position=0.275)
    runs = [measured(system, 'run', rig, timeline)]
    data = data_of(given, *runs, rng=rng).with_cycles(given, rng)
    (cause,) = (each for each in pool(system, runs)[0] if each.name == 'end_cushion')

    residual, nothing = data.residual(given), (np.zeros(0), np.zeros(0))
    found = screen(cause, given, data, residual, np.zeros((residual.size, 0)), nothing)
    probes = [loss(data.residual(cause.apply(given, probe))) for probe in cause.starts]
    assert found.loss < loss(residual) < min(probes)
    again = loss(data.residual(cause.apply(given, found.starts[0])))
    assert found.loss == pytest.approx(again, rel=1e-9)  # sums of arrays round by their place
    length, stiffness, damping = found.starts[0]
    assert (length, stiffness / damping) == (0.01, pytest.approx(10.0))
    assert 20.0 < stiffness < 250.0
