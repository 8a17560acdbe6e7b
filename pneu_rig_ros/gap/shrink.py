"""How far an explanation shrinks the gap on runs that it was not fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.comparison import Run, compare_runs, signal_noise
from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, predict

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SignalShrink:
    """RMSE of one signal before and after, and its noise, all in ``unit``."""

    unit: str
    noise: float
    before: float
    after: float


def run_of(experiment: Experiment, hypothesis: Hypothesis, readings: Floats) -> Run:
    """Return positions [m] and pressures [Pa], shape (n, 3), as a run of the rig."""
    model = hypothesis.model
    mass = model.cylinder.moving_mass + experiment.operation.load_mass
    balance = ForceBalance(
        model.cylinder.cap_area, model.cylinder.rod_area, mass, experiment.atmospheric_pressure
    )
    x, p1, p2 = readings.T
    return Run(experiment.name, experiment.interval, x, p1, p2, balance, model.cylinder.stroke)


def measured_run(experiment: Experiment, hypothesis: Hypothesis) -> Run:
    """Return the measured run from its second sample on, where predictions begin."""
    return run_of(experiment, hypothesis, experiment.measured[1:, [0, 2, 3]])


def predicted_run(experiment: Experiment, hypothesis: Hypothesis, mode: Mode) -> Run:
    """Return the run that a hypothesis predicts."""
    return run_of(experiment, hypothesis, predict(hypothesis, experiment, mode).readings)


def signal_shrink(
    before: Hypothesis, after: Hypothesis, evidence: Evidence, mode: Mode
) -> dict[str, SignalShrink]:
    """Return how far each signal is off, before and after, over all experiments."""
    rows: dict[str, list[tuple[float, float, float, str]]] = {}
    for experiment in evidence.experiments:
        measured = measured_run(experiment, before)
        x, p1, p2 = experiment.noise
        noise = signal_noise(x, max(p1, p2), experiment.interval, measured.balance)
        old = compare_runs(measured, predicted_run(experiment, before, mode), noise)
        new = compare_runs(measured, predicted_run(experiment, after, mode), noise)
        for name, one in old.items():
            row = one.rmse**2, new[name].rmse ** 2, noise[name] ** 2, one.unit
            rows.setdefault(name, []).append(row)
    return {name: _shrink(table) for name, table in rows.items()}


def _shrink(table: list[tuple[float, float, float, str]]) -> SignalShrink:
    before, after, noise = (float(np.sqrt(np.mean([r[i] for r in table]))) for i in range(3))
    return SignalShrink(table[0][3], noise, before, after)


def gap_above_floor(hypothesis: Hypothesis, evidence: Evidence, mode: Mode) -> Floats:
    """
    Return what of the gap in x, p1, p2 the noise floor does not explain, in floors, shape (3,).

    The evidence's floors are those of the hypothesis that was settled last.
    """
    every = np.concatenate(evidence.gaps(hypothesis, mode))
    excess: Floats = np.sqrt(np.maximum(np.mean(every**2, axis=0) - 1.0, 0.0))
    return excess


def above_floor(given: Hypothesis, improved: Hypothesis, held: Evidence) -> tuple[float, float]:
    """Return the gap before and after in noise floors, the mean over signals and predictions."""
    modes = (Mode.CHAMBERS, Mode.CYCLES)
    held.settle_floors(improved, modes)
    before, after = (
        np.concatenate([gap_above_floor(one, held, mode) for mode in modes])
        for one in (given, improved)
    )
    return float(before.mean()), float(after.mean())
