"""
Twins of measured runs: what the sensors would have read if the hypothesis were true.

They show what the noise of the sensors alone does not: how far the residuals of a true model
spread where the piston creeps, or breaks away at another time than its speed says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.balances import Comparison, Residuals
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.noise import SPEEDS, NoiseModel, in_common, noise_model, speed_classes
from pneu_rig_ros.diagnosis.parallel import map_runs
from pneu_rig_ros.diagnosis.run import Run

Floats = NDArray[np.float64]

FEWEST = 12
"""Windows of the twins from which on they tell a spread."""
LARGEST = 3.0
"""Standard deviations beyond which a residual of a twin counts as that much."""


def simulate_replicate(hypothesis: Hypothesis, run: Run, rng: np.random.Generator) -> Run:
    """Return a run with the same commands and conditions, simulated freely."""
    plant = hypothesis.plant_of(run)
    start = plant.state
    true = plant.run(run.voltages, run.interval)
    x, p1, p2 = (
        np.append(first, rest)
        for first, rest in (
            (start.position_reading, true.position_reading),
            (start.pressure_1_reading, true.pressure_1_reading),
            (start.pressure_2_reading, true.pressure_2_reading),
        )
    )
    gains, zero, noise = hypothesis.gains, run.atmospheric_pressure, run.noise
    position = gains[0] * x + noise.position * rng.standard_normal(x.size)
    scale = np.array([noise.pressure_1, noise.pressure_2])
    pressures = zero + np.array(gains[1:]) * (np.column_stack([p1, p2]) - zero)
    pressures = pressures + scale * rng.standard_normal(pressures.shape)
    return replace(
        run, position=np.clip(position, 0.0, run.span.position),
        pressures=np.clip(pressures, run.span.low, run.span.high), recorded=None,
    )  # fmt: skip


class Spread(NamedTuple):
    """
    How the residuals of a true model differ from their noise.

    :param gas_1, gas_2, breakaway: factors by which they are wider [-]
    :param force: the same by class of speed
    :param bias: class of speed and direction -> mean of the force residuals [N]
    """

    gas_1: float
    gas_2: float
    force: tuple[float, ...]
    breakaway: float
    bias: Mapping[int, float]


def spread(
    hypothesis: Hypothesis, comparisons: tuple[Comparison, ...], rng: np.random.Generator
) -> Spread:
    """
    Return the spread over one twin of each run.

    What moves as somebody else makes it move has no other twin than its readings again.
    """
    if not all(one.free for one in comparisons):
        return Spread(1.0, 1.0, (1.0,) * (len(SPEEDS) - 1), 1.0, {})
    seeds = rng.spawn(len(comparisons))
    found = map_runs(partial(_twin, hypothesis), comparisons, seeds)
    twins, noises, residuals = (list(each) for each in zip(*found, strict=True))
    bias = mean_force(twins, noises, residuals)
    whitened = [with_bias(noise, twin, bias).whiten(one)
                for noise, twin, one in zip(noises, twins, residuals, strict=True)]  # fmt: skip
    columns = [np.concatenate(column) for column in zip(*whitened, strict=True)]
    gas_1, gas_2, force, breakaway = columns
    pairs = zip(twins, noises, strict=True)
    bins = np.digitize(np.concatenate([window_speeds(*pair) for pair in pairs]), SPEEDS[1:-1])
    by_speed = tuple(excess(force[bins == index]) for index in range(len(SPEEDS) - 1))
    return Spread(excess(gas_1), excess(gas_2), by_speed, excess(breakaway), bias)


def _twin(
    hypothesis: Hypothesis, one: Comparison, rng: np.random.Generator
) -> tuple[Comparison, NoiseModel, Residuals]:
    """Return a twin of a run with its noise and its residuals."""
    twin = Comparison(simulate_replicate(hypothesis, one.run, rng))
    return twin, noise_model(hypothesis, twin, rng), twin.residuals(hypothesis)


def mean_force(
    twins: Sequence[Comparison], noises: Sequence[NoiseModel], residuals: Sequence[Residuals]
) -> dict[int, float]:
    """Return class of speed and direction -> mean force residual of the twins [N]."""
    kept = [noise.force.kept for noise in noises]
    classes = np.concatenate([speed_classes(twin)[k] for twin, k in zip(twins, kept, strict=True)])
    values = np.concatenate([one.force[k] for one, k in zip(residuals, kept, strict=True)])
    return {int(index): float(values[classes == index].mean()) for index in np.unique(classes)}


def with_bias(noise: NoiseModel, comparison: Comparison, bias: Mapping[int, float]) -> NoiseModel:
    """Return the noise if windows of one speed share an error of the force besides."""
    shared = in_common(speed_classes(comparison), bias)
    return noise._replace(force=noise.force.with_common(shared))


def window_speeds(comparison: Comparison, noise: NoiseModel) -> Floats:
    """Return the mean speed in the kept windows of the motion [m/s]."""
    return np.abs(comparison.motion.plain_means(comparison.run.velocity))[noise.force.kept]


def excess(whitened: Floats) -> float:
    """Return by which factor whitened residuals spread beyond the noise, at least 1 [-]."""
    if whitened.size < FEWEST:
        return 1.0
    within = np.clip(whitened, -LARGEST, LARGEST)
    return max(float(np.sqrt(np.mean(within**2))), 1.0)


def factors_of(factors: Spread, comparison: Comparison, noise: NoiseModel) -> Residuals:
    """Return the factor of each kept window."""
    bins = np.digitize(window_speeds(comparison, noise), SPEEDS[1:-1])
    gas_1, gas_2, breakaway = (
        np.full(int(whiten.kept.sum()), factor)
        for whiten, factor in (
            (noise.gas_1, factors.gas_1), (noise.gas_2, factors.gas_2),
            (noise.breakaway, factors.breakaway),
        )
    )  # fmt: skip
    return Residuals(gas_1, gas_2, np.array(factors.force)[bins], breakaway)
