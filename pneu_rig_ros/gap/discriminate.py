"""The experiment that would tell rival explanations apart best, found by simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig.valve_drive import valve_voltages

Floats = NDArray[np.float64]

COMMANDS = (-0.45, -0.32, 0.32, 0.45)
"""u that is tried [V]."""
SUPPLIES = (4e5, 7e5)
"""Supply pressures that are tried, absolute [Pa]."""
LOADS = (0.2, 5.3)
"""Loads that are tried [kg]."""
STARTS = (0.05, 0.5)
"""Initial positions that are tried, as a share of the stroke [-]; the far end for u < 0."""
DURATION = 8.0
"""Of the experiment [s]: two thirds under way, one third with the valves shut."""
INTERVAL = 0.01
"""Between the simulated samples that are compared [s]."""


@dataclass(frozen=True)
class NextExperiment:
    """
    An experiment: u held for a while, then the valves shut.

    :param u: [V]
    :param supply_pressure: absolute [Pa]
    :param load_mass: [kg]
    :param initial_position: [m]
    :param separates: explanations
    :param by: RMS of what tells the nearest two apart, in noises of a reading [-]
    """

    u: float
    supply_pressure: float
    load_mass: float
    initial_position: float
    separates: tuple[str, ...]
    by: float

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {**asdict(self), 'separates': list(self.separates)}


def next_experiment(
    rivals: Mapping[str, Hypothesis], experiment: Experiment
) -> NextExperiment | None:
    """
    Return the experiment that separates the nearest two of some rivals most.

    :param rivals: name -> hypothesis
    :param experiment: gives the noise of the sensors and the surroundings
    """
    if len(rivals) < 2:
        return None
    noise = np.array(experiment.noise)
    tried = []
    for u, supply, load, share in product(COMMANDS, SUPPLIES, LOADS, STARTS):
        stroke = next(iter(rivals.values())).model.cylinder.stroke
        position = share * stroke if u > 0 else (1.0 - share) * stroke
        runs = [readings(one, experiment, u, supply, load, position) for one in rivals.values()]
        nearest = min(_apart(a, b, noise) for a, b in combinations(runs, 2))
        tried.append(NextExperiment(u, supply, load, position, tuple(rivals), nearest))
    return max(tried, key=lambda one: one.by)


def readings(
    hypothesis: Hypothesis, experiment: Experiment, u: float, supply: float, load: float,
    position: float,
) -> Floats:  # fmt: skip
    """Return x [m], p1, p2 [Pa] of an experiment under a hypothesis, shape (n, 3)."""
    gas = hypothesis.model.gas._replace(atmospheric_pressure=experiment.atmospheric_pressure)
    operation = experiment.operation._replace(
        supply_pressure=supply, load_mass=load, initial_position=position,
        initial_pressure_1=experiment.atmospheric_pressure,
        initial_pressure_2=experiment.atmospheric_pressure,
    )  # fmt: skip
    plant: Plant = hypothesis.plant_of(hypothesis.model._replace(operation=operation, gas=gas))
    count = round(DURATION / INTERVAL)
    voltages = np.array([valve_voltages(u if 3 * k < 2 * count else 0.0) for k in range(count)])
    run = plant.run(voltages, INTERVAL)
    return np.column_stack([run.position_reading, run.pressure_1_reading, run.pressure_2_reading])


def _apart(one: Floats, other: Floats, noise: Floats) -> float:
    return float(np.sqrt(np.mean(((one - other) / noise) ** 2)))
