"""One random rig, simulated: whether what it does is possible, looked at as closely as needed."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.plant import TOLERANCE, Plant

from .balances import Residuals, problems, residuals
from .random_rigs import DURATION, case

FINE_TOLERANCE = 1e-9
"""Local error of a run whose steps are so many that their errors add up [-]."""
EFFORTS = (
    (5_000, TOLERANCE),
    (200_000, TOLERANCE),
    (1_000_000, TOLERANCE),
    (1_000_000, FINE_TOLERANCE),
)
"""Samples and tolerance, the next when a balance does not hold with those before."""
LIMIT = 2e-3
"""Largest residual of a balance, as a share of the energy moved [-]."""


class Outcome(NamedTuple):
    """
    What became of a case.

    :param problems: what was impossible, () in a good run
    :param steps: of the integrator, rejected ones included, at the first effort
    :param seconds: processor time, at the first effort [s]
    :param level: index of the effort that it took
    """

    seed: int
    problems: tuple[str, ...]
    residuals: Residuals
    steps: int
    seconds: float
    level: int


def outcome(seed: int, level: int = 0, share: float = 1.0) -> Outcome:
    """
    Simulate a case; look closer when a balance does not hold.

    :param level: index of the first effort
    :param share: of the run that is simulated, from its beginning [-]
    """
    tried = first = _run(seed, level, share)
    while tried.problems and tried.level + 1 < len(EFFORTS):
        tried = _run(seed, tried.level + 1, share)
    return tried._replace(steps=first.steps, seconds=first.seconds)


def _run(seed: int, level: int, share: float) -> Outcome:
    (configuration, steps), (samples, tolerance) = case(seed), EFFORTS[level]
    model, effects = configuration.model, configuration.effects
    # All effects, most of them null: one compiled plant for every case.
    plant = Plant(model, {**library.nulls(), **effects}, tolerance=tolerance)
    start, started = plant.state, time.process_time()
    voltages = np.repeat(steps, samples // len(steps), axis=0)[: round(share * samples)]
    run = plant.run(voltages, DURATION / samples)
    taken = time.process_time() - started
    found = problems(run, model)
    left = Residuals(0.0, 0.0, 0.0, 0.0) if found else residuals(run, start, model, effects)
    count = plant.counts['steps'] + plant.counts['rejected']
    return Outcome(seed, tuple(found or _unbalanced(left)), left, count, taken, level)


def _unbalanced(left: Residuals) -> list[str]:
    checks = {
        f'gas: {left.gas:.2g} of the energy is not accounted for': left.gas <= LIMIT,
        f'{left.created:.2g} of the energy is created': left.created <= LIMIT,
        f'friction gives {-left.dissipated:.2g} of the energy': left.dissipated >= -LIMIT,
        f'{left.overpressure:.4g} of the largest possible pressure': left.overpressure
        <= 1.0 + LIMIT,
    }
    return [text for text, holds in checks.items() if not holds]
