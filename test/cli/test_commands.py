"""Each command does what its help says and answers mistakes in one line."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from terminal import COMMAND, Terminal

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.cli import command
from pneu_rig_ros.model.quantity import specifications
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.rig.configuration import Sampling


def until(condition: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    """Wait for a condition while a process runs."""
    deadline = time.monotonic() + 150.0
    while not condition():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)  # the processors are for what is waited for


@pytest.mark.parametrize('name', ['', *command.commands])
def test_help_has_examples(terminal: Terminal, name: str) -> None:
    text = terminal.output(*([name] if name else []), '--help')
    assert 'Examples:\n' in text
    assert f'pneu-rig {name}'.strip() in text.split('Examples:')[1]
    assert max(map(len, text.splitlines())) < 100


@pytest.mark.parametrize('name', ['demo', 'simulate'])
def test_options_name_their_units(terminal: Terminal, name: str) -> None:
    text = terminal.output(name, '--help')
    for unit in ('--u VOLT', '--duration SECOND', 'PASCAL', 'KILOGRAM', 'METRE'):
        assert unit in text


@pytest.mark.parametrize('name', ['demo', 'simulate', 'diagnose', 'gap'])
def test_seeds_are_those_of_a_rig(terminal: Terminal, name: str) -> None:
    largest = specifications(Sampling)['seed'].high
    assert f'0<=x<={largest:.0f}]' in terminal.output(name, '--help')
    line = terminal.refusal(name, '--seed', -1)
    assert f"'--seed': -1 is not in the range 0<=x<={largest}; see" in line


def test_without_arguments_the_help_is_shown(terminal: Terminal) -> None:
    assert terminal.run() == terminal.run('--help')


def test_import_is_light() -> None:
    heavy = 'rclpy numba matplotlib numpy scipy rich rosbags mcap yaml'
    code = f'import sys, pneu_rig_ros.cli; print([n for n in {heavy.split()} if n in sys.modules])'
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert run.stdout == '[]\n'


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (['simulate', '--u', 'fast'], "'fast' is not a valid number; see: pneu-rig simulate"),
        (['simulate', '--u', '3'], "'--u': 3.0 is not in the range -2.5<=x<=2.5"),
        (['simulate', '--u', 'nan'], "'--u': 'nan' is not a finite number"),
        (['simulate', '--duration', '0'], "'--duration': 0.0 is not in the range 0.0<x<=86400"),
        (['simulate', '--duration', 'inf'], "'--duration': inf is not in the range 0.0<x<=86400"),
        (['simulate', '--cylinder', 'cylindr_2'], "did you mean 'cylinder_2'"),
        (['simulate', '--supply-pressure', '4'], '--supply-pressure: 4 Pa is not within'),
        (
            ['simulate', '--initial-position', '0.3'],
            '--initial-position: 0.3 m is not within 0 to',
        ),
        (['simulate', '--friction', 'coulomb'], "--friction: unknown name 'coulomb'"),
        (['simulate', '--sensors', 'good'], "--sensors: unknown name 'good'"),
        (['diagnose', 'a', '--model', 'm', '--out', 'o', '--seed', '1.5'], 'not a valid integer;'),
        (['replay', 'a', '--rate', '0'], "'--rate': 0.0 is not in the range 0.01<=x<=100"),
        (['replay', 'a', '--rate', 'nan'], "'nan' is not a finite number"),
        (['replay', 'a', '--delay', '-1'], "'--delay': -1.0 is not in the range 0.0<=x<=3600"),
        (['replay', 'a', '--subscribers', '-1'], "'--subscribers': -1 is not in the range 0<="),
        (['simulate', '--out', '/proc/bag'], 'cannot write the bag /proc/bag'),
        (['simulate', '--out', f'new/{300 * "x"}'], 'File name too long'),
        (['simulate', '--out', f'{__file__}/bag'], f'--out {__file__}: File exists; name a new'),
        (['diagnose', 'no', '--model', 'cylinder_1', '--out', 'a/b/c'], 'no does not exist'),
        (['simulate', '--png', 'no/where.png'], 'there is no directory no; create it first'),
        (['simulate', '--png', 'p.gif'], '--png p.gif: the name must end in .png'),
        (['friction', 'nowhere', '--png', 'p'], '--png p: the name must end in .png'),
        (['demo', '--u', '-9'], "'--u': -9.0 is not in the range -2.5<=x<=2.5"),
        (['demo', '--load-mass', '-1'], '--load-mass: -1 kg'),
        (['info'], "Missing argument 'BAG'; see: pneu-rig info --help"),
        (['info', 'nowhere'], 'nowhere does not exist'),
        (['friction', '.'], 'holds no .mcap file'),
        (['friction', __file__], 'is not a bag; pass the bag directory'),
        (['export', 'nowhere', '--csv', '--parquet'], 'choose one: --csv or --parquet'),
        (['repair', 'nowhere'], 'nowhere does not exist'),
        (['simulat'], "No such command 'simulat'"),
    ],
    ids=lambda value: ' '.join(value) if isinstance(value, list) else '',
)
def test_mistake_is_told_in_one_line(
    terminal: Terminal, arguments: list[str], complaint: str
) -> None:
    assert complaint in terminal.refusal(*arguments)
    assert list(terminal.directory.iterdir()) == []


def test_error_of_the_program_has_a_code_of_its_own(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(**_: object) -> None:
        raise ZeroDivisionError('a defect')

    monkeypatch.setattr(command.commands['info'], 'callback', broken)
    outcome = terminal.run('info', terminal.directory)
    assert outcome.code == 1
    assert outcome.out == ''
    assert 'unexpected ZeroDivisionError: a defect' in outcome.err
    assert outcome.err.count('\n') == 1


def test_simulate_records_and_summarises(terminal: Terminal) -> None:
    options = ('--cylinder', 'cylinder_1', '--u', 0.3, '--seed', 4, '--png', 'p.png')
    printed = terminal.output('simulate', '--duration', 2, *options)
    (bag,) = Path('runs').iterdir()
    assert bag.name.endswith('_cylinder_1')
    assert f'bag                {bag}\n' in printed
    assert 'picture            p.png\n' in printed
    assert Path('p.png').stat().st_size < 200_000
    record = read_recording(bag)
    assert record.position.size == 1725
    assert record.metadata['seed'] == '4'


def test_simulate_never_overwrites(terminal: Terminal) -> None:
    terminal.output('simulate', '--duration', 0.1, '--out', 'bag')
    before = Path('bag/bag.mcap').read_bytes()
    again = terminal.refusal('simulate', '--duration', 0.1, '--out', 'bag')
    assert '--out bag exists; name a directory that does not' in again
    assert Path('bag/bag.mcap').read_bytes() == before
    for _ in range(2):
        terminal.output('simulate', '--duration', 0.01)
    assert len(list(Path('runs').iterdir())) == 2


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_interrupted_simulation_leaves_a_whole_bag(terminal: Terminal, number: int) -> None:
    with terminal.start('simulate', '--duration', 80_000, '--out', 'bag') as process:
        file = terminal.directory / 'bag' / 'bag.mcap'
        until(lambda: file.exists() and file.stat().st_size > 100_000, process)
        os.kill(process.pid, number)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out == ''
    assert err.strip().endswith('pneu-rig: interrupted')
    assert 'Traceback' not in err
    assert read_recording(terminal.directory / 'bag').position.size > 100


def test_info_as_json_is_plain_data(terminal: Terminal, bag: Path) -> None:
    data = json.loads(terminal.output('info', bag, '--json'))
    assert data['cylinder'] == 'cylinder_2'
    assert data['samples'] == data['messages']['joint_states'] == 2587
    assert set(data['lost'].values()) == {0}
    assert data['cycle_count'] == len(data['cycles'])


def test_info_lists_topics_and_origin(terminal: Terminal, bag: Path) -> None:
    text = terminal.output('info', bag)
    assert 'lost samples       joint_states 0' in text
    assert 'written by         pneu_rig_ros ' in text
    row = next(line for line in text.splitlines() if line.startswith('chamber_1/pressure'))
    assert row.split() == ['chamber_1/pressure', 'sensor_msgs/msg/FluidPressure', '2587', '0']


@pytest.mark.parametrize('option', ['', '--json'])
def test_output_stops_quietly_when_its_reader_does(bag: Path, option: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [*COMMAND, 'info', str(bag), *([option] if option else [])]
    with os.fdopen(writing, 'w') as pipe:
        run = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr == ''


def test_friction_csv_has_the_offline_estimate(terminal: Terminal, bag: Path) -> None:
    printed = terminal.output('friction', bag, '--csv', 'f.csv', '--png', 'f.png')
    assert 'peak friction [N]' in printed
    record = read_recording(bag)
    table = np.genfromtxt('f.csv', delimiter=',', names=True)
    assert table.dtype.names == (
        'time_s',
        'position_m',
        'velocity_m_per_s',
        'pressure_1_Pa',
        'pressure_2_Pa',
        'friction_N',
    )
    np.testing.assert_allclose(table['friction_N'], friction_of(record), rtol=1e-8)
    np.testing.assert_allclose(table['time_s'], record.time, atol=1e-9)
    assert Path('f.png').exists()
    terminal.refusal('friction', bag, '--csv', 'f.csv')


def test_friction_as_json(terminal: Terminal, bag: Path) -> None:
    data = json.loads(terminal.output('friction', bag, '--json'))
    assert data['peak_friction'] == max(cycle['peak_friction'] for cycle in data['cycles'])


def test_repair_mends_and_then_has_nothing_to_do(terminal: Terminal, bag: Path) -> None:
    Path('cut').mkdir()
    Path('cut/cut.mcap').write_bytes((bag / 'stroke.mcap').read_bytes()[:1_200_000])
    assert 'run: pneu-rig repair cut' in terminal.refusal('info', 'cut')
    assert 'cut is repaired: ' in terminal.output('repair', 'cut')
    terminal.output('info', 'cut')
    assert 'cut is healthy' in terminal.output('repair', 'cut')
    assert sorted(file.name for file in Path('cut').iterdir()) == [
        'cut.mcap',
        'cut.mcap.cut',
        'metadata.yaml',
    ]


def test_repair_says_what_it_left_out(terminal: Terminal, bag: Path) -> None:
    file = Path(shutil.copytree(bag, 'bag')) / 'stroke.mcap'
    data = bytearray(file.read_bytes())
    data[data.index(b'cap_dead_volume')] ^= 1
    file.write_bytes(data)
    printed = terminal.output('repair', 'bag')
    assert '\n1 damaged chunk is omitted\n' in printed
    assert 'configuration' not in printed
    shutil.copy('bag/stroke.mcap.cut', file)
    Path('bag/metadata.yaml').unlink()
    printed = terminal.output('repair', 'bag')
    assert '\nthe rig configuration was lost with a damaged chunk; friction' in printed
