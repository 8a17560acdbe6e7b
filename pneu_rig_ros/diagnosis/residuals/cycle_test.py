"""Tests of simulated cycles and free runs against those of replicates of the same runs."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.random import Generator
from scipy.stats import combine_pvalues, mannwhitneyu
from scipy.stats import t as student

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.cycles import Cycles
from pneu_rig_ros.diagnosis.residuals.replicates import simulate_replicate
from pneu_rig_ros.diagnosis.residuals.threads import map_runs
from pneu_rig_ros.rig.configuration import between_recordings

REPLICATES = 3
"""Replicates of each run, at most, that show the loss of a true model's cycles."""
FREE_REPLICATES = 10
"""The same of free runs, each compared with its own: they show its deviation to a quarter."""
FALSE_ALARMS = 0.01
"""Share of true models whose cycles are called significantly different [-]."""
LEAST_RATIO = 1.3
"""Ratio of losses to those of replicates below which cycles agree, however many there are [-]."""


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
    friction = hypothesis.model.friction
    if run.level_error > 0.0:
        factor = 1.0 + run.level_error / friction.coulomb_force * float(rng.standard_normal())
        for name in ('coulomb_force', 'breakaway_force'):
            level = factor * getattr(friction, name)
            hypothesis = hypothesis.with_parameter('friction', name, level)
    for name, spread in between_recordings(run.repeatability).items():
        hypothesis = hypothesis.varied(name, spread * float(rng.standard_normal()))
    return simulate_replicate(hypothesis, run, rng)


def replicates_of(
    hypothesis: Hypothesis, comparisons: Sequence[Comparison], rng: Generator
) -> list[Comparison]:
    """Return a replicate of each run."""
    runs = [comparison.run for comparison in comparisons]
    worn = map_runs(partial(simulate_worn, hypothesis), runs, rng.spawn(len(runs)))
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
        replicates = measured.with_runs(replicates_of(hypothesis, comparisons, rng))
        rows.append(replicates.losses_by_run(hypothesis))
    expected, logarithms = np.array(rows), np.log(rows)
    deviation = logarithms.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / FREE_REPLICATES)
    distance = (np.log(losses) - logarithms.mean(axis=0)) / deviation
    p_values = student.sf(distance, FREE_REPLICATES - 1)
    p_value = float(combine_pvalues(p_values, method='fisher').pvalue)
    return CycleTest(float(losses.mean()), float(expected.mean()), p_value)
