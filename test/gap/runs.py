"""Measured runs for the tests: the package's own rig, short, with or without an effect."""

from dataclasses import replace
from typing import Any

import numpy as np

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.records.record import NEVER, Record
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

# u [V] and how long it is held [s]: creep out, shut, out fast, shut, back
TIMELINE = ((0.31, 3.0), (0.0, 1.0), (0.5, 1.5), (0.0, 0.7), (-0.45, 2.0))


def measured(
    cylinder: str = 'cylinder_1', effects: dict[str, Any] | None = None, seed: int = 1,
    timeline: tuple[tuple[float, float], ...] = TIMELINE, **overrides: float,
) -> Experiment:  # fmt: skip
    """Return what the rig's sensors, without errors of gain, read of a run."""
    configuration = load_configuration(cylinder, seed=seed, **overrides)
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
