"""The regime of motion of every block of a measured run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.prediction import block_means

REGIMES = ('dwell', 'breakaway', 'sliding out', 'sliding in', 'end stop')
DWELL, BREAKAWAY, OUT, IN, END_STOP = range(5)

AROUND_BREAKAWAY = (0.06, 0.09)
"""Before and after the end of a rest [s]."""
NEAR_STOP = 1.5e-3
"""A piston at rest this close to an end stop is held by it [m]."""


def sample_regimes(experiment: Experiment, stroke: float) -> NDArray[np.int8]:
    """Return the regime of every sample, an index of ``REGIMES``, shape (n,)."""
    position, velocity = experiment.smooth_position, experiment.measured[:, 1]
    regimes = np.where(velocity >= 0.0, OUT, IN).astype(np.int8)
    before, after = (round(time / experiment.interval) for time in AROUND_BREAKAWAY)
    for rest in experiment.rests:
        stopped = not NEAR_STOP < rest.readings[0] < stroke - NEAR_STOP
        regimes[rest.start : rest.end] = END_STOP if stopped and rest.start > 0 else DWELL
    for rest in experiment.rests:
        if rest.end < position.size:
            regimes[max(rest.end - before, rest.start) : rest.end + after] = BREAKAWAY
    return regimes


def block_regimes(experiment: Experiment, stroke: float) -> NDArray[np.int8]:
    """Return the regime that most samples of each block have, shape (blocks,)."""
    regimes = sample_regimes(experiment, stroke)[1:]
    shares = np.column_stack([regimes == index for index in range(len(REGIMES))])
    most: NDArray[np.int8] = (
        block_means(shares.astype(np.float64), experiment.block).argmax(axis=1).astype(np.int8)
    )
    return most
