"""Parts of a rig are diagnosed alone: on data of which the truth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.parts.diagnosis import answer, diagnose_part, find_out
from pneu_rig_ros.gap.parts.part import load_part
from pneu_rig_ros.gap.parts.recording import read_recording, recording, without_jumps_back
from pneu_rig_ros.model import effects as library

from .part_data import (
    CHAMBERS,
    CONDUCTANCES,
    DEAD,
    FRICTION,
    VALVES,
    chamber_run,
    friction_run,
    part_file,
    valve_run,
)
from .runs import measured

FILLS = ((4.5e5, 1.1e6), (5.5e5, 1.2e6))
GAUGE = """
time: {column: t, unit: s}
position: {column: x, unit: m}
pressure_1: {column: p1, unit: Pa, gauge: true}
pressure_2: {column: p2, unit: Pa, gauge: true}
voltage_1: {column: v1, unit: V}
voltage_2: {column: v2, unit: V}
"""


def test_heat_transfer_is_named_with_its_conductances(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, CHAMBERS))
    runs = [chamber_run(f'run {i}', i, FILLS[i], CONDUCTANCES) for i in (0, 1)]
    found = find_out(part, runs[:1], runs[1:])
    told = answer(found)
    assert told['verdict'] == 'effect'
    assert [one['name'] for one in told['effects']] == ['wall_heat_transfer']
    values = told['effects'][0]['parameters']
    for i in (0, 1):
        estimate = values[f'conductance_{i + 1}']
        assert estimate['value'] == pytest.approx(CONDUCTANCES[i], rel=0.05)
        assert estimate['interval'][0] < CONDUCTANCES[i] < estimate['interval'][1]
    assert told['gap']['cut'] > 0.9
    again = load_part(part_file(tmp_path, found.improved.to_yaml()))
    assert again.hypothesis.effects == found.improved.hypothesis.effects


@pytest.mark.parametrize(('said', 'zero'), [('', 2.4), (', exhaust_zero_voltage: 2.65 V', 2.65)])
def test_exhaust_opens_from_its_edge_unless_the_file_says_otherwise(
    tmp_path: Path, said: str, zero: float
) -> None:
    edge = 'exhaust_voltage: 2.35 V'
    assert edge in VALVES
    part = load_part(part_file(tmp_path, VALVES.replace(edge, f'exhaust_voltage: 2.4 V{said}')))
    assert part.hypothesis.model.valve.exhaust_zero_voltage == zero
    assert load_part(part_file(tmp_path, part.to_yaml())).hypothesis == part.hypothesis


def test_dead_volume_is_told_from_an_effect(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, CHAMBERS))
    dead = (0.029, DEAD[1])
    runs = [chamber_run(f'run {i}', i, FILLS[i], (0.0, 0.0), dead) for i in (0, 1)]
    told = answer(find_out(part, runs[:1], runs[1:]))
    assert told['verdict'] == 'parameter'
    assert [one['name'] for one in told['parameters']] == ['cylinder.cap_dead_volume']
    assert told['parameters'][0]['value'] == pytest.approx(dead[0], rel=0.01)


def test_nothing_is_missing_where_nothing_is(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, CHAMBERS))
    runs = [chamber_run(f'run {i}', i, FILLS[i], (0.0, 0.0)) for i in (0, 1)]
    told = answer(find_out(part, runs[:1], runs[1:]))
    assert told['verdict'] == 'consistent'
    assert not told['where']


def test_pressure_dependent_friction_is_named(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, FRICTION))
    runs = [friction_run(f'{bar} bar', bar, 1e5 * bar, 1.2e-5, 2.5) for bar in (3, 5, 1, 7)]
    told = answer(find_out(part, runs[:2], runs[2:]))
    assert told['verdict'] == 'effect'
    assert told['effects'][0]['name'] == 'pressure_dependent_friction'
    slope = told['effects'][0]['parameters']['slope']
    assert slope['value'] == pytest.approx(1.2e-5, rel=0.05)
    assert told['gap']['cut'] > 0.8


def test_bent_opening_of_the_valves_is_named(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, VALVES))
    name = 'nonlinear_opening'
    truth = library.load(name).probes[-1]
    runs = [valve_run(part, f'run {i}', i, name, truth) for i in (0, 1)]
    told = answer(find_out(part, runs[:1], runs[1:]))
    assert told['verdict'] == 'effect'
    assert told['effects'][0]['name'] == name
    assert told['gap']['cut'] > 0.8


def gauge_table(folder: Path, name: str, supply: float, conditions: str) -> Path:
    """Return a text table of a run at a supply pressure, gauge pressures, with its conditions."""
    record = measured(timeline=((0.5, 2.0), (-0.5, 2.0)), supply_pressure=supply).record
    path = folder / f'{name}.csv'
    gauge = record.pressure_1 - 1e5, record.pressure_2 - 1e5
    columns = record.time, record.position, *gauge, record.voltage_1, record.voltage_2
    np.savetxt(path, np.column_stack(columns), '%.9g', ',', header='t,x,p1,p2,v1,v2', comments='')
    (folder / f'{name}.conditions.yaml').write_text(conditions)
    return path


@pytest.mark.parametrize(('known', 'verdict'), [(True, 'consistent'), (False, 'parameter')])
def test_runs_of_a_part_count_under_their_own_conditions(
    tmp_path: Path, known: bool, verdict: str
) -> None:
    mapping = tmp_path / 'map.yaml'
    mapping.write_text(GAUGE)
    tables = [
        gauge_table(tmp_path, f'run_{supply:.0f}', supply,
                    f'supply_pressure: {supply if known else 0.8 * supply} Pa')
        for supply in (6e5, 7e5)
    ]  # fmt: skip
    found = diagnose_part(tables[:1], Path('cylinder_1'), mapping, tables[1:], 'valves')
    assert found.verdict == verdict


def test_gauge_pressures_of_a_part_count_from_the_surroundings_of_the_run(tmp_path: Path) -> None:
    mapping = tmp_path / 'map.yaml'
    mapping.write_text(GAUGE)
    runs = [
        read_recording(gauge_table(tmp_path, 'run', 5e5, text), mapping, 'chambers', 1.1e5)
        for text in ('atmospheric_pressure: 0.9 bar', 'load_mass: 0 kg')
    ]
    np.testing.assert_allclose(runs[0]['pressure_1'] + 2e4, runs[1]['pressure_1'])
    assert [run.conditions['atmospheric_pressure'] for run in runs] == [0.9e5, 1.1e5]


@pytest.mark.parametrize('code', [0.5, 1.0])
def test_readings_of_a_coarse_converter_have_the_noise_of_its_rounding(
    tmp_path: Path, code: float
) -> None:
    part = load_part(part_file(tmp_path, FRICTION))
    runs = []
    for bar in (3, 5):
        run = friction_run('fine', bar, 1e5 * bar, 1.2e-5)
        signals = {**run.signals, 'force': np.round(run['force'] / code) * code}
        runs.append(recording(f'{bar} bar', run.interval, signals, 'friction'))
        assert runs[-1].noise['force'] == pytest.approx(code / np.sqrt(12.0), rel=0.5)
    told = answer(find_out(part, runs[:1], runs[1:]))
    assert all(np.isfinite(row['significance']) for row in told['where'])


def test_force_that_never_changes_is_refused(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, FRICTION))
    time = np.arange(0.0, 2.0, 0.01)
    signals = {'position': time, 'pressure_2': time + 1e5, 'force': np.full(time.size, 3.0)}
    run = recording('run', 0.01, signals, 'friction')
    with pytest.raises(RigError, match='run: force never changes'):
        find_out(part, [run], [run])


def test_valves_that_are_switched_all_the_time_are_refused(tmp_path: Path) -> None:
    part = load_part(part_file(tmp_path, VALVES))
    run = valve_run(part, 'pulsed', 0, 'nonlinear_opening', library.load('nonlinear_opening').null)
    pulses = np.where(np.arange(run.size) % 4 < 2, 0.5, -0.5)
    signals = {k: v for k, v in run.signals.items() if not k.startswith('voltage')} | {'u': pulses}
    pulsed = recording('pulsed', run.interval, signals, 'valves')
    with pytest.raises(RigError, match='pulsed: no flow can be told, for the voltages step'):
        find_out(part, [pulsed], [pulsed])


def test_position_does_not_jump_back() -> None:
    way = np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.0, 50)])
    shaken = way.copy()
    shaken[20] -= 0.03
    cleaned = without_jumps_back(shaken, 0.05)
    assert (np.diff(cleaned)[:49] >= 0.0).all()
    assert (np.diff(cleaned)[50:] <= 0.0).all()
    assert np.abs(cleaned - way).max() < 0.03


@pytest.mark.parametrize(
    ('old', 'new', 'message'),
    [
        ('part: chambers', 'part: chamber', "did you mean 'chambers'"),
        ('stroke: 2.03 m', 'stroke: 2.03 mm', 'unit mm'),
        (', stroke: 2.03 m', '', 'missing stroke'),
        ('[initial_pressure]', '[force_offset]', 'allowed: initial_pressure'),
        ('[0.02 m^3, 0.035 m^3]', '[0.03 m^3, 0.035 m^3]', 'not within'),
    ],
)
def test_wrong_part_file_is_told_in_one_line(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    path = part_file(tmp_path, CHAMBERS.replace(old, new))
    with pytest.raises(RigError) as error:
        load_part(path)
    assert message in str(error.value)
    assert '\n' not in str(error.value)


def test_signal_that_is_missing_is_named() -> None:
    with pytest.raises(RigError, match='no force or friction, needed for friction'):
        recording('run', 0.01, {'position': np.zeros(9), 'pressure_1': np.ones(9)}, 'friction')
