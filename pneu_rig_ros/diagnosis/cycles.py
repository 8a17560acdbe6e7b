"""
Explanations confirmed by simulation from rest to rest.

Of each cycle what counts is how far position and pressures are off, in multiples of what errors of
the readings at its restart make of a true model. A cycle is one piece of dataset, however many
samples it has: a slip at the wrong time is wrong until the next restart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.parallel import map_runs
from pneu_rig_ros.diagnosis.shooting import READING, MultipleShooting
from pneu_rig_ros.errors import RigError

Floats = NDArray[np.float64]

DRAWS = 8
"""Simulations from other errors of the readings at the restarts."""
NEIGHBOURS = 5
"""Blocks over which their spread is one, as a slip may come a little earlier or later."""
ROUNDED = 0.15
"""What rounding leaves of the noise in any mean: readings may stay within one step [-]."""
NUMERICAL = (2e-5, 3e-5)
"""What errors of the integration may amount to, share of stroke and of supply [-]."""
EVIDENCE = 10.0
"""Independent readings that a cycle is worth."""
FAR = 1e6
"""Where a simulation breaks down it is off by so many noises [-]."""


@dataclass(frozen=True)
class Cycles:
    """
    Runs with the spread of their simulation.

    :param runs: to be simulated
    :param floors: standard deviation of the gap if the hypothesis is true, shape (blocks, 3) each
    """

    runs: tuple[MultipleShooting, ...]
    floors: tuple[Floats, ...]

    @classmethod
    def of(
        cls, hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: np.random.Generator
    ) -> Cycles:
        """Return the runs with the spread that they have if the hypothesis is true."""
        runs = tuple(MultipleShooting(one) for one in comparisons)
        return cls(runs, tuple(map_runs(partial(floor, hypothesis), runs, rng.spawn(len(runs)))))

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """Return what a fit makes small, shape (n,): half its square is the sum of the losses."""
        parts = []
        for run, scaled in zip(self.runs, self._off(hypothesis), strict=True):
            weights = np.sqrt(EVIDENCE / np.bincount(run.segments)[run.segments] / 3.0)
            parts.append((scaled * weights[:, np.newaxis]).ravel())
        return np.concatenate(parts)

    def losses(self, hypothesis: Hypothesis) -> Floats:
        """Return the loss of each cycle [-], about 2 for a true hypothesis, shape (cycles,)."""
        parts = []
        for run, scaled in zip(self.runs, self._off(hypothesis), strict=True):
            squares = np.mean(scaled**2, axis=1)
            counts = np.bincount(run.segments)
            sums = np.bincount(run.segments, squares)
            parts.append(0.5 * EVIDENCE * sums[counts > 0] / counts[counts > 0])
        return np.concatenate(parts)

    def _off(self, hypothesis: Hypothesis) -> list[Floats]:
        """Return the inverse hyperbolic sine of each run's scaled gap: large ones count little."""
        every = map_runs(partial(off, hypothesis), self.runs, self.floors)
        return [np.arcsinh(one) for one in every]


def off(hypothesis: Hypothesis, run: MultipleShooting, noise: Floats) -> Floats:
    """Return the gap of a run in multiples of its noise, shape (blocks, 3)."""
    try:
        scaled = run.gap(hypothesis) / noise
    except RigError:  # the simulation broke down
        return np.full(noise.shape, FAR)
    return np.clip(np.nan_to_num(scaled, nan=FAR, posinf=FAR, neginf=-FAR), -FAR, FAR)


def floor(hypothesis: Hypothesis, run: MultipleShooting, rng: np.random.Generator) -> Floats:
    """Return the standard deviation of the gap if the hypothesis is true, shape (blocks, 3)."""
    measured = run.run
    noise = np.array(
        [measured.noise.position, measured.noise.pressure_1, measured.noise.pressure_2]
    )
    samples = max(round(READING / measured.interval), 1)
    at_restart = noise * np.hypot(1.0 / np.sqrt(samples), ROUNDED)
    draws = [
        run.gap(hypothesis, at_restart * rng.standard_normal((measured.size - 1, 3)))
        for _ in range(DRAWS)
    ]
    spread = maximum_filter1d(np.std(draws, axis=0, ddof=1), NEIGHBOURS, axis=0)
    of_mean = noise * np.hypot(1.0 / np.sqrt(run.block), ROUNDED)
    stroke, supply = NUMERICAL
    pressure = supply * measured.operation.supply_pressure
    numerical = np.array([stroke * measured.stroke, pressure, pressure])
    total: Floats = np.sqrt(of_mean**2 + numerical**2 + spread**2)
    return total
