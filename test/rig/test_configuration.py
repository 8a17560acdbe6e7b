"""Configurations: Tables 1 and 2 as shipped, round trip, and what is refused."""

from pathlib import Path

import pytest
import yaml

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig.configuration import (
    RigConfiguration,
    configuration_from_yaml,
    load_configuration,
)
from pneu_rig_ros.rig.yaml_file import configuration_folder, shipped

CYLINDERS = ['cylinder_1', 'cylinder_2', 'cylinder_3']

TABLE_2 = {
    'cap_area': (4.91e-4, 13e-4, 31e-4),
    'rod_area': (4.12e-4, 11e-4, 28e-4),
    'cap_dead_volume': (3e-5, 5e-5, 7e-5),
    'rod_dead_volume': (1e-4, 1e-4, 1e-4),
    'stroke': (0.3, 0.2, 0.2),
    'breakaway_force': (15.45, 22.0, 26.0),
    'coulomb_force': (4.0, 0.5, 3.0),
    'stribeck_velocity': (0.012, 0.033, 0.003),
    'film_velocity': (0.05, 0.05, 0.05),
    'stribeck_exponent': (2.5, 2.5, 2.5),
    'viscous_coefficient': (85.0, 210.0, 350.0),
    'micro_viscous_coefficient': (0.1, 0.1, 0.1),
    'film_time_acceleration': (0.01, 0.013, 0.016),
    'film_time_deceleration': (0.32, 0.3, 0.28),
    'film_time_dwell': (36.0, 38.0, 42.0),
    'dwell_exponent': (0.45, 0.55, 0.62),
    'dwell_coefficient': (0.22, 0.43, 0.18),
}
TABLE_1 = {'bore': (0.025, 0.040, 0.063), 'rod_diameter': (0.010, 0.016, 0.020)}


def test_three_cylinders_are_shipped() -> None:
    assert list(shipped('cylinder_*.yaml')) == CYLINDERS


@pytest.mark.parametrize('index', range(3))
def test_tables_1_and_2_are_as_printed(index: int) -> None:
    model = load_configuration(CYLINDERS[index]).model
    for name, printed in (TABLE_1 | TABLE_2).items():
        section = model.cylinder if hasattr(model.cylinder, name) else model.friction
        assert getattr(section, name) == printed[index], name
    assert model.total_mass == pytest.approx((0.45, 0.65, 0.98)[index])
    assert model.valve[:4] == (4.8e-8, 1e-6, 2.65, 2.35)
    assert model.gas[:3] == (1e5, 300.0, 1.3997)
    assert model.operation.supply_pressure == 4e5  # 4 bar, absolute


@pytest.mark.parametrize('name', CYLINDERS)
def test_configuration_survives_yaml_unchanged(name: str) -> None:
    configuration = load_configuration(name, load_mass=0.1 + 0.2, seed=7, sensors='ideal')
    assert configuration_from_yaml(configuration.to_yaml(), 'text') == configuration


def test_every_line_of_the_shipped_files_has_a_unit() -> None:
    for path in configuration_folder().glob('*.yaml'):
        if path.stem not in (*CYLINDERS, 'rig'):
            continue
        for section in yaml.safe_load(path.read_text()).values():
            for value in section.values() if isinstance(section, dict) else ():
                assert not isinstance(value, int | float), f'{path}: {value} has no unit'


def test_overrides_apply() -> None:
    changed = load_configuration(
        'cylinder_3',
        supply_pressure=7e5,
        load_mass=5.3,
        initial_position=0.05,
        rest_time=10.0,
        friction='lugre',
        seed=None,
    )
    operation = changed.model.operation
    assert (operation.supply_pressure, operation.load_mass) == (7e5, 5.3)
    assert (operation.initial_position, operation.rest_time) == (0.05, 10.0)
    assert changed.model.friction.model == 1


@pytest.mark.parametrize(
    ('line', 'replacement', 'message'),
    [
        ('stroke: 0.2 m', 'stroke: 200 mm', 'cylinder.stroke: unit mm .* allowed is m'),
        ('stroke: 0.2 m', 'stroke: 20 m', 'cylinder.stroke: 20 m is not within 0.001 to 10 m'),
        ('stroke: 0.2 m', 'stroke: .nan m', "cylinder.stroke: '.nan' is not a number"),
        ('stroke: 0.2 m', 'stroke: inf m', 'cylinder.stroke: inf m is not within'),
        ('stroke: 0.2 m', 'strok: 0.2 m', "cylinder: unknown name 'strok', did you mean 'stroke'"),
        ('bore: 0.040 m', 'bore: 0.050 m', 'cap_area must agree with the bore'),
        ('cylinder:', 'cilinder:', "unknown name 'cilinder', did you mean 'cylinder'"),
        ('model: revised_lugre_dwell', 'model: lugree', "'lugree', did you mean 'lugre'"),
        ('coulomb_force: 0.5 N', 'coulomb_force: 50 N', 'breakaway_force must be at least'),
        ('element_limit: []', 'element_limit: [1 N]', 'one entry fewer'),
        ('stop_velocity: 0.0', 'stop_velocity: 0.9', 'must not be above start_velocity'),
        ('name: cylinder_2', 'name: [', 'not valid YAML'),
        (
            'name: cylinder_2',
            'effects: {chamber_lek: {}}',
            "effects: unknown name 'chamber_lek', did you mean 'chamber_leak'",
        ),
        (
            'name: cylinder_2',
            'effects: {inclination: {angel: 0.1 rad}}',
            "effects.inclination: unknown name 'angel', did you mean 'angle'",
        ),
    ],
)
def test_bad_files_are_refused_with_file_key_value_and_range(
    tmp_path: Path, line: str, replacement: str, message: str
) -> None:
    text = (configuration_folder() / 'cylinder_2.yaml').read_text()
    assert line in text
    path = tmp_path / 'bad.yaml'
    path.write_text(text.replace(line, replacement))
    with pytest.raises(RigError, match=message) as caught:
        load_configuration(path)
    assert str(path) in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('key', 'value', 'message'),
    [
        ('intake_voltage', '2.3 V', 'exhaust_voltage must be below intake_voltage'),
        ('exhaust_zero_voltage', '2.349 V', 'zero_voltage must be at least exhaust_voltage'),
        ('exhaust_zero_voltage', '5.1 V', '5.1 V is not within 0 to 5 V'),
    ],
)
def test_valves_that_contradict_themselves_are_refused(key: str, value: str, message: str) -> None:
    data = yaml.safe_load(load_configuration('cylinder_2').to_yaml())
    data['valve']['exhaust_zero_voltage'] = '2.35 V'
    configuration_from_yaml(yaml.safe_dump(data), 'good')
    data['valve'][key] = value
    with pytest.raises(RigError, match=f'bad: valve.*{message}'):
        configuration_from_yaml(yaml.safe_dump(data), 'bad')


@pytest.mark.parametrize(
    ('source', 'overrides', 'message'),
    [
        ('cylinder_9', {}, "unknown name 'cylinder_9', did you mean 'cylinder_"),
        ('missing.yaml', {}, 'missing.yaml: cannot be read: No such file'),
        ('cylinder_1', {'load_mass': -1.0}, 'load_mass: -1 kg is not within 0 to 100 kg'),
        ('cylinder_1', {'load_mass': float('nan')}, 'load_mass: nan kg'),
        ('cylinder_1', {'load_mass': '3'}, "load_mass: '3' is not a number"),
        (
            'cylinder_1',
            {'initial_position': 0.31},
            'initial_position: 0.31 m is not within 0 to 0.3 m',
        ),
        ('cylinder_1', {'seed': -1}, '^seed: -1 is not within 0 to'),
        ('cylinder_1', {'friction': 'dahl'}, "friction: unknown name 'dahl'"),
        ('cylinder_1', {'sensors': 'perfect'}, 'allowed: rig, ideal'),
        ('cylinder_1', {'colour': 3}, "unknown name 'colour'"),
    ],
)
def test_bad_requests_are_refused(source: str, overrides: dict[str, object], message: str) -> None:
    with pytest.raises(RigError, match=message):
        load_configuration(source, **overrides)


def test_folder_does_not_hide_the_shipped_cylinder_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'cylinder_1').mkdir()
    monkeypatch.chdir(tmp_path)
    assert load_configuration('cylinder_1').name == 'cylinder_1'


def test_effects_are_read_and_checked(tmp_path: Path) -> None:
    text = (configuration_folder() / 'cylinder_1.yaml').read_text()
    path = tmp_path / 'leaky.yaml'
    path.write_text(text + 'effects:\n  chamber_leak: {area_1: 1e-9 m^2, area_2: 0.0 m^2}\n')
    leaky: RigConfiguration = load_configuration(path)
    assert leaky.effects['chamber_leak'].area_1 == 1e-9
    assert configuration_from_yaml(leaky.to_yaml(), 'text') == leaky
    path.write_text(text + 'effects:\n  chamber_leak: {area_1: 1 m^2, area_2: 0.0 m^2}\n')
    with pytest.raises(RigError, match=r'effects.chamber_leak.area_1: 1 m\^2 is not within'):
        load_configuration(path)


def test_effect_that_completes_another_friction_law_is_refused(tmp_path: Path) -> None:
    text = (configuration_folder() / 'cylinder_1.yaml').read_text()
    path = tmp_path / 'dwell.yaml'
    path.write_text(
        text + 'effects:\n  dwell_static_friction: {lost_share: 0.9, '
        'dwell_coefficient: 0.2 s^-alpha, dwell_exponent: 0.5 -}\n'
    )
    message = 'dwell_static_friction is for friction.model lugre or revised_lugre, not for'
    with pytest.raises(RigError, match=message):
        load_configuration(path)
    path.write_text(path.read_text().replace('model: revised_lugre_dwell', 'model: revised_lugre'))
    assert load_configuration(path).effects['dwell_static_friction'].lost_share == 0.9
