"""Eq. 2: a known friction force is recovered, and the live estimate is the offline one, later."""

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from pneu_rig_ros.analysis.friction import (
    CausalFriction,
    ForceBalance,
    acceleration_zero_phase,
    causal_kernel,
    delay_samples,
    friction_zero_phase,
)
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError

INTERVAL = 1.16e-3
BALANCE = ForceBalance(area_1=4.91e-4, area_2=4.12e-4, mass=0.65, atmospheric_pressure=1.01e5)
POSITION_STEP = 0.3 / 4096
"""12 bits over 300 mm [m]."""


def stick_slip(cycles: int = 8, dwell: float = 0.6, slip: float = 0.08) -> tuple[Floats, ...]:
    """Return position [m], pressures [Pa] and the friction force [N] of half-cosine slips."""
    period = dwell + slip
    time = np.arange(0.0, cycles * period, INTERVAL)
    phase = np.clip((time % period - dwell) / slip, 0.0, 1.0)
    step = 4e-3
    position = 0.02 + step * (time // period) + step * 0.5 * (1 - np.cos(np.pi * phase))
    acceleration = np.where(
        (phase > 0) & (phase < 1), step / 2 * (np.pi / slip) ** 2 * np.cos(np.pi * phase), 0.0
    )
    friction = 15.0 + 7.0 * np.clip((time % period) / dwell, 0.0, 1.0) - 7.0 * phase
    pressure_2 = np.full_like(time, 1.5e5)
    force = friction + BALANCE.mass * acceleration
    ambient = BALANCE.atmospheric_pressure * (BALANCE.area_1 - BALANCE.area_2)
    pressure_1 = (force + pressure_2 * BALANCE.area_2 + ambient) / BALANCE.area_1
    return position, pressure_1, pressure_2, friction


def live(position: Floats, pressure_1: Floats, pressure_2: Floats) -> Floats:
    """Return what the live estimator says, one force after the other [N]."""
    estimator = CausalFriction(BALANCE, INTERVAL)
    samples = zip(position, pressure_1, pressure_2, strict=True)
    pushed = [estimator.push(*map(float, sample)) for sample in samples]
    late = 2 * estimator.delay_samples
    assert all(force is None for force in pushed[:late])
    return np.array(pushed[late:], dtype=np.float64)


def test_delay_is_29_ms_at_the_sampling_interval_of_the_rig() -> None:
    assert delay_samples(INTERVAL) == 25
    assert delay_samples(INTERVAL) * INTERVAL == pytest.approx(0.029)


def test_kernel_is_nearly_all_of_the_response_of_the_zero_phase_filter() -> None:
    impulse = np.zeros(2001)
    impulse[1000] = 1.0
    response = filtfilt(*butter(1, 32.0, fs=1.0 / INTERVAL), impulse)[1000 - 24 : 1000 + 25]
    assert 0.99 < response.sum() < 1.0
    kernel = causal_kernel(INTERVAL)
    np.testing.assert_allclose(kernel * response.sum(), response, atol=1e-12)
    np.testing.assert_array_equal(kernel, kernel[::-1])


@pytest.mark.parametrize(('frequency', 'gain'), [(1.0, 1.0), (32.0, 0.5)])
def test_zero_phase_filter_halves_at_the_cutoff_and_keeps_the_phase(
    frequency: float, gain: float
) -> None:
    time = np.arange(0.0, 3.0, INTERVAL)
    omega = 2 * np.pi * frequency
    acceleration = acceleration_zero_phase(np.sin(omega * time) / -(omega**2), INTERVAL)
    middle = slice(400, -400)
    expected = gain * np.sin(omega * time)
    np.testing.assert_allclose(acceleration[middle], expected[middle], atol=0.015)


@pytest.mark.parametrize('acceleration', [-3.0, 0.0, 2.0])
def test_constant_acceleration_gives_the_friction_exactly(acceleration: float) -> None:
    time = np.arange(0.0, 0.5, INTERVAL)
    position = 0.01 + 0.1 * time + acceleration / 2 * time**2
    force = 20.0 + BALANCE.mass * acceleration
    ambient = BALANCE.atmospheric_pressure * (BALANCE.area_1 - BALANCE.area_2)
    pressure_2 = np.full_like(time, 1.3e5)
    pressure_1 = (force + pressure_2 * BALANCE.area_2 + ambient) / BALANCE.area_1
    offline = friction_zero_phase(position, pressure_1, pressure_2, INTERVAL, BALANCE)
    np.testing.assert_allclose(offline[60:-60], 20.0, atol=1e-4)
    np.testing.assert_allclose(live(position, pressure_1, pressure_2), 20.0, atol=1e-6)


def test_friction_of_a_known_stick_slip_motion_is_recovered() -> None:
    position, pressure_1, pressure_2, friction = stick_slip()
    estimate = friction_zero_phase(position, pressure_1, pressure_2, INTERVAL, BALANCE)
    error = np.abs(estimate - friction)[25:-25]
    # The motion's acceleration jumps by 3.1 m/s^2, 2 N: only there may a low-pass differ.
    assert np.median(error) < 0.01
    assert error.max() < 0.55 * BALANCE.mass * 4e-3 / 2 * (np.pi / 0.08) ** 2


def test_live_estimate_is_the_offline_one_25_samples_later() -> None:
    position, pressure_1, pressure_2, _ = stick_slip()
    rng = np.random.default_rng(1)
    measured = POSITION_STEP * np.round(
        (position + rng.normal(0, 2e-5, position.size)) / POSITION_STEP
    )
    offline = friction_zero_phase(measured, pressure_1, pressure_2, INTERVAL, BALANCE)
    online = live(measured, pressure_1, pressure_2)
    difference = online - offline[25 : 25 + online.size]
    inertia = BALANCE.pressure_force(pressure_1, pressure_2) - offline
    # Cutting the response off changes the filtered inertia by less than 1 % of its range.
    assert np.abs(difference[25:-25]).max() < 0.01 * np.ptp(inertia)
    one_late = online[26:-25] - offline[50 : 50 + online[26:-25].size]
    assert np.std(one_late) > 5 * np.std(difference[25:-25])


def test_atmosphere_on_the_rod_is_no_friction() -> None:
    position = np.full(100, 0.1)
    ambient = np.full(100, BALANCE.atmospheric_pressure)
    offline = friction_zero_phase(position, ambient, ambient, INTERVAL, BALANCE)
    np.testing.assert_allclose(offline, 0.0, atol=1e-9)


def test_sensor_step_at_the_very_end_is_no_force() -> None:
    position = np.full(500, 0.1)
    position[-1] += POSITION_STEP
    position[:2] -= POSITION_STEP
    pressure = np.full(500, BALANCE.atmospheric_pressure)
    offline = friction_zero_phase(position, pressure, pressure, INTERVAL, BALANCE)
    # As much as a step in the middle makes.
    assert np.abs(offline).max() < 1.4


def test_reset_forgets_the_samples() -> None:
    estimator = CausalFriction(BALANCE, INTERVAL)
    first = [estimator.push(0.1 + 0.01 * k, 2e5, 1e5) for k in range(60)]
    estimator.reset()
    assert [estimator.push(0.1 + 0.01 * k, 2e5, 1e5) for k in range(60)] == first


def test_too_short_a_record_is_refused() -> None:
    with pytest.raises(RigError, match='3 samples, at least 4'):
        acceleration_zero_phase(np.zeros(3), INTERVAL)


@pytest.mark.parametrize('interval', [0.016, 0.02])
def test_too_slow_sampling_is_refused(interval: float) -> None:
    with pytest.raises(RigError, match=f'every {1e3 * interval:g} ms is too slow'):
        CausalFriction(BALANCE, interval)
    with pytest.raises(RigError, match='too slow for the 32 Hz filter'):
        acceleration_zero_phase(np.zeros(100), interval)
