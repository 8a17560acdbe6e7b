"""The next experiment: within what the recordings of the system show to be possible."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.next_experiment import next_experiment
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis

from .parts import BENCH, CHAMBERS, CONDUCTANCES, Floats, bench_run, chamber_run, system_file
from .runs import TIMELINE, Timeline, configured, data_of, measured, runs_of, system_of


def rivals(given: Hypothesis, section: str, name: str) -> dict[str, Hypothesis]:
    value = getattr(getattr(given.model, section), name)
    return {'given': given, name: given.with_parameter(section, name, 1.2 * value)}


OUT: Timeline = ((0.34, 3.0), (0.0, 1.0))
"""A timeline in which the piston never moves in."""


@pytest.mark.parametrize(
    ('cylinder', 'timeline'),
    [('cylinder_1', TIMELINE), ('cylinder_3', TIMELINE), ('cylinder_2', OUT)],
)
def test_a_rig_is_driven_as_in_its_recordings(
    tmp_path: Path, cylinder: str, timeline: Timeline
) -> None:
    system = system_of(tmp_path, configured(cylinder))
    supplies, loads = (4.2e5, 5.6e5), (0.3, 2.1)
    runs = [
        measured(
            system,
            f'run_{i}',
            configured(cylinder, supply_pressure=supply, load_mass=load),
            timeline,
        )
        for i, (supply, load) in enumerate(zip(supplies, loads, strict=True))
    ]
    both = rivals(system.hypothesis, 'friction', 'coulomb_force')
    found = next_experiment(both, data_of(system.hypothesis, *runs), system)
    assert found is not None
    assert found.separates == list(both)
    assert found.by > 1.0
    assert found.supply_pressure in supplies
    assert found.load_mass in loads
    u = np.array([level for level, _ in timeline])
    assert found.u is not None
    assert np.abs(u[u != 0.0]).min() - 1e-3 <= abs(found.u)
    assert u.min() - 1e-3 <= found.u <= u.max() + 1e-3
    x = np.concatenate([run.smooth[:, 0] for run in runs])
    assert found.initial_position is not None
    assert x.min() <= found.initial_position <= x.max()


def repeated(
    folder: Path, text: str, signals: list[dict[str, Floats]], interval: float, parameter: str
) -> str:
    """Return the recording like which the next one is, of a part of a rig with two rivals."""
    system = load_system(system_file(folder, text))
    runs = runs_of(system, folder, signals, interval)
    both = rivals(system.hypothesis, *parameter.split('.'))
    found = next_experiment(both, data_of(system.hypothesis, *runs), system)
    assert found is not None
    assert (found.u, found.supply_pressure, found.load_mass) == (None, None, None)
    return found.like


def test_chambers_repeat_the_recording_in_which_the_rivals_differ_most(tmp_path: Path) -> None:
    fills = (4.5e5, 1.1e6), (1.2e5, 1.3e5)
    signals = [chamber_run(i, fill, CONDUCTANCES) for i, fill in enumerate(fills)]
    # filled to twice the pressures and more
    assert repeated(tmp_path, CHAMBERS, signals, 0.1, 'cylinder.cap_dead_volume') == 'run_0'


def test_a_bench_repeats_the_recording_in_which_the_rivals_differ_most(tmp_path: Path) -> None:
    signals = [bench_run(i, 3e5, 0.0, way=way) for i, way in enumerate((0.002, 0.03))]
    # more of the short strokes are turns
    assert repeated(tmp_path, BENCH, signals, 0.01, 'friction.coulomb_force') == 'run_1'


def test_without_a_rival_there_is_nothing_to_separate(tmp_path: Path) -> None:
    system = system_of(tmp_path, configured('cylinder_1'))
    run = measured(system, 'run', configured('cylinder_1'))
    only = {'given': replace(system.hypothesis)}
    assert next_experiment(only, data_of(system.hypothesis, run), system) is None
