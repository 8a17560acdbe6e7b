"""Runs for the tests: the package's own rig, short, with or without an effect."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run, prepare_runs
from pneu_rig_ros.diagnosis.inputs.read_inputs import read_recordings
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

Timeline = tuple[tuple[float, float], ...]
"""u [V] and how long it is held [s], one after the other."""
# creep out, shut, out fast, shut, back
TIMELINE: Timeline = ((0.34, 3.0), (0.0, 1.0), (0.5, 1.5), (0.0, 0.7), (-0.45, 2.0))
SET_UP = {'supply_pressure': 5e5, 'initial_position': 0.02, 'rest_time': 60.0}
"""Of every run that does not say otherwise: one in which the piston soon moves."""


def configured(
    cylinder: str, effects: dict[str, Any] | None = None, **overrides: Any
) -> RigConfiguration:
    """Return a shipped cylinder in the set-up of the tests, with sensors of exact gain."""
    given = load_configuration(cylinder, **{**SET_UP, **overrides})
    sensors = given.sensors._replace(position_class=0.0, pressure_class=0.0)
    return replace(given, effects=effects or {}, sensors=sensors)


def rubbing(rig: RigConfiguration, factor: float) -> RigConfiguration:
    """Return a rig whose friction is larger by a factor."""
    law = rig.model.friction
    law = law._replace(
        coulomb_force=factor * law.coulomb_force, breakaway_force=factor * law.breakaway_force
    )
    return replace(rig, model=rig.model._replace(friction=law))


def recorded(name: str, rig: RigConfiguration, timeline: Timeline = TIMELINE) -> Recording:
    """Return what the sensors of a rig read of a run."""
    emulated = Rig(rig)
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


def read_runs(paths: list[Path], system: System, known: Path) -> list[Run]:
    """Return text tables, prepared for a system."""
    return prepare_runs(read_recordings(paths, system, known), system, paths)
