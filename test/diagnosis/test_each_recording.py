"""What differs from one recording to the next is not taken for a cause, if the file names it."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from scipy.signal import lfilter

from pneu_rig_ros.diagnosis.answer.random_effects import two_sided
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.nuisances import correlated_samples
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.effects import causes
from pneu_rig_ros.report.diagnosis_page import write_files

from .parts import (
    BENCH,
    CHAMBERS,
    CONDUCTANCES,
    LEAKING,
    WALL,
    bench_run,
    chamber_run,
    system_file,
    vessel_run,
)
from .runs import SCHEMA, checked, diagnosed, runs_of, tables_of

pytestmark = pytest.mark.timeout(600)

FILLS = ((4.5e5, 1.1e6), (5.5e5, 1.2e6))
CLOCK = 'each_recording: [clock_offset]\n'
WARM = 'each_recording: {initial_temperature: 30 K}\n'
HEAT = """
effects: {wall_heat_transfer: {conductance_1: 12.0 W/K, conductance_2: 25.0 W/K}}
"""
VESSEL_HEAT = """
effects: {wall_heat_transfer: {conductance_1: 0.5 W/K, conductance_2: 0.0 W/K}}
"""
LATE = 0.33
"""Of the pressures in the recording that is fitted [s]."""


def chambers(
    folder: Path,
    text: str,
    conductances: tuple[float, float] = (0.0, 0.0),
    late: float = 0.0,
    warm: float = 0.0,
    without: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the answer for sealed chambers of which the recording that is fitted is off."""
    signals = [
        chamber_run(0, FILLS[0], conductances, late=late, warm=warm),
        chamber_run(1, FILLS[1], conductances),
    ]
    return checked(diagnosed(folder, CHAMBERS + text, signals, without=without))


def vessel(folder: Path, text: str, leak: float) -> dict[str, Any]:
    """Return the answer for a leaking chamber that was just filled."""
    starts = ((6e5, 30.0), (5e5, 30.0), (7e5, 20.0))
    signals = [vessel_run(i, fill, warm, leak, 0.5) for i, (fill, warm) in enumerate(starts)]
    return checked(diagnosed(folder, LEAKING + text, signals, fitted=2))


def found(data: dict[str, Any], recording: str, name: str, key: str = 'value') -> float:
    """Return what an answer says of a recording [SI]."""
    rows = {(row['recording'], row['name']): row[key] for row in data['each_recording']}
    return float(rows[recording, name])


def test_offset_of_a_clock_is_no_cause_where_the_file_names_it(tmp_path: Path) -> None:
    data = chambers(tmp_path, CLOCK, late=LATE)
    assert data['verdict'] == 'consistent'
    assert {row['name'] for row in data['each_recording']} == {'clock_offset'}
    assert found(data, 'run_0', 'clock_offset') == pytest.approx(LATE, abs=2e-3)
    assert found(data, 'run_1', 'clock_offset') == pytest.approx(0.0, abs=2e-3)
    assert found(data, 'run_0', 'clock_offset', 'p_value') < 1e-6
    assert found(data, 'run_1', 'clock_offset', 'p_value') > 0.05


def test_offset_of_a_clock_is_a_disagreement_where_it_is_not_named(tmp_path: Path) -> None:
    others = [name for name in causes() if name != 'wall_heat_transfer']  # the name is no matter
    data = chambers(tmp_path, '', late=LATE, without=others)
    assert data['verdict'] != 'consistent'
    assert data['where']
    assert data['each_recording'] == []


@pytest.mark.long
def test_heat_transfer_is_named_despite_the_offset_of_a_clock(tmp_path: Path) -> None:
    data = chambers(tmp_path, CLOCK, CONDUCTANCES, LATE)
    assert data['verdict'] == 'effect'
    assert [one['name'] for one in data['effects']] == ['wall_heat_transfer']
    values = data['effects'][0]['parameters']
    for i, true in enumerate(CONDUCTANCES, start=1):
        assert values[f'conductance_{i}']['value'] == pytest.approx(true, rel=0.1)
    for pressure in ('pressure_1', 'pressure_2'):
        signal = data['gap']['signals'][pressure]
        assert signal['after'] < 0.05 * signal['before']  # up to 0.03, by the noise
    assert found(data, 'run_0', 'clock_offset') == pytest.approx(LATE, abs=5e-3)


def test_warm_gas_is_no_cause_where_the_file_names_it(tmp_path: Path) -> None:
    data = chambers(tmp_path, HEAT + WARM, CONDUCTANCES, warm=30.0)
    assert data['verdict'] == 'consistent'
    for i in (1, 2):
        name = f'initial_temperature_{i}'
        assert found(data, 'run_0', name) == pytest.approx(WALL + 30.0, abs=1.0)
        low, high = next(
            row['interval']
            for row in data['each_recording']
            if (row['recording'], row['name']) == ('run_0', name)
        )
        assert low < WALL + 30.0 < high < low + 10.0
        assert found(data, 'run_1', name) == pytest.approx(WALL, abs=1.0)


def test_warm_gas_is_a_disagreement_where_it_is_not_named(tmp_path: Path) -> None:
    assert chambers(tmp_path, HEAT, CONDUCTANCES, warm=30.0)['verdict'] != 'consistent'


@pytest.mark.parametrize(
    ('difference', 'deviation', 'p_value'),
    [(0.0, 1.0, 1.0), (1.959964, 1.0, 0.05), (-0.1, 0.0388226, 0.01)],
)
def test_p_value_is_that_of_a_normal_error(
    difference: float, deviation: float, p_value: float
) -> None:
    found = two_sided(np.array(difference), np.array(deviation))
    assert found == pytest.approx(p_value, rel=1e-4)


def make_gap(path: Path) -> None:
    """Remove samples from a table with a step of 0.1 s, so that one step is 0.25 s."""
    rows = np.loadtxt(path, delimiter=',', skiprows=1)
    rows[502] = rows[501:503].mean(axis=0)
    rows = np.delete(rows, [500, 501], axis=0)
    np.savetxt(path, rows, '%.9g', ',', header='time,pressure_1', comments='')


@pytest.mark.parametrize('lag', [0.0, 0.9])
def test_correlated_samples_of_an_autoregressive_process(lag: float) -> None:
    noise = np.random.default_rng(1).standard_normal((20_000, 2))
    values = lfilter([1.0], [1.0, -lag], noise, axis=0)
    assert correlated_samples(values) == pytest.approx((1.0 + lag) / (1.0 - lag), rel=0.1)


def test_interpolation_over_a_long_step_is_noted(tmp_path: Path) -> None:
    signals = [vessel_run(i, fill, 20.0, 0.0, 0.5) for i, fill in enumerate((6e5, 5e5))]
    paths, known = tables_of(tmp_path, signals)
    make_gap(paths[0])
    system = system_file(tmp_path, LEAKING + VESSEL_HEAT + WARM)
    diagnosis = diagnose(paths[:1], system, paths[1:], mapping=known)
    (tmp_path / 'answer').mkdir()
    shares: list[float] = []
    write_files(tmp_path / 'answer', diagnosis, answer(diagnosis), shares.append)
    assert shares[-1] == 1.0
    data = json.loads((tmp_path / 'answer' / 'diagnosis.json').read_text())
    jsonschema.validate(data, json.loads(SCHEMA.read_text()))
    notes = (
        'time steps of 100 to 250 ms: interpolated onto steps of 100 ms',
        '1 of 1000 samples are missing',
    )
    assert data['notes'] == [{'recording': 'run_0', 'note': note} for note in notes]
    page = (tmp_path / 'answer' / 'report.html').read_text()
    assert all(f'<li>run_0: {note}</li>' in page for note in notes)
    assert '<h2>Each recording</h2>' in page
    assert '<td>initial temperature 1</td>' in page


@pytest.mark.parametrize(
    ('places', 'notes'),
    [
        ([], ()),
        ([250], ('1 wrong position reading replaced',)),
        ([250, 820], ('2 wrong position readings replaced',)),
    ],
)
def test_replaced_readings_of_a_bench_are_counted(
    tmp_path: Path, places: list[int], notes: tuple[str, ...]
) -> None:
    signals = bench_run(0, 3e5, 0.0)
    signals['position'][places] -= 0.4e-3
    system = load_system(system_file(tmp_path, BENCH))
    (run,) = runs_of(system, tmp_path, [signals], 0.01)
    assert run.notes == notes


@pytest.mark.parametrize('leak', [0.0, 5e-9])
def test_leak_of_a_chamber_that_was_just_filled(tmp_path: Path, leak: float) -> None:
    data = vessel(tmp_path, VESSEL_HEAT + WARM, leak)
    if not leak:
        assert data['verdict'] == 'consistent'
        return
    assert [one['name'] for one in data['effects']] == ['chamber_leak']
    area = data['effects'][0]['parameters']['area_1']['value']
    assert area == pytest.approx(leak, rel=0.02)


def test_what_cools_a_chamber_that_was_just_filled_is_told_from_a_leak(tmp_path: Path) -> None:
    data = vessel(tmp_path, WARM, 0.0)
    assert [one['name'] for one in data['effects']] == ['wall_heat_transfer']
    value = data['effects'][0]['parameters']['conductance_1']['value']
    assert value == pytest.approx(0.5, rel=0.03)


@pytest.fixture
def late_run(tmp_path: Path) -> Run:
    """Return a run whose pressures are late."""
    system = load_system(system_file(tmp_path, CHAMBERS + CLOCK))
    return runs_of(system, tmp_path, [chamber_run(0, FILLS[0], (0.0, 0.0), late=LATE)])[0]


def test_pressures_are_put_right_by_interpolation(late_run: Run) -> None:
    right = late_run.with_delay(LATE)
    assert right.size == late_run.size
    assert right.begin == late_run.begin == pytest.approx(0.9)
    np.testing.assert_array_equal(right.position, late_run.position)
    np.testing.assert_array_equal(right.with_delay(0.0).pressures, late_run.pressures)
    # adiabatic: p V^k is what it was
    volume = 0.025 + 0.0127 * right.position
    adiabat = right.pressures[:, 0] * volume**1.4
    assert float(adiabat.std() / adiabat.mean()) < 1e-3
    before = late_run.pressures[:, 0] * volume**1.4
    assert float(before.std() / before.mean()) > 1e-2


def test_recording_that_is_too_short_for_its_clock_is_refused(tmp_path: Path) -> None:
    short = chamber_run(0, FILLS[0], (0.0, 0.0), duration=2.5)
    system = load_system(system_file(tmp_path, CHAMBERS + CLOCK))
    with pytest.raises(RigError, match=r'2\.40 s, at least 2\.8 s needed'):
        runs_of(system, tmp_path, [short])
