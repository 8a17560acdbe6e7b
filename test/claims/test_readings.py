"""Readings are read strictly and written back to the same values."""

import json
from pathlib import Path

import pytest
import yaml

from pneu_rig_ros.claims.experiments import Reading
from pneu_rig_ros.claims.readings import (
    SPECIFICATIONS,
    load_reading,
    printed_values_changed,
    reading_values,
    short_text,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import FOLLOWS_CLOCK
from pneu_rig_ros.rig.yaml_file import shipped

GOOD = """
friction:
  stop_velocity: 0.001 m/s
  start_velocity: 0.002 m/s
  element_stiffness: [6e4 N/m, 4e4 N/m]
  element_limit: [2.0 N]
  static_friction_reading: follows_clock
operation: {rest_time: 900.0 s, initial_position: 0.05 m, supply_pressure: 5e5 Pa}
cylinder_1:
  friction: {dwell_coefficient: 0.3 s^-alpha}
  valve: {exhaust_zero_voltage: 2.35 V}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / 'mine.yaml'


def test_file_gives_what_differs(file: Path) -> None:
    file.write_text(GOOD)
    reading = load_reading(file)
    assert reading.name == 'mine'
    one, two = reading.model('cylinder_1'), reading.model('cylinder_2')
    assert (one.friction.dwell_coefficient, two.friction.dwell_coefficient) == (0.3, 0.43)
    assert (one.valve.exhaust_zero_voltage, two.valve.exhaust_zero_voltage) == (2.35, 2.65)
    for model in (one, two):
        assert model.friction.element_stiffness == (6e4, 4e4)
        assert model.friction.static_friction_reading == FOLLOWS_CLOCK
        assert model.operation[2:] == (0.05, 1e5, 1e5, 900.0)
        assert model.operation.supply_pressure == 5e5
    changed = ['friction.dwell_coefficient', 'valve.exhaust_zero_voltage']
    assert printed_values_changed(reading) == changed


@pytest.mark.parametrize('write', [yaml.safe_dump, json.dumps], ids=['yaml', 'json'])
def test_written_reading_reads_back(file: Path, write: object) -> None:
    assert callable(write)
    file.write_text(GOOD)
    reading = load_reading(file)
    file.write_text(write(reading_values(reading)))
    assert load_reading(file) == reading


@pytest.mark.parametrize('name', ['default', *shipped('readings/*.yaml')])
def test_shipped_readings_load(name: str) -> None:
    assert (load_reading(name) == Reading()) == (name == 'default')


@pytest.mark.parametrize(
    ('text', 'complaint'),
    [
        ('', 'expected a mapping with name, cylinder, friction, valve, '),
        ('- 1', 'expected a mapping'),
        ('{', 'not valid YAML'),
        ('frictoin: {}', "unknown name 'frictoin', did you mean 'friction'"),
        ('friction: 3', 'friction: expected a mapping'),
        ('friction: {stop_velocty: 1e-3 m/s}', "did you mean 'stop_velocity'"),
        ('friction: {model: lugre}', "friction: unknown name 'model'"),
        ('friction: {stop_velocity: 1 mm/s}', r'stop_velocity: unit mm/s .* allowed is m/s'),
        ('friction: {stop_velocity: 0.001}', 'stop_velocity: 0.001 is not a number and its unit'),
        ('friction: {stop_velocity: 2.0 m/s}', r'stop_velocity: 2 m/s is not within 1e-07 to 1'),
        ('friction: {stop_velocity: nan m/s}', 'nan m/s is not within'),
        ('friction: {stop_velocity: 0.5 m/s}', r'with cylinder_1: .*not be above start_velocity'),
        ('friction: {element_limit: [1 N]}', 'must have one entry fewer than element_stiffness'),
        ('friction: {film_reading: print}', "film_reading: unknown name 'print'"),
        ('friction: {film_reading: [printed]}', 'film_reading: unknown name'),
        ('friction: {coulomb_force: 24 N}', 'with cylinder_1: .*at least coulomb_force'),
        ('cylinder_4: {}', "unknown name 'cylinder_4', did you mean"),
        ('cylinder_2: {friction: {model: lugre}}', "cylinder_2: friction: unknown name 'model'"),
        ('cylinder_2: {coulomb_force: 3 N}', "cylinder_2: unknown name 'coulomb_force'"),
        ('cylinder_3: {friction: {coulomb_force: 27 N}}', 'with cylinder_3: .*at least coulomb'),
        ('operation: {initial_position: 0.25 m}', 'with cylinder_2: .*must be within the stroke'),
        ('operation: {rest_time: 5 min}', 'rest_time: unit min'),
        ('operation: {rest_time: -1 s}', 'rest_time: -1 s is not within 0 to'),
        ('operation: {load_mass: 1 kg}', "operation: unknown name 'load_mass'"),
        ('name: 7', 'name: 7 is not a line of 1 to 60 characters'),
        ('name: "a\\e[31mb"', 'name: .* is not a line'),
    ],
)
def test_bad_file_is_told_in_one_line(file: Path, text: str, complaint: str) -> None:
    file.write_text(text)
    with pytest.raises(RigError, match=complaint) as caught:
        load_reading(file)
    assert str(caught.value).startswith(str(file))
    assert '\n' not in str(caught.value)


def test_unknown_name_is_told() -> None:
    with pytest.raises(RigError, match="unknown name 'defualt', did you mean 'default'"):
        load_reading('defualt')


@pytest.mark.parametrize('name', ['missing.yaml', '.'])
def test_unreadable_file_is_told(name: str) -> None:
    with pytest.raises(RigError, match=r'cannot be read: (No such file|Is a directory)'):
        load_reading(name)


def test_change_of_a_printed_value_is_known(file: Path) -> None:
    file.write_text('friction: {dwell_coefficient: 0.5 s^-alpha, start_velocity: 0.01 m/s}')
    assert printed_values_changed(load_reading(file)) == ['friction.dwell_coefficient']


@pytest.mark.parametrize(
    ('key', 'value', 'text'),
    [
        ('stop_velocity', 0.00123456789, '0.00123457 m/s'),
        ('element_stiffness', (6e4, 1e4), '60000 N/m + 10000 N/m'),
        ('element_limit', (), 'none'),
        ('static_friction_reading', FOLLOWS_CLOCK, 'follows clock'),
    ],
)
def test_short_text(key: str, value: object, text: str) -> None:
    assert short_text(SPECIFICATIONS['friction'][key], value) == text
