"""Conditions of a bag: where they come from, and that a rig takes them."""

import json
from pathlib import Path

import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.conditions import (
    CONDITIONS,
    apply_conditions,
    conditions_of,
    format_conditions,
    parse_conditions,
)
from pneu_rig_ros.rig import load_configuration

OF_CYLINDER_2 = {
    'supply_pressure': 4e5,
    'load_mass': 0.2,
    'atmospheric_pressure': 1e5,
    'rest_time': 70.0,
}


def test_file_precedes_metadata_precedes_configuration(bag: Path, tmp_path: Path) -> None:
    recording = read_recording(bag)
    assert recording.conditions == OF_CYLINDER_2
    rig, metadata = recording.configuration, recording.metadata
    told = {**metadata, 'conditions': 'load_mass: 1.0 kg\nrest_time: 60.0 s\n'}
    assert conditions_of(bag, rig, told) == OF_CYLINDER_2 | {'load_mass': 1.0, 'rest_time': 60.0}
    (tmp_path / 'conditions.yaml').write_text('load_mass: 2 kg\n')
    beside = OF_CYLINDER_2 | {'load_mass': 2.0, 'rest_time': 60.0}
    assert conditions_of(tmp_path, rig, told) == beside
    for place in (tmp_path, tmp_path / 'any.mcap', tmp_path / 'metadata.yaml'):
        assert conditions_of(place, None, {}) == {'load_mass': 2.0}
    assert conditions_of(tmp_path / 'any.csv', None, {}) == {}
    (tmp_path / 'any.conditions.yaml').write_text('load_mass: 3 kg\n')
    assert conditions_of(tmp_path / 'any.csv', None, {}) == {'load_mass': 3.0}


def test_conditions_are_applied_and_nothing_else_changes() -> None:
    configuration = load_configuration('cylinder_1')
    wanted = {
        'supply_pressure': 6e5,
        'load_mass': 1.5,
        'atmospheric_pressure': 9.9e4,
        'rest_time': 10.0,
    }
    changed = apply_conditions(configuration, wanted).model
    assert {**changed.operation._asdict(), **changed.gas._asdict()}.items() >= wanted.items()
    assert changed.cylinder == configuration.model.cylinder
    assert changed.friction == configuration.model.friction
    assert apply_conditions(configuration, {}) == configuration


def test_laboratory_units_and_gauge() -> None:
    text = 'supply_pressure: 4 bar gauge\natmospheric_pressure: 1013 hPa\nload_mass: 200 g\n'
    assert parse_conditions(text, 'here') == pytest.approx(
        {'supply_pressure': 5.013e5, 'atmospheric_pressure': 1.013e5, 'load_mass': 0.2}
    )


def test_text_reads_back_to_the_same_values() -> None:
    values = {
        name: quantity.low + 0.1 * (quantity.high - quantity.low)
        for name, quantity in CONDITIONS.items()
    }
    assert parse_conditions(format_conditions(values), 'here') == values
    assert json.dumps(parse_conditions(format_conditions({}), 'here')) == '{}'


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('suply_pressure: 4 bar', "f: unknown name 'suply_pressure', did you mean 'supply_pres"),
        ('supply_pressure: 4 bar gauge gauge', 'f: supply_pressure: unit'),
        ('supply_pressure: 50 bar', 'f: supply_pressure: 5e.06 Pa is not within'),
        ('load_mass: {a: 1}', 'f: load_mass: .* is not a number and its unit'),
        ('[1, 2]', 'f: expected a mapping with supply_pressure'),
        ('a: [', 'f: not valid YAML'),
    ],
)
def test_what_is_wrong_is_said(text: str, message: str) -> None:
    with pytest.raises(RigError, match=message):
        parse_conditions(text, 'f')
