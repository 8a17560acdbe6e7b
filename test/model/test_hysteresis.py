"""F(z): Masing's rule, closing of minor loops, wiping-out, and the same inside a run."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pneu_rig_ros.model import friction
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.parameters import FILM_PRINTED, HELD_TO_NEXT_BREAKAWAY
from pneu_rig_ros.model.plant import Plant

from .rigs import changed, drive, worst

STIFFNESS = (4e4, 3e4, 2e4, 1e4)
LIMIT = (2.0, 4.0, 6.0)
LAW = compiled_model(
    changed('cylinder_1', friction={'element_stiffness': STIFFNESS, 'element_limit': LIMIT})
).friction


def follow(path: list[float]) -> list[float]:
    """Return F(z) at the turning points and the end of a path that starts at rest in z = 0."""
    anchors = np.zeros(len(STIFFNESS))
    forces = []
    for deflection in path:
        forces.append(friction.bristle_force(deflection, anchors, LAW)[0])
        friction.drag_anchors(deflection, anchors, LAW)
    return forces


def virgin(deflection: float) -> float:
    """The virgin curve written down from the elements."""
    slipping = sum(min(k * deflection, w) for k, w in zip(STIFFNESS[:-1], LIMIT, strict=True))
    return slipping + STIFFNESS[-1] * deflection


@given(st.floats(0.0, 1e-3))
def test_virgin_curve(deflection: float) -> None:
    assert follow([deflection])[0] == pytest.approx(virgin(deflection), abs=1e-12)
    assert follow([-deflection])[0] == pytest.approx(-virgin(deflection), abs=1e-12)


@given(st.floats(1e-6, 1e-3), st.floats(0.0, 1.0))
def test_reversal_curve_obeys_masing(turn: float, share: float) -> None:
    back = turn - 2 * turn * share  # down to -turn, where the virgin curve is met again
    expected = virgin(turn) - 2 * virgin((turn - back) / 2)
    assert follow([turn, back])[1] == pytest.approx(expected, abs=1e-9)


@given(st.floats(-4e-4, 4e-4), st.floats(-4e-4, 4e-4), st.floats(-4e-4, 4e-4))
def test_minor_loops_close(a: float, b: float, c: float) -> None:
    low, middle, high = sorted((a, b, c))
    before = follow([high, low, middle])
    after = follow([high, low, middle, 0.5 * (low + middle), middle])
    assert after[-1] == pytest.approx(before[-1], abs=1e-9)


@given(st.lists(st.floats(-3e-4, 3e-4), min_size=1, max_size=8))
def test_a_larger_loop_wipes_out_the_smaller_ones(inner: list[float]) -> None:
    plain = follow([5e-4, -5e-4, 5e-4, 1e-4])
    busy = follow([5e-4, *inner, -5e-4, 5e-4, 1e-4])
    assert busy[-1] == pytest.approx(plain[-1], abs=1e-9)


def test_one_element_is_a_linear_spring() -> None:
    law = compiled_model(changed('cylinder_1', friction={'element_stiffness': (5e4,)})).friction
    for deflection in (-1e-4, 0.0, 3e-4):
        force = friction.bristle_force(deflection, np.zeros(1), law)
        assert force == (5e4 * deflection, 5e4)


def shaken(tolerance: float) -> NDArray[np.float64]:
    """Bristle force of a piston that is pushed to and fro without breaking away."""
    friction = {'element_stiffness': STIFFNESS, 'element_limit': (1.0, 1.5, 2.0)}
    operation = {'initial_position': 0.15}
    plant = Plant(
        changed('cylinder_1', friction=friction, operation=operation), tolerance=tolerance
    )
    swings = [drive(plant, volts, 0.3) for volts in ((2.8, 2.5), (2.5, 2.8)) * 3]
    assert all(run.sticking.all() for run in swings)
    return np.concatenate([run.position for run in swings])


def test_a_run_remembers_reversals_whatever_its_steps() -> None:
    fine, coarse = shaken(1e-9), shaken(1e-7)
    assert np.count_nonzero(np.diff(np.sign(np.diff(fine)))) >= 5
    assert worst(fine, coarse, np.ptp(fine)) < 0.002


def test_steady_sliding_with_slipping_elements_does_not_stall_the_steps() -> None:
    friction = {
        'element_stiffness': (1.36e5, 2.21e5, 1.43e5),
        'element_limit': (5.2, 0.51),
        'fluid_time_constant': 0.246,
        'stop_velocity': 0.002,
        'start_velocity': 0.02,
        'static_friction_reading': HELD_TO_NEXT_BREAKAWAY,
        'film_reading': FILM_PRINTED,
    }
    plant = Plant(changed('cylinder_3', friction=friction), tolerance=1e-5)
    run = drive(plant, (2.82, 2.18), 30.0)
    assert run.position[-1] > 0.05
    assert plant.counts['steps'] + plant.counts['rejected'] < 30_000
