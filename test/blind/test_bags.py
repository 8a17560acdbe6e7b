"""What the workflow gets: bags and a model file that say nothing of what is hidden."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.records import read_recording
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.scenarios.experiments import FIT, levels
from pneu_rig_ros.scenarios.hidden import EFFECTS, Secret, hide

from .files import Files
from .plant import Motion
from .rig import INTERVAL, make_bags, measure, move, truth_of, visibility
from .sensors import drawn_gains
from .settings import model_file, settings
from .trials import join

NOTHING = Secret({}, {}, {})
CYLINDER = 'cylinder_1'


@pytest.fixture(scope='module')
def secret() -> Secret:
    friction = settings(CYLINDER)['friction']
    hidden = (hide(name, CYLINDER, 'medium', friction) for name in ('supply_droop', 'stribeck'))
    return join(*hidden)


@pytest.fixture(scope='module')
def bags(secret: Secret, tmp_path_factory: pytest.TempPathFactory) -> Files:
    return make_bags(tmp_path_factory.mktemp('trial'), CYLINDER, secret, noise=1.0, seed=5)


def test_bag_is_a_record_of_the_experiment(bags: Files) -> None:
    record = read_recording(bags.fit[1])
    assert record.interval_ns == 1_160_000
    assert not any(stamps.size for stamps in record.missing.values())
    assert record.duration == pytest.approx(sum(d for d, _ in levels(FIT[1], CYLINDER)), abs=0.01)
    assert record.position[0] == pytest.approx(0.5 * 0.3, abs=2e-4)
    conditions = record.conditions
    assert conditions == {
        'supply_pressure': 4e5,
        'load_mass': 2.0,
        'atmospheric_pressure': 1e5,
        'rest_time': 60.0,
    }


def test_nothing_tells_what_is_hidden(bags: Files) -> None:
    root = bags.model.parent
    for path in filter(Path.is_file, root.rglob('*')):
        content = path.read_bytes()
        words = (f'{name}:' for name in EFFECTS) if path == bags.model else EFFECTS
        for word in (*words, 'resistance', 'hidden', 'truth'):
            assert word.encode() not in content, f'{path} says {word}'
    assert read_recording(bags.fit[0]).configuration is None


def test_model_file_is_the_rig_without_the_secret(bags: Files, secret: Secret) -> None:
    given = load_configuration(bags.model)
    shipped = load_configuration(CYLINDER)
    assert given.effects == {}
    changes = {name.split('.')[1]: value for name, value in secret.model.items()}
    law = shipped.model.friction._replace(model=0, breakaway_force=changes['breakaway_force'])
    assert given.model == shipped.model._replace(friction=law)


@pytest.mark.parametrize('cylinder', ['cylinder_1', 'cylinder_2', 'cylinder_3'])
def test_unchanged_model_file_is_the_shipped_one_with_calibrated_sensors(
    cylinder: str, tmp_path: Path
) -> None:
    path = tmp_path / 'model.yaml'
    path.write_text(model_file(cylinder, {}))
    shipped = load_configuration(cylinder)
    sensors = shipped.sensors._replace(position_class=0.0, pressure_class=0.0)
    assert load_configuration(path) == replace(shipped, sensors=sensors)


def still(position: float, pressure: float) -> Motion:
    """Return a motion that is none."""
    time = np.arange(20_000) * INTERVAL
    same = np.full_like(time, 1.0)
    return Motion(time, position * same, 0.0 * same, pressure * same, pressure * same, same > 0.0)


@pytest.mark.parametrize('noise', [1.0, 3.0, 10.0])
def test_noise_is_that_of_the_rig_times_a_factor(noise: float) -> None:
    read = measure(still(0.1, 3e5), truth_of(CYLINDER, NOTHING), NOTHING, noise, seed=1)
    position = np.hypot(noise * 2e-5, 0.3 / 4095 / np.sqrt(12.0))
    pressure = np.hypot(noise * 150.0, 1e6 / 4095 / np.sqrt(12.0))
    if noise > 1.0:  # below one step of the converter the two do not add up so
        assert read.position.std() == pytest.approx(position, rel=0.05)
        assert read.pressure_1.std() == pytest.approx(pressure, rel=0.05)
    assert read.position.mean() == pytest.approx(0.1, abs=0.1 * position + 4e-5)
    steps = read.pressure_1 - 1e5
    assert steps / (1e6 / 4095) == pytest.approx(np.round(steps / (1e6 / 4095)), abs=1e-6)


def test_class_of_the_sensors_is_left_out_unless_asked_for() -> None:
    motion, true = still(0.2, 5e5), truth_of(CYLINDER, NOTHING)
    exact = measure(motion, true, NOTHING, 1.0, seed=3)
    wrong = measure(motion, true, NOTHING, 1.0, seed=3, gains=drawn_gains(3))
    assert exact.pressure_1.mean() == pytest.approx(5e5, abs=30.0)
    off = wrong.pressure_1.mean() - 5e5
    assert 100.0 < abs(off) <= 0.01 * 4e5 + 30.0


def test_lag_of_the_position_sensor_is_first_order() -> None:
    time = np.arange(2000) * INTERVAL
    constant = np.full_like(time, 2e5)
    ramp = Motion(time, 0.05 * time, constant, constant, constant, time < 0.0)
    secret = Secret({'sensor_delay': {'time_constant': 0.05}}, {}, {})
    true = truth_of(CYLINDER, NOTHING)
    read = measure(ramp, true, secret, 0.0, seed=1)
    behind = 0.05 * (time - 0.05 * (1.0 - np.exp(-time / 0.05)))
    assert read.position == pytest.approx(behind, abs=0.3 / 4095)


def test_visibility_is_none_where_nothing_is_hidden() -> None:
    assert visibility(CYLINDER, NOTHING, 1.0) == 0.0


def test_visibility_of_an_offset_is_its_size_over_the_noise() -> None:
    offset = {'pressure_offset': {'offset_1': 600.0, 'offset_2': -300.0}}
    assert visibility(CYLINDER, Secret(offset, {}, {}), 1.0) == pytest.approx(4.0)
    assert visibility(CYLINDER, Secret(offset, {}, {}), 10.0) == pytest.approx(0.4)


def test_same_seed_same_readings() -> None:
    true = truth_of(CYLINDER, NOTHING)
    motion = move(true, NOTHING, CYLINDER, FIT[0])
    first, same, other = (measure(motion, true, NOTHING, 1.0, seed) for seed in (1, 1, 2))
    assert np.array_equal(first.position, same.position)
    assert not np.array_equal(first.position, other.position)
