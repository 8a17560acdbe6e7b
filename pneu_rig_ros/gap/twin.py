"""
A twin of a measured run: what the rig's sensors would have read if the hypothesis were true.

What a residual of the twin shows is the noise of the sensors and of its own computation, not a
disagreement.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, predict

Floats = NDArray[np.float64]

TWINS = 3
"""Of each run, of which the median counts."""


def twin_of(
    hypothesis: Hypothesis, experiment: Experiment, rng: np.random.Generator
) -> Experiment:
    """Return an experiment with the same commands and conditions, simulated freely."""
    run = predict(hypothesis, experiment, Mode.FREE).run
    start, zero, sensors = experiment.operation, experiment.zero, experiment.sensors
    gains = hypothesis.gains
    # what it starts from is a reading already
    columns = {
        'position': (start.initial_position, run.position_reading, 0.0, sensors.position_span),
        'pressure_1': (start.initial_pressure_1, run.pressure_1_reading, zero,
                       sensors.pressure_span),
        'pressure_2': (start.initial_pressure_2, run.pressure_2_reading, zero,
                       sensors.pressure_span),
    }  # fmt: skip
    readings: dict[str, Any] = {
        name: read(np.append(first - low, gain * (true - low)), span, noise, code, rng) + low
        for (name, (first, true, low, span)), gain, noise, code in zip(
            columns.items(), gains, experiment.noise, experiment.codes, strict=True
        )
    }
    return replace(experiment, record=replace(experiment.record, **readings))


def expected_cost(hypothesis: Hypothesis, evidence: Evidence, modes: Sequence[Mode]) -> float:
    """
    Return about what the cost would be if the hypothesis were true [-], see ``Evidence``.

    The median over some twins: now and then one breaks away at another time than its predictions.
    """
    return float(np.median([cost_of_twin(hypothesis, evidence, modes) for _ in range(TWINS)]))


def cost_of_twin(hypothesis: Hypothesis, evidence: Evidence, modes: Sequence[Mode]) -> float:
    """Return the cost of the hypothesis on a twin of every experiment [-]."""
    twins = [twin_of(hypothesis, one, evidence.rng) for one in evidence.experiments]
    measured_again = Evidence(twins, evidence.rng)
    measured_again.settle_floors(hypothesis, modes)
    return measured_again.cost(hypothesis, modes)


def read(true: Floats, span: float, noise: float, code: float, rng: np.random.Generator) -> Floats:
    """Return readings with noise, within the span, rounded to codes, shape (n,)."""
    # the standard deviation given is that of noise and rounding together
    white = np.sqrt(max(noise**2 - code**2 / 12.0, 0.0))
    seen = np.clip(true + white * rng.standard_normal(true.size), 0.0, span)
    readings: Floats = np.round(seen / code) * code
    return readings
