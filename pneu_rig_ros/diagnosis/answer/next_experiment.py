"""
The next experiment: the recording that separates rival explanations best.

T-optimal discrimination (A. C. Atkinson, V. V. Fedorov, Biometrika 62 (1975) 57): of the
experiments that the system's own recordings show to be possible, the one in which the nearest two
rivals differ most, by simulation of a rig, by the residuals of recordings otherwise.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, rms
from pneu_rig_ros.diagnosis.residuals.replicates import readings_of
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE
from pneu_rig_ros.rig.valve_drive import valve_voltages

STARTS = (0.05, 0.5)
"""Initial positions tried, as a share of the recorded range; for u < 0 from its far end [-]."""
COMMAND_PERCENTILES = (10.0, 60.0)
"""Percentiles of |u| in the recordings that are tried as slow and fast commands."""
DURATION = 8.0
"""Of the experiment [s]: u is held for two thirds, then the valves are shut."""
INTERVAL = 0.01
"""Between the simulated samples that are compared [s]."""


@dataclass(frozen=True)
class NextExperiment:
    """
    An experiment: u held, then the valves shut; or a repetition of a recording.

    :param u: [V], None where no valve moves the system
    :param supply_pressure: absolute [Pa]
    :param load_mass: [kg]
    :param initial_position: [m]
    :param like: recording to be repeated for longer, '' for another experiment
    :param separates: explanations
    :param by: RMS difference of the nearest two, in standard deviations of a reading [-]
    """

    u: float | None
    supply_pressure: float | None
    load_mass: float | None
    initial_position: float | None
    like: str
    separates: list[str]
    by: float


def next_experiment(
    rivals: Mapping[str, Hypothesis], dataset: Dataset, system: System
) -> NextExperiment | None:
    """Return the experiment that separates the nearest two rivals most, None without rivals."""
    if len(rivals) < 2:
        return None
    names, runs = list(rivals), [comparison.run for comparison in dataset.comparisons]
    if system.rig is None or not dataset.comparisons[0].free:
        rows = zip(*(dataset.residuals_by_run(rival) for rival in rivals.values()), strict=True)
        separations = [rms_separation([np.concatenate(each) for each in row]) for row in rows]
        by, recording = max(zip(separations, [run.name for run in runs], strict=True))
        return NextExperiment(None, None, None, None, recording, names, by)
    noise = runs[0].noise.readings
    supplies = ends(run.operation.supply_pressure for run in runs)
    loads = ends(run.operation.load_mass for run in runs)
    experiments = []
    x = np.concatenate([run.smooth[:, 0] for run in runs])
    # without the noise at an end stop
    nearest, farthest = np.clip([x.min(), x.max()], 0.0, runs[0].stroke).tolist()
    for u, supply, load, share in product(commands(runs), supplies, loads, STARTS):
        position = nearest + (share if u > 0 else 1.0 - share) * (farthest - nearest)
        set_up = u, supply, load, position
        tables = [simulated_readings(rival, runs[0], *set_up) for rival in rivals.values()]
        readings = [table / noise for table in tables if table is not None]
        if len(readings) == len(rivals):
            by = rms_separation(readings)
            experiments.append(NextExperiment(*set_up, '', names, by))
    return max(experiments, key=lambda experiment: experiment.by, default=None)


def rms_separation(predictions: Sequence[Floats]) -> float:
    """Return the RMS difference of the nearest two of some scaled predictions [-]."""
    return min(rms(a - b) for a, b in combinations(predictions, 2))


def commands(runs: Sequence[Run]) -> list[float]:
    """Return slow and fast commands of the recordings, in the directions that these have [V]."""
    u = np.concatenate([run.voltages[:, 0] for run in runs]) - CENTRE_VOLTAGE
    sizes = np.abs(u[np.abs(u) > 0.0])
    if not sizes.size:
        return []
    levels = np.percentile(sizes, COMMAND_PERCENTILES)
    tried = [float(sign * level) for level in levels for sign in (-1.0, 1.0)]
    return list(dict.fromkeys(round(each, 3) for each in tried if u.min() <= each <= u.max()))


def ends(values: Iterable[float]) -> list[float]:
    """Return the smallest and the largest of some values."""
    ordered = sorted(values)
    return sorted({ordered[0], ordered[-1]})


def simulated_readings(
    hypothesis: Hypothesis, run: Run, u: float, supply: float, load: float, position: float
) -> Floats | None:
    """Return x [m], p1, p2 [Pa] of an experiment, shape (n, 3); None if its simulation fails."""
    zero = run.atmospheric_pressure
    operation = run.operation._replace(
        supply_pressure=supply,
        load_mass=load,
        initial_position=position,
        initial_pressure_1=zero,
        initial_pressure_2=zero,
    )
    count = round(DURATION / INTERVAL)
    held = 3 * np.arange(count)[:, np.newaxis] < 2 * count
    voltages = np.where(held, valve_voltages(u), valve_voltages(0.0))
    try:
        states = hypothesis.plant(run, operation).run(voltages, INTERVAL)
    except RigError:
        return None
    return readings_of(states)
