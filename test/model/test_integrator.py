"""Order, accuracy against an independent integrator, and independence of the calling pattern."""

import math
from typing import Any

import numpy as np
import pytest

from benchmarks import peers
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import rosenbrock
from pneu_rig_ros.model.parameters import (
    FADES_WHILE_SLIDING,
    FRICTION_MODELS,
    REVISED_LUGRE,
    REVISED_LUGRE_DWELL,
)
from pneu_rig_ros.model.plant import Plant

from .rigs import (
    CAPTION_COMMANDS,
    CYLINDERS,
    INTERVAL,
    changed,
    drive,
    plant_with,
    stroke,
    worst,
)

SENSOR_RANGE = 1e6
ANY_ERROR = 1e30
"""A tolerance that accepts every step: the steps are then of the longest allowed length."""
LAWS: dict[str, dict[str, Any]] = {
    'without dwell': {'model': REVISED_LUGRE},
    'with dwell': {'model': REVISED_LUGRE_DWELL},
    'fading': {'static_friction_reading': FADES_WHILE_SLIDING, 'memory_time': 0.2},
}
ONE_IN_SHORT = [
    name if name == 'cylinder_3' else pytest.param(name, marks=pytest.mark.long)
    for name in CYLINDERS
]
"""Cylinder 3 slips most often."""


def end_of_slide(step: float) -> np.ndarray:
    """State after 12 ms of being shot out, where nothing jumps and no |v| changes sign."""
    model = changed(
        'cylinder_1',
        friction={'model': FRICTION_MODELS.index('lugre')},
        operation={'initial_pressure_1': 2e5},
    )
    plant = Plant(model, tolerance=1e-9)
    drive(plant, (3.0, 2.0), 5 * INTERVAL)
    events = plant.counts['events']
    plant.tolerance, plant.longest_step = ANY_ERROR, step
    run = drive(plant, (3.1, 1.9), 10 * INTERVAL)  # new voltages: a step starts here
    assert run.velocity.min() > 0.1
    assert plant.counts['events'] == events
    return np.array([run.position[-1], run.velocity[-1], run.pressure_1[-1] / SENSOR_RANGE])


def test_observed_order_is_the_declared_one() -> None:
    steps = INTERVAL / 2 ** np.arange(3, 7)
    exact = end_of_slide(INTERVAL / 2**11)
    errors = [np.abs(end_of_slide(step) - exact).max() for step in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(rosenbrock.ORDER, abs=0.15), errors


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('cylinder', ONE_IN_SHORT)
def test_run_agrees_with_radau_at_1e_10(cylinder: str, law: str) -> None:
    duration, u = 3.0, CAPTION_COMMANDS[cylinder]
    model = changed(cylinder, friction=LAWS[law])
    plant = Plant(model, tolerance=1e-9)
    fine = stroke(plant, u, duration)
    task = peers.problem(plant, (2.5 + u, 2.5 - u))
    radau = peers.run(task, peers.scipy_solver('Radau', 1e-10), fine.time)
    usual = stroke(Plant(model), u, duration)
    assert np.count_nonzero(np.diff(fine.sticking.astype(int))) >= 1
    for run, share in ((fine, 2e-6), (usual, 1e-4)):
        assert worst(run.position, radau[:, 0], model.cylinder.stroke) < share
        assert worst(run.pressure_1, radau[:, 2], SENSOR_RANGE) < share
        assert worst(run.pressure_2, radau[:, 3], SENSOR_RANGE) < share


def test_a_run_is_the_same_to_the_last_bit_in_one_call_or_sample_by_sample() -> None:
    rng = np.random.default_rng(3)
    held = np.repeat(2.5 + rng.uniform(0.2, 0.6, 30), 40)
    voltages = np.stack([held, 5.0 - held], axis=1)
    model = changed('cylinder_2')
    whole = Plant(model).run(voltages, INTERVAL)
    single = Plant(model)
    states = [single.step(*row, INTERVAL) for row in voltages]
    for name, column in whole._asdict().items():
        assert [getattr(state, name) for state in states] == column.tolist(), name


def test_a_finer_sampling_does_not_change_the_run() -> None:
    model = changed('cylinder_2')
    coarse = drive(Plant(model), (2.84, 2.16), 2.0, 2e-3)
    fine = drive(Plant(model), (2.84, 2.16), 2.0, 1e-3)
    assert np.array_equal(coarse.position, fine.position[1::2])


def test_reset_repeats_the_run() -> None:
    plant = Plant(changed('cylinder_3'))
    first = stroke(plant, 0.32, 2.0)
    plant.reset()
    assert plant.state.time == 0.0
    second = stroke(plant, 0.32, 2.0)
    assert np.array_equal(first.position, second.position)


def test_operation_can_change_under_way() -> None:
    plant = Plant(changed('cylinder_1'))
    stroke(plant, 0.3, 0.5)
    before = plant.state
    plant.change_operation(supply_pressure=8e5)
    after = plant.step(2.8, 2.2, INTERVAL)
    assert after.pressure_1 - before.pressure_1 > 0.0
    assert after.position == pytest.approx(before.position, abs=1e-5)


def test_a_run_that_breaks_down_says_when_and_does_not_go_on_for_ever() -> None:
    plant = plant_with('inclination', math.nan)
    with pytest.raises(RigError, match='simulation failed at t = 0 s: non-finite state'):
        drive(plant, (3.0, 2.0), 2 * INTERVAL)
    with pytest.raises(RigError, match='simulation failed'):
        plant.step(3.0, 2.0, INTERVAL)
