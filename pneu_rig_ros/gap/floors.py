"""
The noise floor of a prediction: how far it may be off although the hypothesis is true.

The readings have noise, and so have those from which a prediction starts. Where the piston breaks
away, a small error of pressure is a large one of position a moment later; so errors of the start
are propagated by predicting again from readings with other errors.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from pneu_rig_ros.gap.experiment import READING, Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.noise import mean_noise
from pneu_rig_ros.gap.prediction import Jitter, Mode, block_means, predict
from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled import plain

Floats = NDArray[np.float64]

DRAWS = 8
"""Predictions from other errors of the readings."""
SPREAD = 5
"""Blocks over which the floor is spread, as the slip may come a little earlier or later."""
MODEL_SHARE = (2e-5, 3e-5)
"""What numerical errors of a prediction may amount to, share of stroke and of supply [-]."""


def restart_noise(experiment: Experiment) -> Floats:
    """Return the standard deviation of the x [m], p1, p2 [Pa] that a restart takes, shape (3,)."""
    samples = round(READING / experiment.interval)
    pairs = zip(experiment.noise, experiment.codes, strict=True)
    return np.array([mean_noise(noise, code, samples) for noise, code in pairs])


def noise_floor(
    hypothesis: Hypothesis, experiment: Experiment, mode: Mode, rng: np.random.Generator
) -> Floats:
    """Return the standard deviation of the gap if the hypothesis is true, shape (blocks, 3)."""
    jitter = Jitter(rng, restart_noise(experiment))
    runs = [predict(hypothesis, experiment, mode, jitter).readings for _ in range(DRAWS)]
    means = np.array([block_means(run, experiment.block) for run in runs])
    spread = maximum_filter1d(means.std(axis=0, ddof=1), SPREAD, axis=0)
    stroke, supply = hypothesis.model.cylinder.stroke, experiment.operation.supply_pressure
    share, of_supply = MODEL_SHARE
    numerical = np.array([share * stroke, of_supply * supply, of_supply * supply])
    variance = experiment.floor**2 + numerical**2 + spread**2
    if mode is Mode.CHAMBERS:
        variance[:, 1:] += imposed_noise(hypothesis, experiment)[: len(variance)] ** 2
    floor: Floats = np.sqrt(variance)
    return floor


def imposed_noise(hypothesis: Hypothesis, experiment: Experiment) -> Floats:
    """
    Return what the noise of an imposed position does to p1, p2 [Pa], shape (blocks, 2).

    A piston that is read too far out by dx compresses the gas, dp = k p A dx / V.
    """
    cylinder, k = hypothesis.model.cylinder, hypothesis.model.gas.heat_capacity_ratio
    means = block_means(experiment.measured[1:], experiment.block)
    position: Any = np.clip(means[:, 0], 0.0, cylinder.stroke)
    volume_1, volume_2 = plain(chambers.volumes)(position, cylinder)
    shares = np.column_stack([cylinder.cap_area / volume_1, cylinder.rod_area / volume_2])
    noise: Floats = k * means[:, 2:] * shares * experiment.floor[0]
    return noise
