"""Recordings that cannot be diagnosed are refused in one line that says why."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run
from pneu_rig_ros.diagnosis.inputs.read_inputs import read_recordings, split_paths
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.simulate import simulate

from .parts import BENCH, BLOCK, CHAMBERS, bench_run, chamber_run, system_file
from .runs import changed, configured, runs_of, tables_of

SENSORS = """
sensors: {{kind: rig, resolution: 12 bit, position_span: {position_span} m, position_class: 0 -,
          position_noise: 2e-6 m, pressure_span: 1e6 Pa, pressure_class: 0 -,
          pressure_noise: 150 Pa, velocity_cutoff: 32 Hz}}
"""


def refused(act: Callable[[], object]) -> str:
    """Return the only line in which something is refused."""
    with pytest.raises(RigError) as error:
        act()
    assert '\n' not in str(error.value)
    return str(error.value)


def rig_signals(size: int = 2000) -> dict[str, np.ndarray]:
    """Return signals of a rig that could be."""
    rng = np.random.default_rng(0)
    x = np.linspace(0.05, 0.2, size) + rng.normal(0.0, 5e-5, size)
    p1, p2 = 3e5 + rng.normal(0.0, 200.0, (2, size))
    return {'position': x, 'pressure_1': p1, 'pressure_2': p2, 'u': np.full(size, 0.3)}


def prepared(
    signals: dict[str, np.ndarray],
    system: System | None = None,
    interval_ns: int = 1_160_000,
    **more: Any,
) -> Run:
    """Return signals as a run of a system, of cylinder 1 if none is given."""
    recording = Recording('run', 0, interval_ns, signals, **more)
    return prepare_run(recording, system or load_system('cylinder_1'), Path('run.csv'))


def said_of(*args: Any, **options: Any) -> str:
    return refused(lambda: prepared(*args, **options))


def test_recording_without_an_open_balance_says_what_each_lacks(tmp_path: Path) -> None:
    signals = chamber_run(0, (4.5e5, 1.1e6), (0.0, 0.0), duration=20.0)
    alone, system = {'position': signals['position']}, load_system(system_file(tmp_path, CHAMBERS))
    line = refused(lambda: runs_of(system, tmp_path, [alone]))
    assert line.startswith(f'{tmp_path / "run_0.csv"}: no balance can be compared')
    assert 'gas_1 needs signal pressure_1' in line
    assert 'gas_2 needs signal pressure_2' in line
    assert 'force needs friction.model' in line


@pytest.mark.parametrize('name', ['position', 'pressure_1', 'pressure_2'])
def test_signal_that_never_changes_is_refused(name: str) -> None:
    signals = rig_signals()
    signals[name] = np.full(2000, signals[name][0])
    line = said_of(signals)
    assert f'run.csv: {name} is' in line
    assert 'throughout' in line


def test_force_of_a_bench_that_never_changes_is_refused(tmp_path: Path) -> None:
    signals = bench_run(0, 3e5, 0.0)
    signals['force'] = np.full(signals['force'].size, 3.0)
    system = load_system(system_file(tmp_path, BENCH))
    line = said_of(signals, system, 10_000_000)
    assert 'force is 3 throughout' in line


def test_held_position_need_not_be_recorded_but_must_not_be_constant(tmp_path: Path) -> None:
    system = load_system(system_file(tmp_path, BLOCK))
    signals = {k: v for k, v in rig_signals().items() if k != 'position'}
    held = prepared(signals, system)
    assert held.balances == {'gas_1', 'gas_2'}
    np.testing.assert_array_equal(held.position, 0.1)


def test_signal_at_the_end_of_its_span_is_refused() -> None:
    end = configured('cylinder_1').sensors.pressure_span + 1e5
    signals = rig_signals()
    rng = np.random.default_rng(1)
    signals['pressure_1'] = np.minimum(end + rng.normal(300.0, 200.0, 2000), end)
    signals['pressure_1'][:600] -= 5e5  # seven tenths of it are at the end
    line = said_of(signals, conditions={'supply_pressure': 7e5})
    assert 'pressure_1 is at the end of its sensor' in line
    share = float(line.split('for ')[1].split('%')[0])
    assert 60.0 < share < 70.0  # less what noise takes away from the end


def test_signal_of_a_bench_at_the_end_of_its_span_is_refused(tmp_path: Path) -> None:
    sensors = SENSORS.format(position_span=0.05)
    system = load_system(system_file(tmp_path, f'{BENCH}{sensors}'))
    signals = bench_run(0, 3e5, 0.0)
    signals['position'] = np.minimum(signals['position'] + 0.01, 0.05)
    signals['position'][::50] -= 1e-4
    line = said_of(signals, system, 10_000_000)
    assert "run.csv: position is at the end of its sensor's span (0.05)" in line


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_force_that_is_cut_off_most_of_the_time_is_refused(tmp_path: Path, sign: float) -> None:
    system = load_system(system_file(tmp_path, BENCH))
    signals = bench_run(0, 3e5, 0.0)
    end = np.quantile(signals['force'], 0.3)
    signals['force'] = sign * np.minimum(signals['force'], end)
    line = said_of(signals, system, 10_000_000)
    assert f"force is at the end of its sensor's span ({sign * end:g}) for 70% of the time" in line


def test_signal_at_the_lower_end_of_its_span_is_not_refused() -> None:
    """An exhausted chamber rests at the pressure of the surroundings."""
    signals = rig_signals()
    signals['pressure_1'] = np.maximum(signals['pressure_1'] - 2e5, 1e5)
    run = prepared(signals)
    assert np.mean(run.pressures[:, 0] == run.span.low) > 0.4


def test_recording_that_is_too_short_is_refused() -> None:
    line = said_of({name: values[:500] for name, values in rig_signals().items()})
    assert line == 'run.csv: 0.58 s, at least 1 s needed'


@pytest.mark.parametrize('size', [21, 300])
def test_gap_is_refused_where_no_sample_can_be_guessed(size: int) -> None:
    stamps = 1_160_000 * np.arange(500, 500 + size)
    missing = {'position': stamps, 'friction': 1_160_000 * np.arange(1000)}
    if size <= 22:  # 25 ms
        assert prepared(rig_signals(), missing=missing).size == 2000
        return
    line = said_of(rig_signals(), missing=missing)
    assert line == (
        'run.csv: 300 samples of position are missing in succession, from 0.58 to 0.93 s, '
        'at most 22 allowed; cut the recording there'
    )


def test_rig_sampled_too_slowly_is_refused() -> None:
    line = said_of(rig_signals(), interval_ns=50_000_000)
    assert 'a sample every 50 ms, at most 20 ms allowed' in line


def test_recordings_of_two_cylinders_are_refused(tmp_path: Path) -> None:
    bags = [
        simulate(configured(name), 0.34, 1.5, tmp_path / name)
        for name in ('cylinder_1', 'cylinder_2')
    ]
    line = refused(lambda: diagnose(bags, 'cylinder_1'))
    assert line.startswith('cylinder_2: recorded with another cylinder than cylinder_1')


def test_recording_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    path = tmp_path / 'b'
    line = refused(lambda: split_paths([path], []))
    assert line == f'{path} does not exist; give a bag or a text table'


def test_one_recording_twice_is_refused(tmp_path: Path) -> None:
    (tmp_path / 'a').mkdir()
    again = tmp_path / '.' / 'a'
    assert 'given twice' in refused(lambda: split_paths([tmp_path / 'a'], [again]))


@pytest.mark.parametrize(
    ('names', 'fitted', 'held'),
    [('ab', 'a', 'b'), ('abc', 'ab', 'c'), ('abcdef', 'abde', 'cf'), ('abcd', 'abd', 'c')],
)
def test_every_third_recording_is_left_out(
    tmp_path: Path, names: str, fitted: str, held: str
) -> None:
    for name in names:
        (tmp_path / name).mkdir()
    parts = split_paths([tmp_path / name for name in names], [])
    assert tuple(''.join(path.name for path in part) for part in parts) == (fitted, held)


def test_value_that_is_no_number_is_told_with_its_place(tmp_path: Path) -> None:
    signals = chamber_run(0, (4.5e5, 1.1e6), (0.0, 0.0), duration=20.0)
    (path,), known = tables_of(tmp_path, [signals])
    lines = path.read_text().splitlines()
    lines[7] = 'nan,' + lines[7].split(',', 1)[1]
    path.write_text('\n'.join(lines))
    system = load_system(system_file(tmp_path, CHAMBERS))
    line = refused(lambda: read_recordings([path], system, known))
    assert 'row 8' in line


def test_recordings_with_different_valves_are_refused(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    other = changed(rig, 'valve', intake_coefficient=6e-8)
    bags = [
        simulate(each, 0.34, 1.5, tmp_path / name)
        for name, each in (('first', rig), ('second', other))
    ]
    line = refused(lambda: diagnose(bags, 'cylinder_1'))
    assert line.startswith('second: recorded with another valve than first')
