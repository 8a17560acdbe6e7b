"""The data that judge a hypothesis: whitened residuals, and simulated cycles if they are used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, Comparison, Residuals
from pneu_rig_ros.diagnosis.residuals.cycles import Cycles
from pneu_rig_ros.diagnosis.residuals.noise import (
    COPIES,
    REPLICATE_COPIES,
    NoiseModel,
    gas_variance,
    noise_model,
)
from pneu_rig_ros.diagnosis.residuals.nuisances import (
    RunNuisances,
    clock_column,
    estimate_nuisances,
    fitted_to_pressures,
    temperature_columns,
    varying_columns,
    without_nuisances,
)
from pneu_rig_ros.diagnosis.residuals.replicates import Inflation, estimate_inflation, with_bias
from pneu_rig_ros.diagnosis.residuals.threads import map_runs

OUTLIER = 3.0
"""Standard deviations beyond which a residual counts linearly [-]."""
LARGEST = 1e4
"""Whitened residuals are clipped to it [-]."""
STRETCHES = 12
"""Parts of a run and balance whose losses are taken to be independent."""


class Evaluation(NamedTuple):
    """Residuals of one run under a hypothesis, their noise, and both as whitened residuals."""

    residuals: Residuals
    noise: NoiseModel
    whitened: Residuals


@dataclass(frozen=True)
class Dataset:
    """
    Runs with the noise of their residuals under one hypothesis.

    :param reference: that hypothesis
    :param comparisons: the runs
    :param noises: of each
    :param inflation: of the noise, by replicates
    :param clocks: change of the residuals of each run by one standard deviation of its delay,
        shape (m, 1) each
    :param cycles: the simulated cycles, None where simulation is not used
    """

    reference: Hypothesis
    comparisons: tuple[Comparison, ...]
    noises: tuple[NoiseModel, ...]
    inflation: Inflation
    clocks: tuple[Residuals, ...]
    cycles: Cycles | None = None

    @classmethod
    def of(
        cls,
        hypothesis: Hypothesis,
        comparisons: Sequence[Comparison],
        rng: Generator,
        inflation: Inflation | None = None,
    ) -> Dataset:
        """
        Return the runs with the noise that they have if the hypothesis is true.

        :param inflation: where it is known for the hypothesis: that of which they are replicates
        """
        count = len(comparisons)
        aligned = map_runs(partial(without_nuisances, hypothesis), comparisons, rng.spawn(count))
        runs = tuple(aligned)
        copies = COPIES if inflation is None else REPLICATE_COPIES
        inflation = inflation or estimate_inflation(hypothesis, runs, rng)
        noise = partial(noise_model, hypothesis, copies=copies)
        noises = map_runs(noise, runs, rng.spawn(count))
        varying = map_runs(partial(varying_columns, hypothesis), runs)
        pairs = zip(noises, varying, strict=True)
        noises = [model.with_shared(columns) for model, columns in pairs]
        biased = tuple(with_bias(*pair, inflation.bias) for pair in zip(noises, runs, strict=True))
        clocks = map_runs(partial(clock_column, hypothesis), runs)
        return cls(hypothesis, runs, biased, inflation, tuple(clocks))

    def with_cycles(self, hypothesis: Hypothesis, rng: Generator, free: bool = False) -> Dataset:
        """
        Return the dataset with simulated cycles, spread as if the hypothesis were true.

        :param free: whether they are those of free runs
        """
        return replace(self, cycles=Cycles.of(hypothesis, self.comparisons, rng, free))

    @property
    def without_cycles(self) -> Dataset:
        """The dataset without simulation."""
        return replace(self, cycles=None)

    @property
    def free_runs(self) -> Cycles | None:
        """The simulated cycles if they are those of free runs."""
        return self.cycles if self.cycles is not None and self.cycles.free else None

    @property
    def runs_freely(self) -> bool:
        """Whether its simulated cycles, if any, are those of free runs."""
        return self.free_runs is not None

    @property
    def single_runs(self) -> list[Dataset]:
        """A dataset of each run, without simulation."""
        return [
            replace(self, comparisons=(run,), noises=(noise,), clocks=(clock,), cycles=None)
            for run, noise, clock in zip(self.comparisons, self.noises, self.clocks, strict=True)
        ]

    def with_discrepancy(self, other: Dataset, hypothesis: Hypothesis) -> Dataset:
        """
        Return the dataset with a noise as wide as the residuals of a hypothesis.

        :param other: whose residuals give the width, balance by balance
        """
        rows = other.residuals_by_run(hypothesis)
        gas_1, gas_2, force, breakaway, stop = (
            max(rms(np.concatenate(column)), 1.0) for column in zip(*rows, strict=True)
        )
        old = self.inflation
        wider = old._replace(
            gas_1=old.gas_1 * gas_1,
            gas_2=old.gas_2 * gas_2,
            force=tuple(force * factor for factor in old.force),
            breakaway=old.breakaway * breakaway,
            stop=old.stop * stop,
        )
        return replace(self, inflation=wider)

    def nuisances(self, hypothesis: Hypothesis, comparison: Comparison) -> RunNuisances | None:
        """Return the nuisance parameters of one of the runs, None where it has none."""
        if not comparison.run.has_nuisances:
            return None
        index = [each is comparison for each in self.comparisons].index(True)
        by_rates = estimate_nuisances(hypothesis, comparison, self.noises[index])
        return fitted_to_pressures(hypothesis, comparison, by_rates)

    def aligned(self, hypothesis: Hypothesis, comparison: Comparison) -> Comparison:
        """Return one of the runs, corrected for its nuisance parameters under a hypothesis."""
        estimate = self.nuisances(hypothesis, comparison)
        return comparison if estimate is None else Comparison(estimate.correct(comparison.run))

    @cached_property
    def factors(self) -> list[Residuals]:
        """Inflation of the noise in each window of each run [-]."""
        pairs = zip(self.comparisons, self.noises, strict=True)
        return [self.inflation.factors(*pair) for pair in pairs]

    @cached_property
    def white(self) -> list[list[Floats]]:
        """Variances of the gas residuals of each run by noise of the readings [kg^2/s^2]."""
        return [
            [gas_variance(self.reference, run, chamber) for chamber in (1, 2)]
            for run in self.comparisons
        ]

    @cached_property
    def biases(self) -> list[Floats]:
        """Mean force residual of a true model in each window of each run [N]."""
        return [self.inflation.force_bias(comparison) for comparison in self.comparisons]

    def evaluate(self, hypothesis: Hypothesis) -> list[Evaluation]:
        """Return the residuals of each run with their noise, nuisance parameters marginalised."""
        sources = self.noises, self.clocks, self.factors, self.biases, self.white
        arguments = self.comparisons, *sources
        return map_runs(partial(_evaluate, hypothesis, self.reference), *arguments)

    def residuals_by_run(self, hypothesis: Hypothesis) -> list[Residuals]:
        """Return the whitened residuals of each run."""
        return [evaluation.whitened for evaluation in self.evaluate(hypothesis)]

    def whitened(self, hypothesis: Hypothesis) -> Floats:
        """Return all residuals, independent and of standard deviation 1, shape (n,)."""
        parts = [part for run in self.residuals_by_run(hypothesis) for part in run]
        return np.clip(np.concatenate(parts), -LARGEST, LARGEST)

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """Return the vector that a fit minimises, shape (n,); see :func:`loss`."""
        whitened = self.whitened(hypothesis)
        if self.cycles is None:
            return whitened
        return np.concatenate([whitened, self.cycles.residual(hypothesis)])

    def losses(self, hypothesis: Hypothesis) -> Floats:
        """Return the losses of independent stretches of the runs, shape (k,)."""
        losses = []
        for run in self.residuals_by_run(hypothesis):
            for whitened in run:
                each = pseudo_huber(np.clip(whitened, -LARGEST, LARGEST))
                losses += [float(part.sum()) for part in np.array_split(each, STRETCHES)]
        if self.cycles is not None:
            losses += self.cycles.losses(hypothesis).tolist()
        return np.array(losses)


def _evaluate(
    hypothesis: Hypothesis,
    reference: Hypothesis,
    comparison: Comparison,
    noise: NoiseModel,
    clock: Residuals,
    factors: Residuals,
    bias: Floats,
    white: Sequence[Floats],
) -> Evaluation:
    residuals = comparison.residuals(hypothesis)
    residuals = residuals._replace(force=residuals.force - bias)
    if comparison.run.has_nuisances:
        noise = noise.with_shared(clock)
        noise = noise.with_shared(temperature_columns(hypothesis, comparison, residuals))
    whitened = [z / f for z, f in zip(noise.whiten(residuals), factors, strict=True)]
    if _reading_side(hypothesis) != _reading_side(reference):  # most causes leave it as it is
        wider = _wider(hypothesis, comparison, noise, white)
        whitened = [z / w for z, w in zip(whitened, wider, strict=True)]
    return Evaluation(residuals, noise, Residuals(*whitened))


def _reading_side(hypothesis: Hypothesis) -> tuple[object, ...]:
    """Return what turns readings into gas sources."""
    return hypothesis.model.gas, hypothesis.model.cylinder, hypothesis.gains


def _wider(
    hypothesis: Hypothesis, comparison: Comparison, noise: NoiseModel, white: Sequence[Floats]
) -> Residuals:
    """
    Return by how much the noise is wider than under the hypothesis for which it was computed [-].

    Without it a hypothesis gains by what makes gas sources of the same readings small: a sensor of
    larger gain, less volume, warmer gas. Forces are left as they are: a mass so large that no
    acceleration shows would explain any of them.

    :param white: variances of the gas residuals by noise of the readings under that hypothesis
    """
    factors = []
    for chamber, (whiten, before) in enumerate(zip(noise[:2], white, strict=True), start=1):
        change = gas_variance(hypothesis, comparison, chamber) - before
        factors.append(np.sqrt(1.0 + change[whiten.kept] / whiten.deviation**2))
    ones = (np.ones(whiten.deviation.size) for whiten in noise[2:])
    return Residuals(*factors, *ones)


def by_balance(rows: Sequence[Residuals]) -> dict[str, Floats]:
    """Return balance -> whitened residuals of runs, (n,) each; the force has three kinds."""
    parts = {name: [getattr(row, name) for row in rows] for name in BALANCES}
    parts['force'] += [each for row in rows for each in (row.breakaway, row.stop)]
    return {name: np.concatenate(each) for name, each in parts.items()}


def rms(values: Floats) -> float:
    """Return the root mean square, 0 without values."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def pseudo_huber(whitened: Floats) -> Floats:
    """Return half the squares, growing linearly beyond ``OUTLIER`` [-]."""
    losses: Floats = OUTLIER**2 * (np.sqrt(1.0 + (whitened / OUTLIER) ** 2) - 1.0)
    return losses


def loss(residual: Floats) -> float:
    """Return the sum of the pseudo-Huber losses of residuals [-]."""
    return float(pseudo_huber(residual).sum())
