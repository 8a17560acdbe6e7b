"""A sweep: its grid, its numbers, the same wherever it is run, and what it refuses."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from terminal import Terminal

from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import SerialExecutor, open_executor
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages
from pneu_rig_ros.sweep import at_point, axis, check_size, grid, sweep

RIG = load_configuration('cylinder_1')
AXES = [axis('u', '0.3:0.6:18'), axis('chamber_leak.area_1', '0,2e-9')]


def test_values_are_numbers_lists_and_ranges() -> None:
    assert axis('u', '0.3').values == (0.3,)
    assert axis('load_mass', '0.2,1').values == (0.2, 1.0)
    assert axis('supply_pressure', '4e5:8e5:5').values == (4e5, 5e5, 6e5, 7e5, 8e5)
    law = axis('friction.model', 'lugre,revised_lugre')
    assert [law.shown(value) for value in law.values] == ['lugre', 'revised_lugre']
    assert check_size(AXES) == len(grid(AXES)) == 36
    assert grid(AXES)[1] == (0.3, 2e-9)


def test_a_point_is_the_rig_with_its_values() -> None:
    names = ('u', 'load_mass', 'friction.coulomb_force', 'inclination.angle')
    rig = at_point(RIG, names, (0.3, 2.0, 4.0, 0.1))
    assert rig.model.operation.load_mass == 2.0
    assert rig.model.friction.coulomb_force == 4.0
    assert rig.effects['inclination'].angle == 0.1


@pytest.mark.parametrize(
    ('name', 'text', 'complaint'),
    [
        ('voltage', '1', "unknown name 'voltage'"),
        ('friction.coulomb', '1', "did you mean 'coulomb_force'"),
        ('leak.area', '1', "leak.area: unknown name 'leak', allowed: cylinder, friction"),
        ('u', '3', 'not within -2.5 to 2.5'),
        ('u', '0.1:0.2', 'LOW:HIGH:COUNT'),
        ('u', '0.1:0.2:1', 'LOW:HIGH:COUNT'),
        ('u', 'nan', 'not within'),
        ('friction.model', 'newton', "unknown name 'newton'"),
    ],
)
def test_what_is_no_axis_is_refused(name: str, text: str, complaint: str) -> None:
    with pytest.raises(RigError, match=complaint):
        axis(name, text)


def test_a_grid_that_is_too_large_or_twice_the_same_is_refused() -> None:
    with pytest.raises(RigError, match='varied twice'):
        check_size([AXES[0], AXES[0]])
    with pytest.raises(RigError, match='at most'):
        check_size([axis('u', '0:1:1001'), axis('load_mass', '0:1:1001')])


def test_a_grid_without_a_command_is_refused() -> None:
    with pytest.raises(RigError, match='command u is missing'):
        sweep(RIG, [axis('load_mass', '0,1')], 20.0, SerialExecutor())


def test_numbers_are_those_of_a_single_run() -> None:
    row = sweep(RIG, [axis('u', '0.5')], 60.0, SerialExecutor())[0]
    interval = RIG.interval_ns * 1e-9
    held = np.tile(valve_voltages(0.5), (round(row.stroke_time / interval), 1))
    run = Plant(RIG.model).run(held, interval)
    cycles = find_cycles(run.position, interval, run.friction_force)
    assert row.stroke_time == run.time[-1]
    assert row.cycles == len(cycles)
    assert row.first_dwell == cycles[0].dwell
    assert row.peak_friction == max(cycle.peak_friction for cycle in cycles)


def test_same_table_bit_by_bit_whatever_the_workers() -> None:
    done: list[int] = []
    alone = sweep(RIG, AXES, 10.0, SerialExecutor(), done.append)
    assert done == [16, 32, 36]
    with open_executor(2) as processes:
        assert repr(sweep(RIG, AXES, 10.0, processes)) == repr(alone)


def test_command_writes_a_table_and_prints_plain_data(
    terminal: Terminal,
) -> None:
    arguments = ['--u', '0,0.6', '--vary', 'friction.model=lugre', '--longest', '30']
    data = json.loads(terminal.output('sweep', *arguments, '--out', 'table.csv', '--json'))
    rows = list(csv.DictReader(io.StringIO(Path('table.csv').read_text())))
    assert [row['u_V'] for row in rows] == ['0.0', '0.6']
    assert rows[0]['stroke_time_s'] == ''
    assert data['strokes'][0]['stroke_time'] is None
    assert float(rows[1]['stroke_time_s']) == data['strokes'][1]['stroke_time']
    assert data['strokes'][1]['friction.model'] == 'lugre'
    assert data['units']['stroke_time'] == 's'


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (['--u', '9'], 'not within'),
        (['--vary', 'u=3'], 'expected KEY=VALUES'),
        (['--longest', '0'], "'--longest': 0.0"),
        (['--initial-position', '5'], 'initial_position: 5 m is not within 0 to 0.2 m'),
        (['--out', '/nowhere/t.csv'], 'there is no directory'),
        (['--scheduler', 'host'], '--scheduler host: no Dask scheduler answers'),
    ],
)
def test_mistake_is_told_in_one_line(
    terminal: Terminal, arguments: list[str], complaint: str
) -> None:
    assert complaint in terminal.refusal('sweep', *arguments)
