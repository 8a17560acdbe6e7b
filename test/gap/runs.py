"""Measured runs for the tests: the package's own rig, short, with or without an effect."""

from dataclasses import replace
from typing import Any

import numpy as np

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.records.record import NEVER, Record
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

Timeline = tuple[tuple[float, float], ...]
"""u [V] and how long it is held [s], one after the other."""
# creep out, shut, out fast, shut, back
TIMELINE: Timeline = ((0.31, 3.0), (0.0, 1.0), (0.5, 1.5), (0.0, 0.7), (-0.45, 2.0))

SET_UP = {'supply_pressure': 5e5, 'initial_position': 0.0, 'rest_time': 1060.0}
"""Of every run that does not say otherwise: one in which the piston soon moves."""


def configured(cylinder: str, **overrides: object) -> RigConfiguration:
    """Return a shipped cylinder in the set-up of the tests."""
    return load_configuration(cylinder, **{**SET_UP, **overrides})


def measured(
    cylinder: str = 'cylinder_1', effects: dict[str, Any] | None = None, seed: int = 1,
    timeline: Timeline = TIMELINE, **overrides: float,
) -> Experiment:  # fmt: skip
    """Return what the rig's sensors, without errors of gain, read of a run."""
    configuration = configured(cylinder, seed=seed, **overrides)
    sensors = configuration.sensors._replace(position_class=0.0, pressure_class=0.0)
    configuration = replace(configuration, effects=effects or {}, sensors=sensors)
    rig = Rig(configuration)
    u = np.concatenate([np.full(round(time / rig.interval), level) for level, time in timeline])
    voltages = np.array([valve_voltages(float(level)) for level in u])
    samples = [rig.reset(), *(rig.step(*pair) for pair in voltages[:-1])]
    x, v, p1, p2 = np.array(
        [(s.position, s.velocity, s.pressure_1, s.pressure_2) for s in samples]
    ).T
    nothing = np.full(x.size, np.nan)
    record = Record(
        0, configuration.interval_ns, x, v, p1, p2, voltages[:, 0].copy(), voltages[:, 1].copy(),
        nothing, np.full(x.size, NEVER), configuration=configuration,
    )  # fmt: skip
    return Experiment.of('run', record, configuration)
