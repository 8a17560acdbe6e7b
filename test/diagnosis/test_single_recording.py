"""One recording alone: its last part is held out; a vessel that hardly leaks is called tight."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.simulate import simulate

from .parts import (
    BENCH,
    CHAMBERS,
    CONDUCTANCES,
    LEAKING,
    bench_run,
    chamber_run,
    mapping,
    system_file,
    table,
)
from .runs import configured

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
    path = table(folder / 'run.csv', 0.1, emptied(0, exponent, lost))
    known = mapping(folder / 'map.yaml', 'pressure_1')
    return answer(diagnose([path], system_file(folder, LEAKING), mapping=known))


@pytest.mark.parametrize(('exponent', 'lost'), [(1.2, 0.5), (1.3, 0.9)])
def test_law_of_a_porous_leak_is_found_in_one_recording(
    tmp_path: Path, exponent: float, lost: float
) -> None:
    data = answered(tmp_path, exponent, lost)
    assert [effect['name'] for effect in data['effects']] == ['porous_leak']
    found = data['effects'][0]['parameters']['exponent']
    assert found['value'] == pytest.approx(exponent, abs=0.1)
    assert found['interval'][0] < exponent < found['interval'][1]
    assert data['recordings'] == {'fit': ['run, 0 to 93.4 s'], 'verify': ['run, 93.4 to 139.9 s']}
    assert data['sentence'].endswith('There is one recording: its last part was held out.')


def test_leak_of_a_little_is_named_by_the_simplest_law(tmp_path: Path) -> None:
    data = answered(tmp_path, 1.1, 0.15)
    assert [effect['name'] for effect in data['effects']] == ['chamber_leak']


def test_vessel_that_loses_what_a_drift_of_temperature_may_is_too_tight(tmp_path: Path) -> None:
    data = answered(tmp_path, 1.2, 0.006)
    assert data['verdict'] == 'consistent'
    assert data['sentence'].startswith('Too tight to tell: no pressure changes by more than 0.')
    assert data['where'] == []


def test_seal_is_diagnosed_from_one_recording(tmp_path: Path) -> None:
    path = table(tmp_path / 'run.csv', 0.01, bench_run(0, 3e5, 0.0, coulomb=7.5))
    known = mapping(tmp_path / 'map.yaml', 'position', 'pressure_2', 'force')
    data = answer(diagnose([path], system_file(tmp_path, BENCH), mapping=known))
    assert data['verdict'] == 'parameter'
    value = data['parameters'][0]['value']
    assert value == pytest.approx(7.5, rel=0.03)


def test_sealed_chambers_are_diagnosed_from_one_recording(tmp_path: Path) -> None:
    """The gas is not at the temperature of the walls where the recording is cut."""
    path = table(tmp_path / 'run.csv', 0.1, chamber_run(0, (4.5e5, 1.1e6), CONDUCTANCES))
    known = mapping(tmp_path / 'map.yaml', 'position', 'pressure_1', 'pressure_2')
    data = answer(diagnose([path], system_file(tmp_path, CHAMBERS), mapping=known))
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
