"""
Replicates of runs: what the sensors would have read if a hypothesis were true.

They show what the noise of the sensors alone does not: how much wider the residuals of a true
model spread where the piston creeps, or breaks away at another time than its velocity says.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats, Indices
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import FORCE_WINDOWS, Comparison, Residuals
from pneu_rig_ros.diagnosis.residuals.noise import NoiseModel, noise_model
from pneu_rig_ros.diagnosis.residuals.weak_form import at_samples
from pneu_rig_ros.executor import map_threads
from pneu_rig_ros.model import along
from pneu_rig_ros.model.plant import PlantState, Trajectory
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

    :param factors: on the standard deviation [-], shape (1,) each, of the force (SPEED_CLASSES,)
    :param bias: mean of the force residuals for each class of speed and direction [N], shape
        (2 SPEED_CLASSES,)
    :param shift: the same, shrunk by as much as it is uncertain [N]
    """

    factors: Residuals
    bias: Floats
    shift: Floats

    def of_windows(self, comparison: Comparison, noise: NoiseModel) -> Residuals:
        """Return the factor of each kept window of a run."""
        by_speed = self.factors.force[speed_classes(comparison)[noise.force.kept]]
        pairs = zip(noise, self.factors._replace(force=by_speed), strict=True)
        return Residuals(*(np.full(whiten.deviation.size, factor) for whiten, factor in pairs))

    def with_bias(self, noise: NoiseModel, comparison: Comparison) -> NoiseModel:
        """
        Return the noise with a force error that all windows of a class have in common.

        A bias is known to about its size: it is that of another trajectory.
        """
        of_class = speed_and_direction(comparison)[:, np.newaxis] == np.arange(self.bias.size)
        columns = np.where(of_class, self.bias, 0.0)
        return noise._replace(force=noise.force.with_shared(columns))


def readings_of(states: PlantState | Trajectory) -> Floats:
    """Return x [m], p1, p2 [Pa] as calibrated sensors read them, shape (n, 3)."""
    return np.column_stack(
        [states.position_reading, states.pressure_1_reading, states.pressure_2_reading]
    )


def as_read(hypothesis: Hypothesis, run: Run, readings: Floats) -> Floats:
    """Return calibrated readings as the sensors of a hypothesis show them, shape (n, 3)."""
    zero = np.array([0.0, run.atmospheric_pressure, run.atmospheric_pressure])
    offset, gain = np.array(hypothesis.offsets), np.array(hypothesis.gains)
    shown: Floats = zero + offset + gain * (readings - zero)
    return shown


def simulate_replicate(hypothesis: Hypothesis, run: Run, rng: Generator) -> Run:
    """Return a run with the same commands and conditions, simulated freely."""
    plant = hypothesis.plant_of(run)
    start = readings_of(plant.state)
    states = plant.run(hypothesis.voltages(run), run.interval)
    read = as_read(hypothesis, run, np.vstack([start, readings_of(states)]))
    position = read[:, 0] + run.noise.position * rng.standard_normal(run.size)
    noise = np.array(run.noise.pressures) * rng.standard_normal((run.size, 2))
    return replace(
        run,
        position=np.clip(position, 0.0, run.span.position),
        pressures=np.clip(read[:, 1:] + noise, run.span.low, run.span.high),
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
    return readings_of(states)[:, 1:]


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
    if chambers := run.chambers:
        simulated = np.vstack([run.smooth[:1, 1:], chamber_pressures(hypothesis, comparison)])
        simulated += np.array(run.noise.pressures) * rng.standard_normal(simulated.shape)
        clipped = np.clip(simulated, run.span.low, run.span.high)
        pressures[:, chambers] = clipped[:, chambers]
    if 'force' in run.balances and force is not None:
        samples = at_samples(bench_force(hypothesis, comparison))
        force = samples + run.noise.force * rng.standard_normal(run.size)
    position = position + run.noise.position * rng.standard_normal(run.size)
    readings = replace(
        run, position=position, pressures=pressures, force=force, original=None, delay=0.0
    )
    return Comparison(readings.with_delay(0.0) if run.delay_sd > 0.0 else readings)


def estimate_inflation(
    hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: Generator
) -> Inflation:
    """Return the inflation of the noise over one replicate of each run."""

    def noisy(run: Comparison, rng: Generator) -> tuple[Comparison, NoiseModel, Residuals]:
        simulated = replicate(hypothesis, run, rng)
        noise = noise_model(hypothesis, simulated, rng)
        return simulated, noise, simulated.residuals(hypothesis)

    triples = map_threads(noisy, comparisons, rng.spawn(len(comparisons)))
    classes = np.concatenate([speed_and_direction(run)[n.force.kept] for run, n, _ in triples])
    force = np.concatenate([residuals.force[n.force.kept] for _, n, residuals in triples])
    bias, shift = np.zeros((2, 2 * SPEED_CLASSES))
    for number in np.unique(classes):
        own = force[classes == number]
        bias[number], shift[number] = own.mean(), shrunk_mean(own)
    known = Inflation(Residuals(*np.ones((5, 1))), bias, shift)
    rows = [known.with_bias(noise, run).whiten(residuals) for run, noise, residuals in triples]
    gas_1, gas_2, force, breakaway, _ = (np.concatenate(each) for each in zip(*rows, strict=True))
    speeds = classes % SPEED_CLASSES
    by_speed = [inflation(force[speeds == number]) for number in range(SPEED_CLASSES)]
    kinds = [inflation(gas_1)], [inflation(gas_2)], by_speed, [inflation(breakaway)], [1.0]
    return known._replace(factors=Residuals(*map(np.array, kinds)))


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
    variance = float(residuals.var()) * FORCE_WINDOWS.overlap / residuals.size
    return mean * max(1.0 - variance / mean**2, 0.0) if mean != 0.0 else 0.0


def speed_classes(comparison: Comparison) -> Indices:
    """Return the class of speed of each window of the motion, shape (m,)."""
    return np.digitize(np.abs(comparison.window_velocity), SPEED_EDGES)


def speed_and_direction(comparison: Comparison) -> Indices:
    """Return the class of speed and direction of each window of the motion, shape (m,)."""
    classes = speed_classes(comparison)
    return np.where(comparison.window_velocity < 0.0, classes + SPEED_CLASSES, classes)
