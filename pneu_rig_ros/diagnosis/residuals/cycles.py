"""
Simulated cycles and free runs as data: the gap between them and the readings.

The gap of a cycle counts in multiples of its spread, which errors of the readings at the restart
make. A cycle is one piece of data, however many samples it has: a slip at the wrong time is wrong
until the next restart. In a free run of a true model nothing but the noise is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.random import Generator
from scipy.ndimage import maximum_filter1d
from scipy.stats import combine_pvalues, mannwhitneyu
from scipy.stats import t as student

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.replicates import simulate_replicate
from pneu_rig_ros.diagnosis.residuals.shooting import RESTART_WINDOW, SIGNALS, MultipleShooting
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import map_threads
from pneu_rig_ros.rig.configuration import between_recordings

DRAWS = 8
"""Simulations from other errors of the readings at the restarts."""
NEIGHBOURS = 5
"""Blocks that share the largest spread of them, as a slip may come a little earlier or later."""
ROUNDED = 0.15
"""Share of the noise that remains in any mean: readings may stay within one step [-]."""
NUMERICAL = (2e-5, 3e-5)
"""Errors of the integration, as shares of stroke and of supply pressure [-]."""
TRUE_LOSS = 0.35
"""Mean loss of a reading of a true model, at most [-]."""
BROKEN_DOWN = 1e6
"""Gap of a simulation that fails [standard deviations]."""
REPLICATES = 3
"""Replicates of each run, at most, that show the loss of a true model's cycles."""
FREE_REPLICATES = 10
"""The same of free runs, each compared with its own: they show its deviation to a quarter."""
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
        cls,
        hypothesis: Hypothesis,
        comparisons: Sequence[Comparison],
        rng: Generator,
        free: bool = False,
    ) -> Cycles:
        """Return the runs with the spread that they have if the hypothesis is true."""
        runs = tuple(MultipleShooting(comparison, free) for comparison in comparisons)
        spreads = map_threads(partial(spread_of_gap, hypothesis), runs, rng.spawn(len(runs)))
        return cls(runs, tuple(spreads))

    @property
    def free(self) -> bool:
        """Whether the runs are restarted in their first rests alone."""
        return self.runs[0].free

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """Return the vector that a fit minimises: half its square is the sum of the losses."""
        return np.arcsinh(self.gaps(hypothesis)) * self._factors

    def gaps(self, hypothesis: Hypothesis) -> Floats:
        """Return the scaled gaps of all runs, shape (n,)."""
        return np.concatenate([gap.ravel() for gap in self._scaled(hypothesis)])

    def loss_of(self, gaps: Floats) -> float:
        """Return the loss of scaled gaps of all runs [-]."""
        return 0.5 * float(np.sum((np.arcsinh(gaps) * self._factors) ** 2))

    @cached_property
    def _factors(self) -> Floats:
        """Weights of the scaled gaps of all runs in the residual, shape (n,)."""
        weights = np.concatenate([run.weights for run in self.runs])
        return np.repeat(np.sqrt(weights / SIGNALS), SIGNALS)

    def losses(self, hypothesis: Hypothesis) -> Floats:
        """Return the loss of each cycle [-], shape (cycles,)."""
        pairs = zip(self.runs, self._block_losses(hypothesis), strict=True)
        return np.concatenate([run.by_cycle(losses) for run, losses in pairs])

    def excess(self, hypothesis: Hypothesis) -> float:
        """
        Return the mean loss of a reading beyond that of a true model [-].

        In free runs one slip may be off and no other: each cycle counts by itself.
        """
        readings = np.concatenate([run.by_cycle(run.weights) for run in self.runs])
        beyond = self.losses(hypothesis) - TRUE_LOSS * readings
        total = np.maximum(beyond, 0.0).sum() if self.free else beyond.sum()
        return max(float(total / readings.sum()), 0.0)

    def losses_by_run(self, hypothesis: Hypothesis) -> Floats:
        """Return the mean loss of the readings of each run [-], shape (runs,)."""
        pairs = zip(self.runs, self._block_losses(hypothesis), strict=True)
        return np.array([losses.sum() / run.weights.sum() for run, losses in pairs])

    def _block_losses(self, hypothesis: Hypothesis) -> list[Floats]:
        """Return the losses of the readings of each block, shape (blocks,) each."""
        pairs = zip(self.runs, self._scaled(hypothesis), strict=True)
        return [0.5 * run.weights * np.mean(np.arcsinh(gap) ** 2, axis=1) for run, gap in pairs]

    def _scaled(self, hypothesis: Hypothesis) -> list[Floats]:
        """Return the scaled gap of each run, shape (blocks, 3) each."""
        return map_threads(partial(scaled_gap, hypothesis), self.runs, self.spreads)


def scaled_gap(hypothesis: Hypothesis, run: MultipleShooting, spread: Floats) -> Floats:
    """Return the gap of a run in multiples of its spread, shape (blocks, 3)."""
    try:
        scaled = run.gap(hypothesis) / spread
    except RigError:  # the simulation failed
        return np.full(spread.shape, BROKEN_DOWN)
    finite = np.nan_to_num(scaled, nan=BROKEN_DOWN, posinf=BROKEN_DOWN, neginf=-BROKEN_DOWN)
    return np.clip(finite, -BROKEN_DOWN, BROKEN_DOWN)


def spread_of_gap(hypothesis: Hypothesis, shooting: MultipleShooting, rng: Generator) -> Floats:
    """Return the standard deviation of the gap if a hypothesis is true, shape (blocks, 3)."""
    run = shooting.run
    noise = run.noise.readings
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


def simulate_worn(hypothesis: Hypothesis, run: Run, rng: Generator) -> Run:
    """Return a replicate of a run that differs as recordings may differ from each other."""
    if run.level_sd > 0.0:
        relative = run.level_sd / hypothesis.model.friction.coulomb_force
        hypothesis = hypothesis.with_friction_level(1.0 + relative * float(rng.standard_normal()))
    for name, spread in between_recordings(run.repeatability).items():
        hypothesis = hypothesis.varied(name, spread * float(rng.standard_normal()))
    return simulate_replicate(hypothesis, run, rng)


def replicates_of(
    hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: Generator
) -> list[Comparison]:
    """Return a replicate of each run."""
    runs = [comparison.run for comparison in comparisons]
    worn = map_threads(partial(simulate_worn, hypothesis), runs, rng.spawn(len(runs)))
    return [Comparison(run) for run in worn]


def compare_cycles(
    hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: Generator
) -> CycleTest:
    """
    Return the test of simulated cycles against those of replicates (Mann-Whitney).

    Replicates are added until the cycles are no farther off than theirs: then they agree.
    """
    losses, expected = Cycles.of(hypothesis, comparisons, rng).losses(hypothesis), np.empty(0)
    for _ in range(REPLICATES):
        replicates = replicates_of(hypothesis, comparisons, rng)
        of_replicates = Cycles.of(hypothesis, replicates, rng).losses(hypothesis)
        expected = np.append(expected, of_replicates)
        if losses.mean() <= expected.mean():
            break
    p_value = float(mannwhitneyu(losses, expected, alternative='greater').pvalue)
    return CycleTest(float(losses.mean()), float(expected.mean()), p_value)


def compare_free_runs(
    hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: Generator
) -> CycleTest:
    """
    Return the test of free runs against those of replicates, each run with its own.

    A run with a slip that may or may not happen spreads many times as far as one without. The
    logarithms of the losses are compared by Student's t, and the p-values of the runs combined
    (R. A. Fisher, Statistical Methods for Research Workers, 1932, 21.1).
    """
    measured = Cycles.of(hypothesis, comparisons, rng, free=True)
    losses, rows = measured.losses_by_run(hypothesis), list[Floats]()
    for _ in range(FREE_REPLICATES):
        replicates = replicates_of(hypothesis, comparisons, rng)
        runs = tuple(MultipleShooting(each, free=True) for each in replicates)
        rows.append(replace(measured, runs=runs).losses_by_run(hypothesis))
    expected, logarithms = np.array(rows), np.log(rows)
    deviation = logarithms.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / FREE_REPLICATES)
    distance = (np.log(losses) - logarithms.mean(axis=0)) / deviation
    p_values = student.sf(distance, FREE_REPLICATES - 1)
    p_value = float(combine_pvalues(p_values, method='fisher').pvalue)
    return CycleTest(float(losses.mean()), float(expected.mean()), p_value)
