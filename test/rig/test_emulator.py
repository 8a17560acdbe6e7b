"""Rig: valve drive, sensors, and the samples that come out."""

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.sensors import Channel
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


def run(count: int = 3000, **overrides: object) -> tuple[Rig, np.ndarray, np.ndarray]:
    """Return the rig, its samples and the true states of an outstroke."""
    rig = Rig(load_configuration('cylinder_1', **overrides))
    volts = valve_voltages(0.3)
    samples, truth = [], []
    for _ in range(count):
        sample = rig.step(*volts)
        samples.append((sample.position, sample.velocity, sample.pressure_1, sample.pressure_2))
        state = rig.state
        truth.append((state.position, state.velocity, state.pressure_1, state.pressure_2))
    return rig, np.array(samples), np.array(truth)


def test_ideal_sensors_give_the_true_state() -> None:
    rig, samples, truth = run(sensors='ideal')
    assert np.array_equal(samples, truth)
    assert rig.pressure_variance == 0.0


def test_rig_sensors_are_quantised_noisy_and_within_their_class() -> None:
    rig, samples, truth = run()
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
    assert readings.var() == pytest.approx(rig.pressure_variance, rel=0.2)


def test_measured_velocity_follows_the_true_one() -> None:
    _, samples, truth = run()
    lag = 5  # time constant of 32 Hz in samples
    error = samples[lag:, 1] - truth[:-lag, 1]
    assert np.sqrt(np.mean(error**2)) < 0.006
    assert abs(error.mean()) < 5e-4


def test_seed_decides_noise_and_calibration() -> None:
    _, first, _ = run(300, seed=5)
    _, again, _ = run(300, seed=5)
    _, other, _ = run(300, seed=6)
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
    channel = Channel(span=1.0, levels=4096, gain=1.0, noise=0.0)
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
