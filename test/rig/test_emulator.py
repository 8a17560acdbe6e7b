"""Rig: valve drive, sensors and their noise, and what is read where sensors have effects."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.sensors import Channel, SensorSet, sensor_noise
from pneu_rig_ros.rig.valve_drive import DAC_STEP, valve_voltages

POSITION_CODE = 0.3 / 4095
PRESSURE_CODE = 1e6 / 4095


@pytest.mark.parametrize('u', [-9.0, -2.5, -0.34, 0.0, 0.1234, 2.5, 1e308])
def test_valve_voltages_are_dac_codes_within_the_range(u: float) -> None:
    for voltage, wanted in zip(valve_voltages(u), (2.5 + u, 2.5 - u), strict=True):
        assert 0.0 <= voltage <= 5.0
        assert voltage / DAC_STEP == pytest.approx(round(voltage / DAC_STEP), abs=1e-9)
        assert abs(voltage - min(max(wanted, 0.0), 5.0)) <= 0.5 * DAC_STEP + 1e-12


@pytest.mark.parametrize('u', [float('nan'), float('inf'), -float('inf')])
def test_valve_voltages_refuse_what_is_not_finite(u: float) -> None:
    with pytest.raises(ValueError, match='finite'):
        valve_voltages(u)


def outstroke(
    configuration: RigConfiguration, u: float = 0.3, count: int = 3000
) -> tuple[Rig, Floats, Floats]:
    """Return the rig, its readings and the true values, each of shape (count, 4)."""
    rig, volts = Rig(configuration), valve_voltages(u)
    samples, truth = [], []
    for _ in range(count):
        sample = rig.step(*volts)
        samples.append((sample.position, sample.velocity, sample.pressure_1, sample.pressure_2))
        state = rig.state
        truth.append((state.position, state.velocity, state.pressure_1, state.pressure_2))
    return rig, np.array(samples), np.array(truth)


def test_ideal_sensors_give_the_true_state() -> None:
    rig, samples, truth = outstroke(load_configuration('cylinder_1', sensors='ideal'))
    assert np.array_equal(samples, truth)
    assert rig.sensors.pressure_variance == 0.0


def test_rig_sensors_are_quantised_noisy_and_within_their_class() -> None:
    rig, samples, truth = outstroke(load_configuration('cylinder_1'))
    codes = samples[:, 0] / POSITION_CODE
    assert codes == pytest.approx(np.round(codes), abs=1e-6)
    codes = (samples[:, 2:] - 1e5) / PRESSURE_CODE
    assert codes == pytest.approx(np.round(codes), abs=1e-6)
    sensors = rig.configuration.sensors
    margin = 5 * sensors.position_noise + POSITION_CODE
    assert np.abs(samples[:, 0] - truth[:, 0]).max() <= 0.005 * 0.3 + margin
    margin = 5 * sensors.pressure_noise + PRESSURE_CODE
    assert np.abs(samples[:, 2:] - truth[:, 2:]).max() <= 0.01 * 1e6 + margin


def test_pressure_variance_is_that_of_the_readings() -> None:
    rig = Rig(load_configuration('cylinder_1', initial_position=0.1))
    while rig.state.pressure_1 < 1.2e5:  # at the sensor's zero the ADC would cut the noise
        rig.step(2.8, 2.5)
    rig.step(2.5, 2.5)
    readings = np.array([rig.step(2.5, 2.5).pressure_1 for _ in range(5000)][1000:])
    assert readings.var() == pytest.approx(rig.sensors.pressure_variance, rel=0.2)


def test_measured_velocity_follows_the_true_one() -> None:
    _, samples, truth = outstroke(load_configuration('cylinder_1'))
    lag = 5  # time constant of 32 Hz in samples
    error = samples[lag:, 1] - truth[:-lag, 1]
    assert np.sqrt(np.mean(error**2)) < 0.006
    assert abs(error.mean()) < 5e-4


def test_velocity_is_not_filtered_where_sampling_is_too_slow() -> None:
    sensors = load_configuration('cylinder_1').sensors
    read = SensorSet(sensors, 101325.0, 0.02, seed=0)  # a low-pass at 32 Hz would be unstable
    velocities = [read.read(0.1 + 0.1 * 0.02 * k, 0.1, 2e5, 2e5)[1] for k in range(100)]
    assert np.mean(velocities[1:]) == pytest.approx(0.1, rel=0.01)
    assert np.std(velocities[1:]) < 0.01  # differences of two readings


def test_seed_decides_noise_and_calibration() -> None:
    first, again, other = (
        outstroke(load_configuration('cylinder_1', seed=seed), count=300)[1] for seed in (5, 5, 6)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_reset_repeats_the_samples() -> None:
    rig = Rig(load_configuration('cylinder_2'))
    start = rig.sample
    first = [rig.step(2.84, 2.16) for _ in range(200)]
    assert rig.reset() == start
    assert [rig.step(2.84, 2.16) for _ in range(200)] == first
    assert [sample.index for sample in first] == list(range(1, 201))


@pytest.mark.parametrize(
    ('value', 'reading', 'saturated'), [(0.5, 0.5, False), (1.2, 1.0, True), (-0.3, 0.0, True)]
)
def test_a_channel_saturates_at_its_span_and_says_so(
    value: float, reading: float, saturated: bool
) -> None:
    channel = Channel(span=1.0, levels=4096, noise=0.0)
    assert channel.read(value, 0.0) == pytest.approx(reading, abs=1.3e-4)
    assert channel.saturated == saturated


def test_operation_changes_are_checked() -> None:
    rig = Rig(load_configuration('cylinder_1'))
    rig.change_operation(load_mass=3.0)
    assert rig.configuration.model.total_mass == pytest.approx(3.25)
    with pytest.raises(RigError, match='load_mass: -1 kg is not within'):
        rig.change_operation(load_mass=-1.0)
    with pytest.raises(RigError, match='supply_pressure'):
        rig.change_operation(supply_pressure=float('inf'))
    assert rig.configuration.model.total_mass == pytest.approx(3.25)


def test_data_sheet_counts_the_converter_in() -> None:
    sensors = load_configuration('cylinder_2').sensors
    assert sensor_noise(sensors)[0] == pytest.approx(
        np.hypot(20e-6, 0.3 / 4095 / np.sqrt(12.0)), rel=1e-6
    )


X, V, P1, P2 = range(4)


def drive(name: str, *values: float, sensors: str = 'ideal') -> tuple[Floats, Floats]:
    """Return readings and true values, each of shape (2500, 4), of an outstroke with an effect."""
    configuration = load_configuration('cylinder_1', sensors=sensors, initial_position=0.0)
    chosen = effects.nulls() | {name: effects.load(name).parameters(*values)}
    _, read, true = outstroke(replace(configuration, effects=chosen), u=0.5, count=2500)
    return read, true


def test_position_scale_scales_position_and_velocity() -> None:
    read, true = drive('position_scale', 0.02)
    assert read[:, [X, V]] == pytest.approx(1.02 * true[:, [X, V]])
    assert np.array_equal(read[:, [P1, P2]], true[:, [P1, P2]])
    assert np.ptp(true[:, X]) > 0.03


def test_bowed_position_is_wrong_between_the_ends_and_its_velocity_is_its_derivative() -> None:
    read, true = drive('position_scale', 0.0, 0.01)
    stroke = load_configuration('cylinder_1').model.cylinder.stroke
    share = true[:, X] / stroke
    bowed = 0.01 * stroke * (1.0 - (2.0 * share - 1.0) ** 2)
    assert read[:, X] - true[:, X] == pytest.approx(bowed, abs=1e-12)
    middle = 0.5 * (share[1:] + share[:-1])
    assert np.diff(read[:, X]) == pytest.approx((1.04 - 0.08 * middle) * np.diff(true[:, X]))
    assert read[:, V] == pytest.approx((1.04 - 0.08 * share) * true[:, V])


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
    for plant in (Plant(model), Plant(model, effects.nulls())):
        run = plant.run(voltages, 1.16e-3)
        assert np.array_equal(run.position_reading, run.position)
        assert np.array_equal(run.velocity_reading, run.velocity)
        assert np.array_equal(run.pressure_1_reading, run.pressure_1)
        assert np.array_equal(run.pressure_2_reading, run.pressure_2)
