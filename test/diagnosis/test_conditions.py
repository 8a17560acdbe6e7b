"""What is not as stated: the zero of the position, the clock, the sensors, unit and cylinder."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.misstatement import find_misstatement
from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.hypothesis import POSITION_ZERO, SENSOR_CLOCK, Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.recording import Recording

from .runs import configured, recorded, system_of

ATMOSPHERE, PSI_BY_BAR = 1e5, 0.06894757
NAME = Path('run')


@pytest.fixture(scope='module')
def as_stated() -> Recording:
    return recorded('run', configured('cylinder_1'))


@pytest.fixture
def system(tmp_path: Path) -> System:
    return system_of(tmp_path, configured('cylinder_1'))


def run_of(recording: Recording, system: System) -> Run:
    return prepare_run(recording, system, NAME)


def exchanged(recording: Recording) -> Recording:
    p1, p2 = recording['pressure_1'], recording['pressure_2']
    return recording.with_signals(pressure_1=p2, pressure_2=p1)


def in_psi(recording: Recording) -> Recording:
    pressures = {
        name: ATMOSPHERE + PSI_BY_BAR * (recording[name] - ATMOSPHERE)
        for name in ('pressure_1', 'pressure_2')
    }
    return recording.with_signals(**pressures)


def found(recording: Recording, system: System) -> tuple[str, str] | None:
    result = find_misstatement(system, [recording], [run_of(recording, system)], [NAME])
    return None if result is None else (result.name, result.true)


@pytest.mark.parametrize(
    ('change', 'name'),
    [(exchanged, 'exchanged_chambers'), (in_psi, 'pressure_unit')],
)
def test_wrong_statement_is_found_with_the_recording_then(
    as_stated: Recording,
    system: System,
    change: Callable[[Recording], Recording],
    name: str,
) -> None:
    wrong = change(as_stated)
    result = find_misstatement(system, [wrong], [run_of(wrong, system)], [NAME])
    assert result is not None
    assert result.name == name
    (run,) = result.runs
    right = run_of(as_stated, system)
    np.testing.assert_allclose(run.pressures, right.pressures, rtol=1e-9)


def test_another_cylinder_is_found(tmp_path: Path) -> None:
    recording = recorded('run', configured('cylinder_2', initial_position=0.01))
    system = system_of(tmp_path, configured('cylinder_1'))
    assert found(recording, system) == ('cylinder', 'cylinder_2')


def test_nothing_is_otherwise_where_all_is_as_stated(as_stated: Recording, system: System) -> None:
    assert found(as_stated, system) is None


def test_strong_effect_is_no_wrong_statement(system: System) -> None:
    leak = library.load('chamber_leak')
    rig = configured('cylinder_1', {'chamber_leak': leak.parameters(3e-7, 0.0)})
    assert found(recorded('run', rig), system) is None


def worst(run: Run, hypothesis: Hypothesis, reference: Run) -> float:
    """Return the largest RMS of gas residuals that differ from those of another run [kg/s]."""
    rows = [
        np.array(Comparison(each).residuals(given)[:2])
        for each, given in ((run, hypothesis), (reference, replace(hypothesis, conditions={})))
    ]
    inside = slice(20, -20)  # of the windows at the ends a shifted command is not known
    return float(np.sqrt(np.mean((rows[0] - rows[1])[:, inside] ** 2, axis=1)).max())


def test_zero_of_the_position_is_taken_from_the_readings(
    as_stated: Recording, system: System
) -> None:
    zero, reference = 3e-3, run_of(as_stated, system)
    off = run_of(as_stated.with_signals(position=as_stated['position'] + zero), system)
    given = system.hypothesis
    right = given.with_condition(POSITION_ZERO, zero)
    assert worst(off, right, reference) < 0.01 * worst(off, given, reference)


@pytest.mark.parametrize('samples', [-60, 100])
def test_clock_of_the_sensors_shifts_the_commands(
    as_stated: Recording, system: System, samples: int
) -> None:
    reference, late = run_of(as_stated, system), {}
    for name in ('voltage_1', 'voltage_2'):
        late[name] = np.roll(as_stated[name], -samples)  # the sensors' stamps are later
    off = run_of(as_stated.with_signals(**late), system)
    given = system.hypothesis
    right = given.with_condition(SENSOR_CLOCK, samples * off.interval)
    assert worst(off, right, reference) < 0.05 * worst(off, given, reference)
