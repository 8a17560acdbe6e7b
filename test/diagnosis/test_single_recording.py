"""One recording alone: its last part is held out; a vessel that hardly leaks is called tight."""

import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pneu_rig_ros.diagnosis.inputs.vessels import is_empty, shut_at
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.simulate import simulate

from .parts import BENCH, CHAMBERS, CONDUCTANCES, LEAKING, bench_run, chamber_run
from .runs import configured, diagnosed

OUTSIDE, FILL, DURATION = 1e5, 9e5, 140.0
WANDER = 250.0
"""Standard deviation of a slow error of the pressure sensor, as real ones have [Pa]."""


def emptied(seed: int, exponent: float, lost: float) -> dict[str, np.ndarray]:
    """
    Return the pressure in a vessel whose mass flow is as (p - p_atm)^n, at constant temperature.

    :param lost: share of the gauge pressure that is lost
    """
    gauge, time = FILL - OUTSIDE, np.arange(0.0, DURATION, 0.1)
    rest = gauge * (1.0 - lost)
    # of d(gauge)/dt = -c gauge^n
    power = 1.0 - exponent
    rate = (gauge**power - rest**power) / (power * DURATION)
    run = solve_ivp(
        lambda t, p: -rate * p**exponent, (0.0, time[-1]), [gauge], t_eval=time, rtol=1e-9
    )
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(size=time.size + 200))
    wander = walk[100:-100] - np.convolve(walk, np.full(201, 1.0 / 201.0), 'valid')
    noise = rng.normal(0.0, 120.0, time.size) + WANDER * wander / wander.std()
    return {'pressure_1': OUTSIDE + run.y[0] + noise}


def answered(folder: Path, exponent: float, lost: float) -> dict[str, Any]:
    """Return the answer for one recording of a vessel that empties."""
    return answer(diagnosed(folder, LEAKING, [emptied(0, exponent, lost)]))


@pytest.mark.parametrize(('exponent', 'lost'), [(1.2, 0.5), (1.3, 0.9)])
def test_law_of_a_porous_leak_is_found_in_one_recording(
    tmp_path: Path, exponent: float, lost: float
) -> None:
    data = answered(tmp_path, exponent, lost)
    assert [effect['name'] for effect in data['effects']] == ['porous_leak']
    found = data['effects'][0]['parameters']['exponent']
    assert found['value'] == pytest.approx(exponent, abs=0.1)
    assert found['interval'][0] < exponent < found['interval'][1]
    (fitted,), (verified,) = data['recordings'].values()
    assert (cut := re.fullmatch(r'run_0, 0 to ([\d.]+) s', fitted))
    assert verified == f'run_0, {cut[1]} to 139.9 s'
    assert data['sentence'].endswith('There is one recording: its last part was held out.')


def fed(seconds: float) -> np.ndarray:
    """Return the pressure in a vessel that is fed at first and is empty long before the end."""
    n = round(10.0 * seconds)
    held = FILL + np.random.default_rng(1).normal(0.0, 120.0, n)
    return np.concatenate([held, emptied(0, 1.15, 0.9995)['pressure_1']])


def law(data: dict[str, Any]) -> tuple[list[str], float]:
    """Return the names of the effects in an answer and the power of the first one."""
    names = [effect['name'] for effect in data['effects']]
    return names, data['effects'][0]['parameters']['exponent']['value']


def test_vessel_that_is_fed_at_first_is_diagnosed_from_when_it_is_shut(tmp_path: Path) -> None:
    data = answer(diagnosed(tmp_path, LEAKING, [{'pressure_1': fed(6.0)}]))
    assert law(data) == (['porous_leak'], pytest.approx(1.15, abs=0.1))
    assert any('until it was shut, are not used' in each['note'] for each in data['notes'])


@pytest.mark.parametrize('named', [True, False])
def test_recording_of_an_empty_vessel_validates_nothing(tmp_path: Path, named: bool) -> None:
    halves = [{'pressure_1': half} for half in np.split(fed(6.0), 2)]
    data = answer(diagnosed(tmp_path, LEAKING, halves, fitted=1 if named else 2))
    assert law(data) == (['porous_leak'], pytest.approx(1.15, abs=0.1))
    assert any('not used, as the vessel is empty: run_1' in each['note'] for each in data['notes'])
    assert 'There is one recording' in data['sentence']


@pytest.mark.parametrize('seconds', [3.0, 6.0, 20.0, 50.0])
def test_shutting_is_found_within_a_block(seconds: float) -> None:
    pressure = fed(seconds)
    start = 0.1 * shut_at(pressure, 120.0)
    assert seconds <= start < seconds + 0.1 * 3.0 * max(pressure.size // 300, 3)


def test_vessel_that_is_shut_from_the_first_is_not_cut() -> None:
    for seed, lost in itertools.product(range(5), (0.006, 0.15, 0.9, 0.999)):
        assert shut_at(emptied(seed, 1.2, lost)['pressure_1'], 120.0) == 0


def test_evacuated_vessel_is_not_empty_until_it_is_filled() -> None:
    """Its gauge pressure is negative."""
    time = np.arange(100) * 0.1
    early, late, filled = (
        Recording('run', 0, 100_000_000, {'pressure_1': OUTSIDE - gauge * np.exp(-time / 50.0)})
        for gauge in (9e4, 8e4, 1e3)
    )
    assert not is_empty(late, [early, late], OUTSIDE)
    assert is_empty(filled, [early, filled], OUTSIDE)
    assert shut_at(early['pressure_1'], 120.0) == 0


def test_leak_of_a_little_is_named_by_the_simplest_law(tmp_path: Path) -> None:
    data = answered(tmp_path, 1.1, 0.15)
    assert [effect['name'] for effect in data['effects']] == ['chamber_leak']


def test_vessel_that_loses_what_a_drift_of_temperature_may_is_too_tight(tmp_path: Path) -> None:
    data = answered(tmp_path, 1.2, 0.006)
    assert data['verdict'] == 'consistent'
    assert data['sentence'].startswith('Too tight to tell: no pressure changes by more than 0.')
    assert data['where'] == []


def test_seal_is_diagnosed_from_one_recording(tmp_path: Path) -> None:
    data = answer(diagnosed(tmp_path, BENCH, [bench_run(0, 3e5, 0.0, coulomb=7.5)], 0.01))
    assert data['verdict'] == 'parameter'
    value = data['parameters'][0]['value']
    assert value == pytest.approx(7.5, rel=0.03)


def test_sealed_chambers_are_diagnosed_from_one_recording(tmp_path: Path) -> None:
    """The gas is not at the temperature of the walls where the recording is cut."""
    run = chamber_run(0, (4.5e5, 1.1e6), CONDUCTANCES)
    data = answer(diagnosed(tmp_path, CHAMBERS, [run]))
    assert [effect['name'] for effect in data['effects']] == ['wall_heat_transfer']
    values = data['effects'][0]['parameters']
    for i, true in enumerate(CONDUCTANCES, start=1):
        assert values[f'conductance_{i}']['value'] == pytest.approx(true, rel=0.05)
    assert data['gap']['cut'] > 0.9


def test_one_recording_of_a_free_piston_is_refused(tmp_path: Path) -> None:
    """Its seal remembers the film and the rest before, which the cut would lose."""
    bag = simulate(configured('cylinder_2'), 0.29, 2.0, tmp_path / 'bag')
    with pytest.raises(RigError, match='only one recording of a free piston given; add another'):
        diagnose([bag], 'cylinder_2')
