"""A run along a measured one, sample by sample as a live node does it."""

import numpy as np
import pytest

from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.model.run import Impose

from .rigs import changed

INTERVAL = 1.16e-3


def test_following_in_pieces_is_following_at_once() -> None:
    model = changed('cylinder_1')
    count = 3000
    voltages = np.tile([2.8, 2.2], (count, 1))
    actions = np.zeros(count, dtype=np.int64)
    actions[[700, 1500]] = Impose.RESTART
    actions[2200] = Impose.HOLD
    actions[2600] = Impose.MOTION | Impose.PRESSURES
    measured = np.tile([0.05, 0.02, 1.6e5, 1.1e5], (count, 1))
    measured[2200, 1] = 0.001
    rests = np.maximum(np.arange(count) * INTERVAL - 0.05, 0.0)
    given = (voltages, actions, measured, rests)
    at_once = Plant(model).run_imposed(voltages, INTERVAL, *given[1:])
    plant = Plant(model)
    pieces = [
        plant.run_imposed(part[0], INTERVAL, *part[1:])
        for part in zip(*(np.split(array, [1, 2, 900, 2601]) for array in given), strict=True)
    ]
    for name, whole in at_once._asdict().items():
        joined = np.concatenate([getattr(piece, name) for piece in pieces])
        assert np.array_equal(joined, whole), name
    assert at_once.position[700] == pytest.approx(0.05, abs=1e-4)
    assert at_once.position[2200] == pytest.approx(0.05, abs=1e-5)
    assert at_once.velocity[2200] == pytest.approx(0.001, abs=5e-4)
    assert plant.state.position == at_once.position[-1]


@pytest.mark.parametrize(('stop', 'contact'), [(Impose.STOP, 1), (0, 0)])
def test_a_rest_is_at_an_end_stop_where_one_is_said_to_hold_it(stop: int, contact: int) -> None:
    model = changed('cylinder_2', operation={'initial_position': 0.1})
    near = 0.99 * model.cylinder.stroke
    run = Plant(model).run_imposed(
        np.full((1, 2), 2.5),
        INTERVAL,
        np.array([Impose.RESTART | stop]),
        np.array([[near, 0.0, 1.1e5, 1e5]]),
        np.zeros(1),
    )
    assert run.contact[0] == contact
    expected = model.cylinder.stroke if contact else near
    assert run.position[0] == pytest.approx(expected, abs=1e-4)
