"""Sensor effects: what the rig reads, with ideal sensors and with its own; the motion is true."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

X, V, P1, P2 = range(4)
Array = NDArray[np.float64]


def drive(name: str, *values: float, sensors: str = 'ideal') -> tuple[Array, Array]:
    """Return readings and true values, each of shape (m, 4), of an outstroke."""
    configuration = load_configuration('cylinder_1', sensors=sensors, initial_position=0.0)
    null: dict[str, Any] = {other: effects.load(other).null for other in effects.names()}
    chosen = null | {name: effects.load(name).parameters(*values)}
    rig = Rig(replace(configuration, effects=chosen))
    volts = valve_voltages(0.5)
    samples, truth = [], []
    for _ in range(2500):
        sample = rig.step(*volts)
        samples.append((sample.position, sample.velocity, sample.pressure_1, sample.pressure_2))
        state = rig.state
        truth.append((state.position, state.velocity, state.pressure_1, state.pressure_2))
    return np.array(samples), np.array(truth)


def test_position_scale_scales_position_and_velocity() -> None:
    read, true = drive('position_scale', 0.02)
    assert read[:, [X, V]] == pytest.approx(1.02 * true[:, [X, V]])
    assert np.array_equal(read[:, [P1, P2]], true[:, [P1, P2]])
    assert np.ptp(true[:, X]) > 0.03


def test_pressure_offset_shifts_each_pressure() -> None:
    read, true = drive('pressure_offset', 3e3, -2e3)
    assert read[:, P1] - true[:, P1] == pytest.approx(3e3)
    assert read[:, P2] - true[:, P2] == pytest.approx(-2e3)
    assert np.array_equal(read[:, [X, V]], true[:, [X, V]])


def test_delayed_position_is_the_true_one_through_a_low_pass() -> None:
    time_constant, interval = 0.02, 1.16e-3
    read, true = drive('sensor_delay', time_constant)
    decay = math.exp(-interval / time_constant)
    slope = time_constant / interval * (1.0 - decay)
    expected, before = 0.0, 0.0
    for i, x in enumerate(true[:, X]):  # exact for a position that is linear within an interval
        expected = decay * expected + (1.0 - slope) * x + (slope - decay) * before
        before = x
        assert read[i, X] == pytest.approx(expected, abs=5e-6)
    assert read[:, V] == pytest.approx((true[:, X] - read[:, X]) / time_constant, abs=1e-9)
    assert np.abs(read[:, X] - true[:, X]).max() > 1e-3


def test_delay_too_short_to_be_followed_is_one_of_speed_times_time() -> None:
    read, true = drive('sensor_delay', 2e-4)
    behind = true[:, X] - read[:, X]
    # of the second order is the time constant times the one that is followed, 1 ms
    assert behind == pytest.approx(2e-4 * true[:, V], abs=2e-6)
    assert behind.max() > 1e-5


def test_rig_sensors_show_the_effect_and_differentiate_what_they_read() -> None:
    read, true = drive('position_scale', 0.05, sensors='rig')
    plain, same = drive('position_scale', 0.0, sensors='rig')
    assert np.array_equal(true, same)
    assert read[-1, X] == pytest.approx(1.05 * plain[-1, X], abs=3e-4)
    moving = np.abs(plain[:, V]) > 0.02
    assert np.sum(read[moving, V]) == pytest.approx(1.05 * np.sum(plain[moving, V]), rel=0.02)


def test_readings_without_effects_are_the_true_values_bit_for_bit() -> None:
    voltages = np.tile(valve_voltages(0.5), (2000, 1))
    model = load_configuration('cylinder_1').model
    null = {name: effects.load(name).null for name in effects.names()}
    for plant in (Plant(model), Plant(model, null)):
        run = plant.run(voltages, 1.16e-3)
        assert np.array_equal(run.position_reading, run.position)
        assert np.array_equal(run.velocity_reading, run.velocity)
        assert np.array_equal(run.pressure_1_reading, run.pressure_1)
        assert np.array_equal(run.pressure_2_reading, run.pressure_2)
