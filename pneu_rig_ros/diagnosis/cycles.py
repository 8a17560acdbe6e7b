"""
Simulated cycles as data: the gap from rest to rest in multiples of its spread.

The spread is what errors of the readings at its restart make of the gap of a true model. A cycle
is one piece of data, however many samples it has: a slip at the wrong time is wrong until the
next restart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.stats import mannwhitneyu

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.parallel import map_runs
from pneu_rig_ros.diagnosis.replicates import simulate_replicate
from pneu_rig_ros.diagnosis.shooting import RESTART_WINDOW, MultipleShooting
from pneu_rig_ros.diagnosis.weak_form import Floats
from pneu_rig_ros.errors import RigError

DRAWS = 8
"""Simulations from other errors of the readings at the restarts."""
NEIGHBOURS = 5
"""Blocks that share the largest spread of them, as a slip may come a little earlier or later."""
ROUNDED = 0.15
"""Share of the noise that remains in any mean: readings may stay within one step [-]."""
NUMERICAL = (2e-5, 3e-5)
"""Errors of the integration, as shares of stroke and of supply pressure [-]."""
CYCLE_WEIGHT = 10.0
"""Independent readings that a cycle is worth."""
BROKEN_DOWN = 1e6
"""Gap of a simulation that fails [standard deviations]."""
REPLICATES = 3
"""Replicates of each run that show the loss of a true model's cycles."""
FALSE_ALARMS = 0.01
"""Share of true models whose cycles are called significantly different [-]."""
LEAST_RATIO = 1.3
"""Ratio of losses to those of replicates below which cycles agree, however many there are [-]."""


@dataclass(frozen=True)
class Cycles:
    """
    Runs with the spread of their simulation.

    :param runs: to be simulated
    :param spreads: standard deviation of the gap of a true model, shape (blocks, 3) each
    """

    runs: tuple[MultipleShooting, ...]
    spreads: tuple[Floats, ...]

    @classmethod
    def of(
        cls, hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: np.random.Generator
    ) -> Cycles:
        """Return the runs with the spread that they have if the hypothesis is true."""
        runs = tuple(MultipleShooting(comparison) for comparison in comparisons)
        spreads = map_runs(partial(spread_of_gap, hypothesis), runs, rng.spawn(len(runs)))
        return cls(runs, tuple(spreads))

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """Return the vector that a fit minimises: half its square is the sum of the losses."""
        parts = []
        for run, scaled in zip(self.runs, self._scaled(hypothesis), strict=True):
            weights = np.sqrt(CYCLE_WEIGHT / np.bincount(run.segments)[run.segments] / 3.0)
            parts.append((scaled * weights[:, np.newaxis]).ravel())
        return np.concatenate(parts)

    def losses(self, hypothesis: Hypothesis) -> Floats:
        """Return the loss of each cycle [-], about 2 for a true hypothesis, shape (cycles,)."""
        parts = []
        for run, scaled in zip(self.runs, self._scaled(hypothesis), strict=True):
            counts = np.bincount(run.segments)
            sums = np.bincount(run.segments, np.mean(scaled**2, axis=1))
            parts.append(0.5 * CYCLE_WEIGHT * sums[counts > 0] / counts[counts > 0])
        return np.concatenate(parts)

    def _scaled(self, hypothesis: Hypothesis) -> list[Floats]:
        """Return the scaled gap of each run, large values compressed by arsinh."""
        gaps = map_runs(partial(scaled_gap, hypothesis), self.runs, self.spreads)
        return [np.arcsinh(gap) for gap in gaps]


def scaled_gap(hypothesis: Hypothesis, run: MultipleShooting, spread: Floats) -> Floats:
    """Return the gap of a run in multiples of its spread, shape (blocks, 3)."""
    try:
        scaled = run.gap(hypothesis) / spread
    except RigError:  # the simulation failed
        return np.full(spread.shape, BROKEN_DOWN)
    finite = np.nan_to_num(scaled, nan=BROKEN_DOWN, posinf=BROKEN_DOWN, neginf=-BROKEN_DOWN)
    return np.clip(finite, -BROKEN_DOWN, BROKEN_DOWN)


def spread_of_gap(
    hypothesis: Hypothesis, shooting: MultipleShooting, rng: np.random.Generator
) -> Floats:
    """Return the standard deviation of the gap if a hypothesis is true, shape (blocks, 3)."""
    run = shooting.run
    noise = np.array([run.noise.position, run.noise.pressure_1, run.noise.pressure_2])
    samples = max(round(RESTART_WINDOW / run.interval), 1)
    at_restart = noise * np.hypot(1.0 / np.sqrt(samples), ROUNDED)
    draws = [
        shooting.gap(hypothesis, at_restart * rng.standard_normal((run.size - 1, 3)))
        for _ in range(DRAWS)
    ]
    spread = maximum_filter1d(np.std(draws, axis=0, ddof=1), NEIGHBOURS, axis=0)
    of_mean = noise * np.hypot(1.0 / np.sqrt(shooting.block), ROUNDED)
    stroke, supply = NUMERICAL
    pressure = supply * run.operation.supply_pressure
    numerical = np.array([stroke * run.stroke, pressure, pressure])
    total: Floats = np.sqrt(of_mean**2 + numerical**2 + spread**2)
    return total


@dataclass(frozen=True)
class CycleTest:
    """Mean loss of cycles, that of replicates [-], and the p-value of the difference."""

    loss: float
    expected: float
    p_value: float

    @property
    def significant(self) -> bool:
        """Whether the cycles are farther off than those of a true model."""
        return self.p_value < FALSE_ALARMS and self.loss > LEAST_RATIO * self.expected


def compare_cycles(
    hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: np.random.Generator
) -> CycleTest:
    """Return the test of simulated cycles against those of replicates (Mann-Whitney)."""
    losses = Cycles.of(hypothesis, comparisons, rng).losses(hypothesis)
    runs = [comparison.run for comparison in comparisons for _ in range(REPLICATES)]
    simulate = partial(simulate_replicate, hypothesis)
    replicates = [Comparison(run) for run in map_runs(simulate, runs, rng.spawn(len(runs)))]
    expected = Cycles.of(hypothesis, replicates, rng).losses(hypothesis)
    p_value = float(mannwhitneyu(losses, expected, alternative='greater').pvalue)
    return CycleTest(float(losses.mean()), float(expected.mean()), p_value)
