"""What is made of readings that are wrong, or end where a sensor ends."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.measured.reading import without_clipped, without_outliers
from pneu_rig_ros.diagnosis.residuals.balances import Comparison, substeps
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.reading_noise import reading_noise

from .runs import configured, measured, system_of


def test_position_scale_corrects_the_velocity_too(tmp_path: Path) -> None:
    """Readings 2 % too large, corrected by 2 %, are those of a true sensor; so is the drag."""
    rig = configured('cylinder_2', {}, initial_position=0.04)
    system = system_of(tmp_path, rig)
    true = measured(system, 'true', rig, 3 * ((1.2, 1.5), (-1.2, 1.5)))
    wrong = replace(true, position=1.02 * true.position, stroke=1.02 * true.stroke)
    scale = library.load('position_scale').parameters(0.02)
    corrected = system.hypothesis.with_effect('position_scale', scale)
    expected = Comparison(true).residuals(system.hypothesis).force
    fast = np.abs(Comparison(true).window_velocity) > 0.03
    found = Comparison(wrong).residuals(corrected).force
    uncorrected = Comparison(wrong).residuals(system.hypothesis).force
    use = fast & np.isfinite(expected) & np.isfinite(found)
    assert use.sum() > 10
    # 2 % of a drag of 210 N s/m at 0.03 to 0.05 m/s
    before, after = (float(np.median(np.abs(f - expected)[use])) for f in (uncorrected, found))
    assert before > 0.12
    assert after < 0.2 * before


def test_readings_corrected_for_gains_need_not_be_smoothed_again(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    run = measured(system_of(tmp_path, rig), 'run', rig)
    corrected = run.with_gains((1.005, 0.99, 1.01), (0.0, 0.0, 0.0))
    again = run.with_readings(corrected.position, corrected.pressures)
    assert corrected.rests == run.rests
    # but where noise is cut off at the zero of a sensor, or a rest has another end
    known = run.smooth > run.span.low + 10.0 * max(run.noise.pressures)
    rests = run.resting | again.resting
    known[:, 0] = ~(np.append(rests, True) | np.insert(rests, 0, True))
    assert known.sum(axis=0).min() > 1000
    np.testing.assert_allclose(corrected.smooth[known], again.smooth[known], rtol=1e-9)


def test_readings_are_corrected_for_gains_and_offsets(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    run = measured(system_of(tmp_path, rig), 'run', rig)
    gains, offsets = np.array([1.01, 0.99, 1.02]), np.array([1e-4, 300.0, -200.0])
    zero = np.array([0.0, run.atmospheric_pressure, run.atmospheric_pressure])
    true = np.column_stack([run.position, run.pressures])
    read = zero + offsets + gains * (true - zero)
    again = run.with_readings(read[:, 0], read[:, 1:]).with_gains(gains, offsets)
    np.testing.assert_allclose(np.column_stack([again.position, again.pressures]), true)


def test_pressure_is_unknown_once_a_chamber_expands_below_its_sensors_zero(
    tmp_path: Path,
) -> None:
    rig = configured('cylinder_3')
    system = system_of(tmp_path, rig)
    run = measured(system, 'run', rig)
    count, low = 2000, run.span.low
    x = 0.05 + np.concatenate([np.zeros(500), -1e-5 * np.arange(500), np.full(1000, -5e-3)])
    pressures = np.full((count, 2), low)
    pressures[:, 0] = 2.0 * low
    pressures[1500:, 1] = 1.5 * low
    changed = replace(run, position=x, pressures=pressures, voltages=np.full((count - 1, 2), 2.5))
    vacuum = changed.vacuum
    assert not vacuum[:480].any()  # an open chamber is at the atmosphere
    assert vacuum[520:1490].all()
    assert not vacuum[1510:].any()
    back = replace(changed, position=0.1 - x)
    assert not back.vacuum[:1490].any()  # chamber 2 shrinks


def test_single_wrong_readings_are_replaced_and_turns_are_not() -> None:
    noise, speed, interval = 1e-5, 0.012, 0.01
    phase = speed * interval * np.arange(4000.0)
    true = 0.02 - np.abs(phase % 0.04 - 0.02)  # to and fro, 20 mm
    position = true + noise * np.random.default_rng(1).standard_normal(true.size)
    np.testing.assert_array_equal(without_outliers(position, noise), position)
    wrong = position.copy()
    wrong[[560, 562, 1750]] -= 0.4e-3  # far from turns, two of them close together
    np.testing.assert_allclose(without_outliers(wrong, noise), position, atol=8.0 * noise)


def test_up_to_three_wrong_readings_in_succession_are_replaced() -> None:
    noise = 1e-5
    phase = 1.2e-4 * np.arange(4000.0)
    true = 0.02 - np.abs(phase % 0.04 - 0.02)
    position = true + noise * np.random.default_rng(1).standard_normal(true.size)
    wrong = position.copy()
    wrong[560:562] += 0.2e-3
    wrong[700:703] -= 0.25e-3
    wrong[900], wrong[901] = wrong[900] + 0.25e-3, wrong[901] + 0.4e-3
    np.testing.assert_allclose(without_outliers(wrong, noise), position, atol=8.0 * noise)


def test_turns_of_a_sine_are_right() -> None:
    time = 0.01 * np.arange(4000.0)
    for frequency in (0.05, 0.2, 1.0, 2.0, 12.5, 16.7):
        position = 0.02 * np.cos(2.0 * np.pi * frequency * time)
        # where motion turns every few samples, nothing before the first one tells of it
        inside = slice(20, -20)
        np.testing.assert_array_equal(without_outliers(position, 1e-6)[inside], position[inside])


def test_turn_from_a_fast_stroke_to_a_slow_one_is_no_wrong_reading() -> None:
    noise, interval = 3e-6, 0.01
    for turn in 1.0 + interval * np.arange(0.0, 1.0, 0.05):
        time = interval * np.arange(200.0)
        position = np.where(time < turn, -0.0145 * (time - turn), 0.0022 * (time - turn))
        for there_and_back in (position, position[::-1]):
            np.testing.assert_array_equal(without_outliers(there_and_back, noise), there_and_back)


def test_samples_are_divided_by_the_load_of_their_own_run(tmp_path: Path) -> None:
    """With 0.1 kg it swings ten times as fast as with the 10 kg of the model."""
    rig = configured('cylinder_1', load_mass=10.0)
    system = system_of(tmp_path, rig)
    heavy = measured(system, 'heavy', rig)
    light = replace(heavy, operation=heavy.operation._replace(load_mass=0.1))
    joint = library.load('load_compliance').parameters(1e-4, 0.0)
    swinging = system.hypothesis.with_effect('load_compliance', joint)
    assert substeps(swinging, heavy) == 1
    assert substeps(swinging, light) == 2
    assert substeps(system.hypothesis, light) == 1


def test_noise_that_is_cut_off_at_the_end_of_a_span_does_not_hide_the_rest() -> None:
    """A vented chamber reads the zero of its sensor, and half of its noise."""
    rng = np.random.default_rng(0)
    true = np.repeat([0.0, 2e5, 0.0], 2000) + 1e5
    read = np.maximum(true + 450.0 * rng.standard_normal(true.size), 1e5)
    assert reading_noise(read, 0.0) < 0.9 * 450.0
    assert reading_noise(without_clipped(read, 1e5), 0.0) == pytest.approx(450.0, rel=0.05)
    assert (without_clipped(read[:2000], 1e5) == read[:2000]).all()


@pytest.mark.parametrize('interval', [1.16e-3, 0.01, 0.05])
def test_free_piston_has_its_velocity_however_slowly_it_is_sampled(
    tmp_path: Path, interval: float
) -> None:
    """30 mm of sine in 10 s, and as much noise as the rig's sensor has."""
    rig = configured('cylinder_1')
    run = measured(system_of(tmp_path, rig), 'run', rig, ((0.0, 1.2),))
    time = np.arange(0.0, 30.0, interval)
    phase = 0.2 * np.pi * time
    noise = run.noise.position * np.random.default_rng(0).standard_normal(time.size)
    pressures = np.full((time.size, 2), 1e5)
    slow = replace(run, interval=interval, position=0.08 + 0.03 * np.sin(phase) + noise)
    slow = replace(slow, pressures=pressures)
    true = 0.2 * np.pi * 0.03 * np.cos(phase)
    middles = 0.5 * (true[1:] + true[:-1])
    inside = (np.abs(middles) > 5e-3) & (slow.time > 1.0) & (slow.time < 29.0)
    assert (slow.velocity - middles)[inside].std() < 1e-3
