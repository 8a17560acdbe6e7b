"""
The recording that would tell rival explanations apart best, found by simulation or regression.

T-optimal discrimination (A. C. Atkinson, V. V. Fedorov, Biometrika 62 (1975) 57): of the
experiments that the system's own recordings show to be possible, the one in which the nearest two
rivals differ most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.run import Run
from pneu_rig_ros.diagnosis.system import System
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE
from pneu_rig_ros.rig.valve_drive import valve_voltages

Floats = NDArray[np.float64]

STARTS = (0.05, 0.5)
"""Initial positions that are tried, as a share of the stroke [-]; the far end for u < 0."""
SLOW, FAST = 10.0, 60.0
"""Percentiles of |u| in the recordings that are tried as commands."""
DURATION = 8.0
"""Of the experiment [s]: two thirds under way, one third with the valves shut."""
INTERVAL = 0.01
"""Between the simulated samples that are compared [s]."""


@dataclass(frozen=True)
class NextExperiment:
    """
    An experiment: u held for a while, then the valves shut; or one like a recording there is.

    :param u: [V], None where it is not the valves that move the system
    :param supply_pressure: absolute [Pa]
    :param load_mass: [kg]
    :param initial_position: [m]
    :param like: recording to be repeated for longer, '' where the experiment is another one
    :param separates: explanations
    :param by: RMS of what tells the nearest two apart, in noises of a reading [-]
    """

    u: float | None
    supply_pressure: float | None
    load_mass: float | None
    initial_position: float | None
    like: str
    separates: tuple[str, ...]
    by: float

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {**asdict(self), 'separates': list(self.separates)}


def next_experiment(
    rivals: Mapping[str, Hypothesis], dataset: Dataset, system: System
) -> NextExperiment | None:
    """
    Return the experiment that separates the nearest two of some rivals most, None without rivals.

    :param rivals: name -> hypothesis
    :param dataset: recordings of the system, which say what is possible
    """
    if len(rivals) < 2:
        return None
    runs = [one.run for one in dataset.comparisons]
    if system.rig is None or not dataset.comparisons[0].free:
        return _like(rivals, dataset)
    noise = np.array([runs[0].noise.position, runs[0].noise.pressure_1, runs[0].noise.pressure_2])
    supplies = {run.operation.supply_pressure for run in runs}
    loads = {run.operation.load_mass for run in runs}
    tried = []
    for u, supply, load, share in product(commands(runs), ends(supplies), ends(loads), STARTS):
        position = (share if u > 0 else 1.0 - share) * runs[0].stroke
        every = [readings(one, runs[0], u, supply, load, position) for one in rivals.values()]
        if any(one is None for one in every):
            continue
        nearest = min(_apart(a, b, noise) for a, b in combinations(every, 2))
        tried.append(NextExperiment(u, supply, load, position, '', tuple(rivals), nearest))
    return max(tried, key=lambda one: one.by, default=None)


def commands(runs: list[Run]) -> list[float]:
    """Return slow and fast commands of the recordings, both ways [V]."""
    u = np.concatenate([run.voltages[:, 0] for run in runs]) - CENTRE_VOLTAGE
    sizes = np.abs(u[np.abs(u) > 0.0])
    if not sizes.size:
        return []
    levels = dict.fromkeys(float(np.round(np.percentile(sizes, p), 3)) for p in (SLOW, FAST))
    return [sign * level for level in levels for sign in (-1.0, 1.0)]


def ends(values: set[float]) -> list[float]:
    """Return the smallest and the largest of some values."""
    return sorted({min(values), max(values)})


def _like(rivals: Mapping[str, Hypothesis], dataset: Dataset) -> NextExperiment:
    """Return the recording in which the nearest two rivals differ most."""
    whitened = [dataset.of_each(one) for one in rivals.values()]
    apart = []
    for index, comparison in enumerate(dataset.comparisons):
        rows = [np.concatenate(every[index]) for every in whitened]
        nearest = min(float(np.sqrt(np.mean((a - b) ** 2))) for a, b in combinations(rows, 2))
        apart.append((nearest, comparison.run.name))
    by, name = max(apart)
    return NextExperiment(None, None, None, None, name, tuple(rivals), by)


def readings(
    hypothesis: Hypothesis, run: Run, u: float, supply: float, load: float, position: float
) -> Floats | None:
    """Return x [m], p1, p2 [Pa] of an experiment, shape (n, 3); None where it breaks down."""
    zero = run.atmospheric_pressure
    operation = run.operation._replace(
        supply_pressure=supply, load_mass=load, initial_position=position,
        initial_pressure_1=zero, initial_pressure_2=zero,
    )  # fmt: skip
    plant = hypothesis.plant(run, operation)
    count = round(DURATION / INTERVAL)
    voltages = np.array([valve_voltages(u if 3 * k < 2 * count else 0.0) for k in range(count)])
    try:
        states = plant.run(voltages, INTERVAL)
    except RigError:
        return None
    return np.column_stack(
        [states.position_reading, states.pressure_1_reading, states.pressure_2_reading]
    )


def _apart(one: Floats | None, other: Floats | None, noise: Floats) -> float:
    assert one is not None
    assert other is not None
    return float(np.sqrt(np.mean(((one - other) / noise) ** 2)))
