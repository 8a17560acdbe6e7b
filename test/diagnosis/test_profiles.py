"""A mechanism whose formula the library does not have is named, with its free profile."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.effects import causes

from .parts import BENCH, bench_run, system_file
from .runs import checked, diagnosed

WAVE = 1.5
"""Amplitude of the friction along the stroke [N]."""
SOME = ('position_dependent_friction', 'pressure_dependent_friction', 'load_spring')
"""Causes in a small library."""


@pytest.mark.long
def test_friction_in_waves_along_the_stroke_is_named_with_its_profile(tmp_path: Path) -> None:
    runs = [bench_run(i, gauge, 0.0, wave=WAVE) for i, gauge in enumerate((1e5, 3e5, 5e5))]
    without = tuple(set(causes()) - set(SOME))
    diagnosis = diagnosed(tmp_path, BENCH, runs, 0.01, fitted=2, without=without)
    data = checked(diagnosis)
    assert data['verdict'] == 'effect'
    assert [effect['name'] for effect in data['effects']] == ['position_dependent_friction']
    shape = data['effects'][0]['shape']
    assert (shape['variable'], shape['unit'], shape['y_unit']) == ('position', 'm', 'N')
    inside = np.array(shape['x'])
    true = WAVE * np.sin(2.0 * np.pi * inside / 0.04)
    assert np.array(shape['y']) - np.mean(shape['y']) == pytest.approx(true, abs=0.35)
    assert data['gap']['cut'] > 0.8
    span = f'{min(shape["y"]):.2g} to {max(shape["y"]):.2g} N over position'
    assert f'in another form than the library has it: {span}' in data['sentence']
    assert data['effects'][0]['parameters'] == {}
    assert data['indistinguishable'] == []
    written = tmp_path / 'improved.yaml'
    written.write_text(diagnosis.improved_system.to_yaml())
    assert load_system(written).hypothesis.effects == diagnosis.improved.effects


def test_only_an_empirical_term_may_change_its_sign(tmp_path: Path) -> None:
    shape = '{over: position, at: [0 m, 0.1 m], times: [-1, 1]}'
    term = f'effects: {{empirical_friction: {{constant: 1 N, shape: {shape}}}}}\n'
    profile = load_system(system_file(tmp_path, BENCH + term))
    assert profile.hypothesis.effects['empirical_friction'].shape.times == (-1.0, 1.0)
    law = f'effects: {{position_dependent_friction: {{gradient: 0.1 -, shape: {shape}}}}}\n'
    with pytest.raises(RigError, match=r'times\[0\]: -1 is not within 0.01 to 100'):
        load_system(system_file(tmp_path, BENCH + law))


@pytest.mark.long
def test_profile_that_leaves_a_third_stays_where_no_description_leaves_less(
    tmp_path: Path,
) -> None:
    """Waves along the stroke, and a force that changes at random once a second."""
    runs = []
    for i, gauge in enumerate((1e5, 3e5, 5e5)):
        run = bench_run(i, gauge, 0.0, wave=WAVE)
        levels = np.random.Generator(np.random.PCG64(100 + i)).normal(0.0, 0.2, 12)
        run['force'] += np.repeat(levels, run['force'].size // 12)
        runs.append(run)
    without = tuple(set(causes()) - set(SOME))
    data = answer(diagnosed(tmp_path, BENCH, runs, 0.01, fitted=2, without=without))
    assert 0.21 < 1.0 - data['gap']['cut'] < 0.4
    assert data['verdict'] == 'effect'
    assert [effect['name'] for effect in data['effects']] == ['position_dependent_friction']
    assert data['effects'][0]['shape']['variable'] == 'position'
