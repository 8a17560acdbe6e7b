"""
Replicates of runs: what the sensors would have read if a hypothesis were true.

They show what the noise of the sensors alone does not: how much wider the residuals of a true
model spread where the piston creeps, or breaks away at another time than its velocity says.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import FORCE_OVERLAP, Comparison, Residuals
from pneu_rig_ros.diagnosis.residuals.noise import NoiseModel, noise_model
from pneu_rig_ros.diagnosis.residuals.threads import map_runs
from pneu_rig_ros.model import along
from pneu_rig_ros.model.run import Impose

IMPOSED_TOLERANCE = 5e-5
"""Of the gas along a measured motion, far below the noise: of full scale [-]."""
SPEED_EDGES = (0.01, 0.03)
"""Edges of the classes of speed in which errors of the force are alike [m/s]."""
SPEED_CLASSES = len(SPEED_EDGES) + 1
FEWEST_RESIDUALS = 12
"""With fewer residuals of replicates their spread is ignored."""
LARGEST_RESIDUAL = 3.0
"""Standard deviations to which a residual of a replicate is clipped."""


class Inflation(NamedTuple):
    """
    How the residuals of a true model differ from their computed noise.

    :param gas_1, gas_2, breakaway, stop: factors on the standard deviation [-]
    :param force: the same for each class of speed
    :param bias: class of speed and direction -> mean of the force residuals [N]
    :param shift: the same, shrunk by as much as it is uncertain [N]
    """

    gas_1: float
    gas_2: float
    force: tuple[float, ...]
    breakaway: float
    bias: Mapping[int, float]
    shift: Mapping[int, float]
    stop: float = 1.0

    def factors(self, comparison: Comparison, noise: NoiseModel) -> Residuals:
        """Return the factor of each kept window of a run."""
        by_speed = np.array(self.force)[speed_classes(comparison)[noise.force.kept]]
        gas_1, gas_2, breakaway, stop = (
            np.full(int(whiten.kept.sum()), factor)
            for whiten, factor in (
                (noise.gas_1, self.gas_1),
                (noise.gas_2, self.gas_2),
                (noise.breakaway, self.breakaway),
                (noise.stop, self.stop),
            )
        )
        return Residuals(gas_1, gas_2, by_speed, breakaway, stop)

    def force_bias(self, comparison: Comparison) -> Floats:
        """Return the mean force residual of a true model in each window of a run [N], (m,)."""
        classes = speed_and_direction(comparison)
        return np.array([self.shift.get(int(number), 0.0) for number in classes], dtype=np.float64)


def simulate_replicate(hypothesis: Hypothesis, run: Run, rng: Generator) -> Run:
    """Return a run with the same commands and conditions, simulated freely."""
    plant = hypothesis.plant_of(run)
    start = plant.state
    states = plant.run(hypothesis.voltages(run), run.interval)
    x = np.append(start.position_reading, states.position_reading)
    p1 = np.append(start.pressure_1_reading, states.pressure_1_reading)
    p2 = np.append(start.pressure_2_reading, states.pressure_2_reading)
    zero, noise = run.atmospheric_pressure, run.noise
    gains, offsets = hypothesis.gains, hypothesis.offsets
    position = offsets[0] + gains[0] * x
    position = position + noise.position * rng.standard_normal(x.size)
    true = np.column_stack([p1, p2]) - zero
    pressures = zero + np.array(offsets[1:]) + np.array(gains[1:]) * true
    pressures = pressures + np.array(noise.pressures) * rng.standard_normal(pressures.shape)
    return replace(
        run,
        position=np.clip(position, 0.0, run.span.position),
        pressures=np.clip(pressures, run.span.low, run.span.high),
        original=None,
    )


def chamber_pressures(hypothesis: Hypothesis, comparison: Comparison) -> Floats:
    """Return p1, p2 as read [Pa] along the measured motion, shape (n - 1, 2)."""
    run = comparison.corrected(hypothesis)[0]
    plant = hypothesis.plant_of(run)
    plant.tolerance, plant.longest_step = IMPOSED_TOLERANCE, run.interval
    position = np.clip(run.smooth[:, 0], 0.0, run.stroke)
    measured = np.zeros((run.size - 1, 4))
    measured[:, 0], measured[:, 1] = position[:-1], np.diff(position) / run.interval
    actions = np.full(run.size - 1, Impose.MOTION, dtype=np.int64)
    states = plant.run_imposed(
        hypothesis.voltages(run), run.interval, actions, measured, np.zeros(run.size - 1)
    )
    return np.column_stack([states.pressure_1_reading, states.pressure_2_reading])


def bench_force(hypothesis: Hypothesis, comparison: Comparison) -> Floats:
    """Return the modelled force of the bench along the measured motion [N], shape (n - 1,)."""
    rates, run = comparison.rates(hypothesis), comparison.run
    acceleration = np.gradient(run.velocity, run.interval)
    force: Floats = rates[:, along.INERTIA] * acceleration - rates[:, along.FORCE]
    return force


def replicate(hypothesis: Hypothesis, comparison: Comparison, rng: Generator) -> Comparison:
    """
    Return what the sensors would have read if a hypothesis were true.

    A free piston is simulated, else what is open along the measured motion.
    """
    run = comparison.run
    if comparison.free:
        return Comparison(simulate_replicate(hypothesis, run, rng))
    position, pressures, force = run.smooth[:, 0], run.pressures.copy(), run.force
    chambers = run.chambers
    if chambers:
        simulated = np.vstack([run.smooth[:1, 1:], chamber_pressures(hypothesis, comparison)])
        simulated += np.array(run.noise.pressures) * rng.standard_normal(simulated.shape)
        clipped = np.clip(simulated, run.span.low, run.span.high)
        pressures[:, chambers] = clipped[:, chambers]
    if 'force' in run.balances and force is not None:
        middles = bench_force(hypothesis, comparison)
        samples = np.concatenate([middles[:1], 0.5 * (middles[1:] + middles[:-1]), middles[-1:]])
        force = samples + run.noise.force * rng.standard_normal(samples.size)
    position = position + run.noise.position * rng.standard_normal(run.size)
    readings = replace(
        run, position=position, pressures=pressures, force=force, original=None, delay=0.0
    )
    return Comparison(readings.with_delay(0.0) if run.clock_offset > 0.0 else readings)


def estimate_inflation(
    hypothesis: Hypothesis, comparisons: tuple[Comparison, ...], rng: Generator
) -> Inflation:
    """Return the inflation of the noise over one replicate of each run."""
    seeds = rng.spawn(len(comparisons))
    triples = map_runs(partial(_replicate, hypothesis), comparisons, seeds)
    kept = [noise.force.kept for _, noise, _ in triples]
    classes = [speed_and_direction(triple[0]) for triple in triples]
    used = np.concatenate([each[flags] for each, flags in zip(classes, kept, strict=True)])
    force = np.concatenate([triple[2].force[k] for triple, k in zip(triples, kept, strict=True)])
    by_class = {int(number): force[used == number] for number in np.unique(used)}
    bias = {number: float(residuals.mean()) for number, residuals in by_class.items()}
    shift = {number: shrunk_mean(residuals) for number, residuals in by_class.items()}
    rows = [with_bias(noise, run, bias).whiten(residuals) for run, noise, residuals in triples]
    gas_1, gas_2, force, breakaway, _ = (np.concatenate(each) for each in zip(*rows, strict=True))
    speeds = used % SPEED_CLASSES
    by_speed = tuple(inflation(force[speeds == number]) for number in range(SPEED_CLASSES))
    return Inflation(
        inflation(gas_1), inflation(gas_2), by_speed, inflation(breakaway), bias, shift
    )


def _replicate(
    hypothesis: Hypothesis, comparison: Comparison, rng: Generator
) -> tuple[Comparison, NoiseModel, Residuals]:
    """Return a replicate of a run with its noise and its residuals."""
    simulated = replicate(hypothesis, comparison, rng)
    noise = noise_model(hypothesis, simulated, rng)
    return simulated, noise, simulated.residuals(hypothesis)


def inflation(whitened: Floats) -> float:
    """Return the factor by which residuals spread beyond their noise, at least 1 [-]."""
    if whitened.size < FEWEST_RESIDUALS:
        return 1.0
    clipped = np.clip(whitened, -LARGEST_RESIDUAL, LARGEST_RESIDUAL)
    return max(float(np.sqrt(np.mean(clipped**2))), 1.0)


def shrunk_mean(residuals: Floats) -> float:
    """
    Return the mean of residuals of windows that overlap, shrunk by its uncertainty.

    The estimator of W. James, C. Stein, 4th Berkeley Symp. Math. Stat. Prob. 1 (1961) 361, its
    positive part.
    """
    mean = float(residuals.mean())
    variance = float(residuals.var()) * FORCE_OVERLAP / residuals.size
    return mean * max(1.0 - variance / mean**2, 0.0) if mean != 0.0 else 0.0


def speed_classes(comparison: Comparison) -> NDArray[np.intp]:
    """Return the class of speed of each window of the motion, shape (m,)."""
    return np.digitize(np.abs(comparison.window_velocity), SPEED_EDGES)


def speed_and_direction(comparison: Comparison) -> NDArray[np.intp]:
    """Return the class of speed and direction of each window of the motion, shape (m,)."""
    classes = speed_classes(comparison)
    return np.where(comparison.window_velocity < 0.0, classes + SPEED_CLASSES, classes)


def with_bias(noise: NoiseModel, comparison: Comparison, bias: Mapping[int, float]) -> NoiseModel:
    """
    Return the noise with a force error that all windows of a class have in common.

    A bias is known to about its size: it is that of another trajectory.
    """
    classes = speed_and_direction(comparison)
    columns = [
        np.where(classes == number, bias.get(number, 0.0), 0.0)
        for number in range(2 * SPEED_CLASSES)
    ]
    return noise._replace(force=noise.force.with_shared(np.column_stack(columns)))
