"""What recordings of one system differ by is no missing effect; more than that is one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.replicates import simulate_replicate
from pneu_rig_ros.diagnosis.residuals.shooting import simulate_worn
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import Diagnosis, diagnose

from .parts import BENCH, bench_run, mapping, system_file, table
from .runs import configured, measured, system_of

SIGNALS = ('position', 'pressure_2', 'force')
COULOMB = (6.4, 5.6, 6.3)
"""Of a seal that is mounted again for each recording [N]."""
KNOWN = 'repeatability: {force: 0.5 N}\n'


def seals(folder: Path, text: str, slope: float = 0.0, without: tuple[str, ...] = ()) -> Diagnosis:
    """Return the diagnosis of three recordings at 1, 3 and 5 bar, the last one held out."""
    paths = []
    for i, (gauge, coulomb) in enumerate(zip((1e5, 3e5, 5e5), COULOMB, strict=True)):
        signals = bench_run(i, gauge, slope, coulomb)
        paths.append(table(folder / f'run_{i}.csv', 0.01, signals))
    known = mapping(folder / 'map.yaml', *SIGNALS)
    system = system_file(folder, BENCH + text)
    return diagnose(paths[:2], system, paths[2:], without=without, mapping=known)


def test_recordings_that_differ_are_consistent_within_a_known_repeatability(
    tmp_path: Path,
) -> None:
    diagnosis = seals(tmp_path, KNOWN)
    assert diagnosis.verdict == 'consistent'
    assert 'within the repeatability (0.5 N)' in answer(diagnosis)['sentence']


def test_more_than_the_repeatability_is_found(tmp_path: Path) -> None:
    diagnosis = seals(tmp_path, KNOWN, slope=2e-5)  # 8 N between 1 and 5 bar
    assert [part.name for part in diagnosis.explanation.parts if part.is_effect] == [
        'pressure_dependent_friction'
    ]


def test_improved_model_keeps_what_it_leaves(tmp_path: Path) -> None:
    # a power of the pressure would go through all three levels
    diagnosis = seals(tmp_path, '', slope=2e-5, without=('pressure_power_friction',))
    system = diagnosis.improved_system
    # a line through the levels at 1 and 3 bar, 8.4 and 11.6 N, is 1.5 N off at 5 bar
    assert system.repeatability['force'] == pytest.approx(1.5 / 3**0.5, rel=0.1)
    path = tmp_path / 'improved.yaml'
    path.write_text(system.to_yaml())
    assert load_system(path).repeatability == pytest.approx(system.repeatability)


def test_replicates_have_the_friction_of_another_recording(tmp_path: Path) -> None:
    """By as much as it may differ; by nothing where it may not."""
    rig = configured('cylinder_1')
    system = system_of(tmp_path, rig)
    run = measured(system, 'run', rig)
    worn = replace(run, level_error=0.1 * rig.model.friction.coulomb_force)

    def positions(simulate: Callable[..., Run], of: Run) -> np.ndarray:
        return simulate(system.hypothesis, of, np.random.default_rng(1)).position

    same = positions(simulate_replicate, run)
    np.testing.assert_array_equal(positions(simulate_worn, run), same)
    assert np.abs(positions(simulate_worn, worn) - same).max() > 1e-3
