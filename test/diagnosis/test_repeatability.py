"""What recordings of one system differ by is no missing effect; more than that is one."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.cycles import simulate_worn
from pneu_rig_ros.diagnosis.residuals.replicates import simulate_replicate
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import Diagnosis, diagnose
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.effects import causes
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .parts import BENCH, bench_run
from .runs import configured, diagnosed, measured, rubbing, system_of

COULOMB = (6.4, 5.6, 6.3)
"""Of a seal that is mounted again for each recording [N]."""
KNOWN = 'repeatability: {force: 0.5 N}\n'


def seals(folder: Path, text: str, slope: float = 0.0, without: tuple[str, ...] = ()) -> Diagnosis:
    """Return the diagnosis of three recordings at 1, 3 and 5 bar, the last one held out."""
    levels = enumerate(zip((1e5, 3e5, 5e5), COULOMB, strict=True))
    runs = [bench_run(i, gauge, slope, coulomb) for i, (gauge, coulomb) in levels]
    return diagnosed(folder, BENCH + text, runs, 0.01, fitted=2, without=without)


def test_recordings_that_differ_are_consistent_within_a_known_repeatability(
    tmp_path: Path,
) -> None:
    diagnosis = seals(tmp_path, KNOWN)
    assert diagnosis.verdict == 'consistent'
    assert 'within the repeatability (0.5 N)' in answer(diagnosis)['sentence']


@pytest.mark.long
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
    worn = replace(run, level_sd=0.1 * rig.model.friction.coulomb_force)

    def positions(simulate: Callable[..., Run], of: Run, seed: int = 1) -> np.ndarray:
        return simulate(system.hypothesis, of, np.random.default_rng(seed)).position

    same = positions(simulate_replicate, run)
    np.testing.assert_array_equal(positions(simulate_worn, run), same)
    draws = [np.abs(positions(simulate_worn, worn, seed) - same).max() for seed in range(8)]
    assert np.median(draws) > 1e-3


def test_rig_keeps_its_repeatability_and_the_plant_runs_as_before(tmp_path: Path) -> None:
    rig, kept = configured('cylinder_1'), {'force': 0.3, 'friction_level': 0.02}
    system = replace(system_of(tmp_path, rig), repeatability=kept)
    path = tmp_path / 'improved.yaml'
    path.write_text(system.to_yaml())
    assert load_system(path).repeatability == kept
    assert replace(load_configuration(path), repeatability={}) == rig
    run = measured(load_system(path), 'run', rig)
    assert run.level_sd == pytest.approx(0.02 * rig.model.friction.coulomb_force)


def verdicts_with(
    folder: Path, bags: list[Path], quantity: str, spreads: tuple[float, ...]
) -> dict[float, str]:
    """Return the verdict for each spread of a quantity that a model keeps, without effects."""
    verdicts = {}
    for spread in spreads:
        kept = {quantity: spread}
        system = replace(system_of(folder, configured('cylinder_1')), repeatability=kept)
        path = folder / f'model_{spread}.yaml'
        path.write_text(system.to_yaml())
        verdicts[spread] = diagnose(bags, path, without=causes()).verdict
    return verdicts


@pytest.mark.long
def test_recordings_of_a_rig_are_consistent_within_what_it_keeps(tmp_path: Path) -> None:
    """Friction 6 % higher: a cause, but not where levels differ by 5 %."""
    rig = configured('cylinder_1')
    worn = rubbing(rig, 1.06)
    bags = [
        simulate(replace(worn, seed=seed), 0.34, 3.0, tmp_path / f'run_{seed}') for seed in (1, 2)
    ]
    verdicts = verdicts_with(tmp_path, bags, 'friction_level', (0.0, 0.05))
    assert verdicts[0.0] in ('effect', 'parameter')
    assert verdicts[0.05] == 'consistent'


@pytest.mark.long
def test_supply_that_varies_between_recordings_is_no_condition_of_the_next(tmp_path: Path) -> None:
    """A supply 3 % high: not as stated, but not where it differs by 2 %."""
    rig = configured('cylinder_1')
    stated = rig.model.operation.supply_pressure
    bags = []
    for seed in (1, 2):
        off = configured('cylinder_1', seed=seed, supply_pressure=1.03 * stated)
        bags.append(simulate(off, 0.34, 6.0, tmp_path / f'run_{seed}'))
        (bags[-1] / 'conditions.yaml').write_text(f'supply_pressure: {stated} Pa\n')
    verdicts = verdicts_with(tmp_path, bags, 'supply_pressure', (0.0, 0.02))
    assert verdicts == {0.0: 'conditions', 0.02: 'consistent'}


@pytest.mark.parametrize('text', ['{friction: 0.1 -}', '{force: 0.1 bar}', '{force: -1 N}', '[1]'])
def test_wrong_repeatability_of_a_rig_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / 'rig.yaml'
    path.write_text(configured('cylinder_1').to_yaml() + f'repeatability: {text}\n')
    with pytest.raises(RigError, match=r'rig\.yaml: repeatability'):
        load_configuration(path)
