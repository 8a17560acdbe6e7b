"""End stops: no penetration, no chatter, no energy gained."""

import numpy as np
import pytest

from pneu_rig_ros.model.parameters import FRICTION_MODELS
from pneu_rig_ros.model.plant import Plant

from .rigs import CYLINDERS, changed, drive

INTO, BACK = (5.0, 0.0), (0.0, 5.0)


@pytest.mark.parametrize('load', [0.0, 5.3])
@pytest.mark.parametrize('name', FRICTION_MODELS)
@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_piston_stops_at_both_ends(cylinder: str, name: str, load: float) -> None:
    law = {'model': FRICTION_MODELS.index(name)}
    # filled beforehand, so that the piston is shot against the stop
    operation = {'load_mass': load, 'supply_pressure': 8e5, 'initial_pressure_1': 8e5}
    plant = Plant(changed(cylinder, friction=law, operation=operation))
    stroke = plant.model.cylinder.stroke
    for volts, end, side in ((INTO, stroke, 1), (BACK, 0.0, -1)):
        run = drive(plant, volts, 4.0, 1e-4)
        assert run.position.min() >= -1e-4
        assert run.position.max() <= stroke + 1e-4
        held = run.contact == side
        assert held[-1]
        assert np.all(run.position[held] == end)
        assert np.all(run.velocity[held] == 0.0)
        first = int(np.argmax(held))
        assert side * run.velocity[first - 1] > 0.01, 'there was no impact'
        # compressed gas may throw a light piston back once or twice, but nothing chatters
        assert np.count_nonzero(np.diff(held)) <= 5
        after = np.abs(run.velocity[first:]).max()
        assert after < np.abs(run.velocity[: first + 1]).max(), 'energy gained at the stop'


def test_a_piston_pushed_gently_away_leaves_the_stop() -> None:
    plant = Plant(changed('cylinder_1'))
    drive(plant, INTO, 5.0)
    assert plant.state.contact == 1
    assert plant.state.position == plant.model.cylinder.stroke
    drive(plant, (2.0, 3.0), 2.0)
    assert plant.state.contact == 0
    assert plant.state.position < plant.model.cylinder.stroke


def test_starting_at_either_end_is_no_event() -> None:
    for position in (0.0, 0.3):
        plant = Plant(changed('cylinder_1', operation={'initial_position': position}))
        run = drive(plant, (2.5, 2.5), 1.0)
        assert np.abs(run.position - position).max() < 1e-15
        assert plant.counts['events'] == 0
