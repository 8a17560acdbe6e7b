"""Systems of any extent: which balances are open, why the others are not, and their files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.inputs.prepare_runs import lacks, prepare_run
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import REVISED_LUGRE, STATIC_FRICTION_READINGS
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.rig import load_configuration

from .parts import BENCH, BLOCK, CHAMBERS, LEAKING, system_file
from .runs import changed, configured, recorded, system_of

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = sorted(
    path for path in (ROOT / 'config' / 'systems').glob('*.yaml') if '.map.' not in path.name
)
GAS = ('position', 'pressure_1', 'pressure_2')
DRIVEN = (*GAS, 'voltage_1', 'voltage_2')


def recording(*signals: str, **conditions: float) -> Recording:
    """Return a recording of some signals, whatever they are."""
    values = {name: np.linspace(1e5, 2e5, 50) for name in signals}
    return Recording('run', 0, 1_000_000, values, conditions=conditions)


@pytest.mark.parametrize(
    ('text', 'signals', 'opened'),
    [
        (CHAMBERS, GAS, {'gas_1', 'gas_2'}),
        (CHAMBERS, ('position', 'pressure_1'), {'gas_1'}),
        (CHAMBERS, ('position', 'pressure_2'), {'gas_2'}),
        (CHAMBERS, ('pressure_1', 'pressure_2'), set()),
        (BENCH, ('position', 'pressure_2', 'force'), {'force'}),
        (BENCH, ('position', 'pressure_2'), set()),
        (LEAKING, ('pressure_1',), {'gas_1'}),
        (BLOCK, ('u', 'pressure_1', 'pressure_2'), {'gas_1', 'gas_2'}),
        (BLOCK, ('pressure_1', 'pressure_2'), set()),
    ],
)
def test_open_balances_follow_from_file_and_signals(
    tmp_path: Path, text: str, signals: tuple[str, ...], opened: set[str]
) -> None:
    closed = lacks(load_system(system_file(tmp_path, text)), recording(*signals))
    assert list(closed) == ['gas_1', 'gas_2', 'force']
    assert {name for name, missing in closed.items() if not missing} == opened


@pytest.mark.parametrize(
    ('text', 'signals', 'balance', 'reasons'),
    [
        (CHAMBERS, ('position', 'pressure_1'), 'gas_2', ['signal pressure_2']),
        (CHAMBERS, GAS, 'force', ['friction.model', 'cylinder.moving_mass']),
        (BLOCK, ('pressure_1', 'pressure_2'), 'gas_1', ['signal u']),
        (LEAKING, ('pressure_1',), 'gas_2', ['cylinder.rod_dead_volume', 'signal pressure_2']),
        (BENCH, ('position', 'force'), 'gas_1', ['cylinder.cap_dead_volume', 'signal u']),
        (
            BLOCK.replace('operation: {supply_pressure: 5e5 Pa}', ''),
            ('u', 'pressure_1'),
            'gas_1',
            ['operation.supply_pressure'],
        ),
    ],
)
def test_a_closed_balance_says_what_is_missing(
    tmp_path: Path, text: str, signals: tuple[str, ...], balance: str, reasons: list[str]
) -> None:
    closed = lacks(load_system(system_file(tmp_path, text)), recording(*signals))
    missing = closed[balance].split(', ')
    for reason in reasons:
        assert reason in missing


def test_supply_of_the_recording_does_where_the_file_gives_none(tmp_path: Path) -> None:
    text = BLOCK.replace('operation: {supply_pressure: 5e5 Pa}', '')
    system = load_system(system_file(tmp_path, text))
    run = recording('u', 'pressure_1', 'pressure_2', supply_pressure=6e5)
    assert not lacks(system, run)['gas_1']


def test_rig_has_all_balances_open_but_those_of_a_missing_sensor() -> None:
    system = load_system('cylinder_1')
    assert not any(lacks(system, recording(*DRIVEN)).values())
    closed = lacks(system, recording('position', 'pressure_1', 'u'))
    assert closed == {'gas_1': '', 'gas_2': 'signal pressure_2', 'force': 'signal pressure_2'}


@pytest.mark.parametrize('text', [CHAMBERS, BENCH, LEAKING, BLOCK])
def test_system_is_written_as_it_was_read(tmp_path: Path, text: str) -> None:
    system = load_system(system_file(tmp_path, text))
    again = load_system(system_file(tmp_path, system.to_yaml()))
    assert again == system


@pytest.mark.parametrize('path', SHIPPED, ids=lambda path: path.stem)
def test_shipped_systems_are_read_and_written(tmp_path: Path, path: Path) -> None:
    system = load_system(path)
    assert system.name == path.stem
    assert load_system(system_file(tmp_path, system.to_yaml())) == system


def test_what_was_found_is_in_the_file(tmp_path: Path) -> None:
    system = load_system(system_file(tmp_path, CHAMBERS))
    heat = library.load('wall_heat_transfer').null._replace(conductance_1=12.0, conductance_2=25.0)
    found = system.hypothesis.with_effect('wall_heat_transfer', heat)
    found = found.with_parameter('cylinder', 'cap_dead_volume', 0.027)
    again = load_system(system_file(tmp_path, replace(system, hypothesis=found).to_yaml()))
    assert again.hypothesis == found
    assert again.refit == system.refit


def test_file_of_a_rig_gives_back_its_configuration(tmp_path: Path) -> None:
    system = load_system('cylinder_3')
    assert system.rig == load_configuration('cylinder_3')
    path = system_file(tmp_path, system.to_yaml())
    assert load_configuration(path) == system.rig


@pytest.mark.parametrize(
    ('said', 'deviations'),
    [
        ('[clock_offset]', {'clock_offset': 0.3}),
        (
            '[force_offset, initial_temperature]',
            {'force_offset': 1e4, 'initial_temperature': 30.0},
        ),
        ('{clock_offset: 0.05 s}', {'clock_offset': 0.05}),
    ],
)
def test_what_differs_between_recordings_has_a_standard_deviation(
    tmp_path: Path, said: str, deviations: dict[str, float]
) -> None:
    system = load_system(system_file(tmp_path, f'{CHAMBERS}each_recording: {said}\n'))
    assert system.each_recording == deviations
    again = load_system(system_file(tmp_path, system.to_yaml()))
    assert again == system


def test_nothing_is_inherited(tmp_path: Path) -> None:
    """Two systems that say the same are the same whatever else a shipped cylinder has."""
    system = load_system(system_file(tmp_path, CHAMBERS))
    assert 'friction' not in {name for name, keys in system.given.items() if keys}
    assert isinstance(system.hypothesis, Hypothesis)
    assert system.sensors is None
    assert 'moving_mass' not in system.to_yaml()


@pytest.mark.parametrize(
    ('law', 'missing'),
    [
        ('coulomb_viscous', ''),
        ('lugre', 'friction.breakaway_force, friction.stribeck_velocity'),
        ('revised_lugre', 'friction.film_velocity, friction.film_time_acceleration'),
        ('revised_lugre_dwell', 'friction.dwell_coefficient, friction.memory_time'),
    ],
)
def test_parameters_of_a_friction_law_are_not_inherited_either(
    tmp_path: Path, law: str, missing: str
) -> None:
    system = load_system(system_file(tmp_path, BENCH.replace('coulomb_viscous', law)))
    lacking = lacks(system, recording('position', 'pressure_2', 'force'))['force']
    assert missing in lacking
    assert bool(lacking) is bool(missing)


def test_bench_whose_mass_is_not_given_has_no_inertia(tmp_path: Path) -> None:
    system = load_system(system_file(tmp_path, BENCH))
    assert system.hypothesis.model.total_mass < 2e-3


@pytest.mark.parametrize(('said', 'zero'), [('', 2.4), (', exhaust_zero_voltage: 2.65 V', 2.65)])
def test_exhaust_opens_from_its_edge_unless_the_file_says_otherwise(
    tmp_path: Path, said: str, zero: float
) -> None:
    edge = 'exhaust_voltage: 2.35 V'
    text = BLOCK.replace(edge, f'exhaust_voltage: 2.4 V{said}')
    system = load_system(system_file(tmp_path, text))
    assert system.hypothesis.model.valve.exhaust_zero_voltage == zero


@pytest.mark.parametrize(
    ('old', 'new', 'message'),
    [
        ('name: chambers', 'part: chambers', "'part'"),
        ('stroke: 2.03 m', 'stroke: 2.03 mm', 'cylinder.stroke'),
        ('stroke: 2.03 m', 'strok: 2.03 m', "did you mean 'stroke'"),
        ('valve: shut', 'valve: shut\neach_recording: [force]', 'allowed: force_offset'),
        ('[0.02 m^3, 0.035 m^3]', '[0.03 m^3, 0.035 m^3]', 'not within'),
        ('[0.02 m^3, 0.035 m^3]', '0.03 m^3', 'expected [low, high]'),
        ('cylinder.cap_dead_volume:', 'cylinder.cap_volume:', 'refit'),
        ('valve: shut', 'valve: shut\nfixed: {speed: 0 m}', 'allowed: position'),
        ('valve: shut', 'valve: shut\nfixed: {position: 1 Pa}', 'fixed.position'),
        ('valve: shut', 'valve: shut\nfixed: {position: 1 m}', 'cap_dead_volume: cannot be found'),
        ('valve: shut', 'valve: shut\neffects: {wall_heat: {}}', 'wall_heat_transfer'),
        ('valve: shut', 'valve: closed', 'valve: expected a mapping'),
        ('valve: shut', 'valve: shut\neach_recording: force_offset', 'expected a list'),
        (
            'valve: shut',
            'valve: shut\neach_recording: [clock_offse]',
            "did you mean 'clock_offset'",
        ),
        (
            'valve: shut',
            'valve: shut\neach_recording: {temperature: 30 K}',
            'allowed: force_offset, clock_offset, initial_temperature',
        ),
        (
            'valve: shut',
            'valve: shut\neach_recording: {clock_offset: 0.3 ms}',
            'each_recording.clock_offset: unit ms',
        ),
        ('valve: shut', 'valve: shut\neach_recording: {clock_offset: 0.3}', 'its unit s'),
        ('valve: shut', 'valve: shut\neach_recording: {clock_offset: 60 s}', 'not within'),
    ],
)
def test_wrong_file_is_told_in_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in CHAMBERS
    path = system_file(tmp_path, CHAMBERS.replace(old, new))
    with pytest.raises(RigError) as error:
        load_system(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)
    assert '\n' not in str(error.value)


def test_order_of_refit_does_not_change_what_is_fitted(tmp_path: Path) -> None:
    system = load_system(system_file(tmp_path, LEAKING))
    one, other = 'cylinder.cap_dead_volume', 'gas.supply_temperature'
    ranges = {one: (5e-4, 2e-3), other: (280.0, 310.0)}
    turned = {name: ranges[name] for name in (other, one)}
    first, second = (pool(replace(system, refit=each), [])[1] for each in (ranges, turned))
    assert first == second
    assert [part.name for part in first.parts] == [one, other]


def test_causes_of_a_rig_with_one_pressure_are_those_of_its_chamber(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    system, whole = system_of(tmp_path, rig), recorded('run', rig)
    signals = {name: values for name, values in whole.signals.items() if name != 'pressure_2'}
    run = prepare_run(replace(whole, signals=signals), system, Path('run'))
    found = {
        each.name: [coordinate.name for coordinate in each.coordinates]
        for each in pool(system, [run])[0]
        if each.is_effect
    }
    assert found['chamber_leak'] == ['area_1']
    assert found['porous_leak'] == ['flow_1', 'exponent']
    assert found['valve_lag'] == ['time_constant', 'share']  # of no chamber
    assert not {'inclination', 'load_spring', 'cross_piston_leak'} & set(found)


def test_law_is_tried_with_and_without_what_it_can_do_beyond_the_simplest(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    run = prepare_run(recorded('run', rig), system, Path('run'))
    simple, general = (each for each in pool(system, [run])[0] if each.name == 'supply_droop')
    assert [coordinate.name for coordinate in simple.coordinates] == ['resistance']
    assert [coordinate.name for coordinate in general.coordinates] == ['resistance', 'exponent']
    assert simple.starts == ((1e8,), (5e8,), (2e9,))
    given = system.hypothesis
    assert simple.apply(given, (1e9,)).effects == general.apply(given, (1e9, 1.0)).effects
    start = Explanation(given)
    forms = {start.with_part(law, law.starts[0]).forms for law in (simple, general)}
    assert len(forms) == 2


def test_growth_with_dwell_is_tried_under_each_reading_and_written_with_it(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    system = system_of(tmp_path, changed(rig, 'friction', model=REVISED_LUGRE))
    run = prepare_run(recorded('run', rig), system, Path('run'))
    found = [each for each in pool(system, [run])[0] if each.name == 'dwell_static_friction']
    written = []
    for each in found:
        path = tmp_path / 'improved.yaml'
        improved = each.apply(system.hypothesis, each.starts[0])
        path.write_text(replace(system, hypothesis=improved).to_yaml())
        written.append(load_configuration(path).model.friction.static_friction_reading)
    assert written == 2 * list(range(len(STATIC_FRICTION_READINGS)))  # both forms of the law
