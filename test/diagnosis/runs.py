"""Runs for the tests: the package's own rig, short, with or without an effect."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Explanation
from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run, prepare_runs
from pneu_rig_ros.diagnosis.inputs.read_inputs import read_recordings
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.search.scoring import Data
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.diagnosis.workflow import Diagnosis, diagnose
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .parts import mapping, system_file, table

SCHEMA = Path(__file__).resolve().parents[2] / 'docs' / 'diagnosis.schema.json'
Timeline = tuple[tuple[float, float], ...]
"""u [V] and how long it is held [s], one after the other."""
# creep out, shut, out fast, shut, back
TIMELINE: Timeline = ((0.34, 3.0), (0.0, 1.0), (0.5, 1.5), (0.0, 0.7), (-0.45, 2.0))
LEVELS = 'coulomb_force', 'breakaway_force'
SET_UP = {'supply_pressure': 5e5, 'initial_position': 0.02, 'rest_time': 60.0}
"""Of every run that does not say otherwise: one in which the piston soon moves."""


def configured(
    cylinder: str, effects: dict[str, Any] | None = None, **overrides: Any
) -> RigConfiguration:
    """Return a shipped cylinder in the set-up of the tests, with sensors of exact gain."""
    given = load_configuration(cylinder, **{**SET_UP, **overrides})
    sensors = given.sensors._replace(position_class=0.0, pressure_class=0.0)
    return replace(given, effects=effects or {}, sensors=sensors)


def changed(rig: RigConfiguration, section: str, **values: Any) -> RigConfiguration:
    """Return a rig with other values in a section of its model [SI]."""
    own = getattr(rig.model, section)._replace(**values)
    return replace(rig, model=rig.model._replace(**{section: own}))


def rubbing(rig: RigConfiguration, factor: float) -> RigConfiguration:
    """Return a rig whose friction is larger by a factor."""
    levels = {name: getattr(rig.model.friction, name) for name in LEVELS}
    return changed(rig, 'friction', **{name: factor * level for name, level in levels.items()})


def recorded(name: str, rig: RigConfiguration, timeline: Timeline = TIMELINE) -> Recording:
    """
    Return what the sensors of a rig read of a run.

    With an effect, the rig has all others too, as they are without any: as the plants of the
    diagnosis have, so that none is compiled for it alone.
    """
    emulated = Rig(
        replace(rig, effects={**library.nulls(), **rig.effects}) if rig.effects else rig
    )
    u = np.concatenate(
        [np.full(round(time / emulated.interval), level) for level, time in timeline]
    )
    voltages = np.array([valve_voltages(float(level)) for level in u])
    samples = [emulated.reset(), *(emulated.step(*pair) for pair in voltages[:-1])]
    read = np.array([(s.position, s.pressure_1, s.pressure_2) for s in samples]).T
    signals = dict(zip(('position', 'pressure_1', 'pressure_2'), read, strict=True))
    signals |= {'voltage_1': voltages[:, 0].copy(), 'voltage_2': voltages[:, 1].copy()}
    operation = rig.model.operation
    conditions = {
        name: getattr(operation, name) for name in ('supply_pressure', 'load_mass', 'rest_time')
    }
    return Recording(name, 0, rig.interval_ns, signals, configuration=rig, conditions=conditions)


def system_of(folder: Path, rig: RigConfiguration) -> System:
    """Return a rig without its effects as a system."""
    path = folder / 'model.yaml'
    path.write_text(replace(rig, effects={}).to_yaml())
    return load_system(path)


def measured(
    system: System, name: str, rig: RigConfiguration, timeline: Timeline = TIMELINE
) -> Run:
    """Return a run of a rig, prepared to be compared with a system."""
    return prepare_run(recorded(name, rig, timeline), system, Path(name))


def data_of(given: Hypothesis, *runs: Run, rng: Generator | None = None) -> Dataset:
    """Return runs as data, with their noise under a hypothesis."""
    return Dataset.of(given, [Comparison(run) for run in runs], rng or np.random.default_rng(0))


def search_of(
    given: Hypothesis, data: Data, rng: Generator, candidates: Sequence[Candidate] = ()
) -> Search:
    """Return the search of one of some causes in data."""
    return Search(base=Explanation(given), data=data, rng=rng, pool=candidates)


def search_in(
    given: Hypothesis, runs: Sequence[Run], candidates: Sequence[Candidate], held_out: int = 1
) -> Search:
    """Return the search of one of some causes in runs, the last ones of them held out."""
    rng = np.random.default_rng(0)
    fitted, verified = (
        data_of(given, *part, rng=rng) for part in (runs[:-held_out], runs[-held_out:])
    )
    return search_of(given, Data(fitted, verified), rng, candidates)


def checked(found: Diagnosis) -> dict[str, Any]:
    """Return the answer, checked against its schema as what a file of it holds."""
    data: dict[str, Any] = json.loads(json.dumps(answer(found), allow_nan=False))
    jsonschema.validate(data, json.loads(SCHEMA.read_text()))
    assert data['where'] or data['verdict'] in ('consistent', 'uncalibrated')
    return data


def tables_of(
    folder: Path, signals: Sequence[Mapping[str, Floats]], interval: float = 0.1
) -> tuple[list[Path], Path]:
    """Return text tables run_0.csv and so on, and their mapping."""
    paths = [table(folder / f'run_{i}.csv', interval, each) for i, each in enumerate(signals)]
    return paths, mapping(folder / 'map.yaml', *signals[0])


def diagnosed(
    folder: Path,
    text: str,
    signals: Sequence[Mapping[str, Floats]],
    interval: float = 0.1,
    fitted: int = 1,
    without: Sequence[str] = (),
) -> Diagnosis:
    """Return the diagnosis of a system by text tables, the first ones of which are fitted."""
    paths, known = tables_of(folder, signals, interval)
    system = system_file(folder, text)
    return diagnose(paths[:fitted], system, paths[fitted:], without=without, mapping=known)


def runs_of(
    system: System, folder: Path, signals: Sequence[Mapping[str, Floats]], interval: float = 0.1
) -> list[Run]:
    """Return text tables, prepared for a system."""
    paths, known = tables_of(folder, signals, interval)
    return prepare_runs(read_recordings(paths, system, known), system, paths)
