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
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, Comparison, Residuals, side_by_side
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
from pneu_rig_ros.diagnosis.residuals.replicates import (
    Inflation,
    estimate_inflation,
    speed_and_direction,
)
from pneu_rig_ros.executor import map_threads

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
class RunData:
    """
    A run with the noise of its residuals under one hypothesis.

    :param reference: that hypothesis
    :param comparison: the run
    :param noise: of its residuals
    :param inflation: of the noise, by replicates
    :param clock: change of the residuals by one standard deviation of the delay, (m, 1) each
    """

    reference: Hypothesis
    comparison: Comparison
    noise: NoiseModel
    inflation: Inflation
    clock: Residuals

    @cached_property
    def factors(self) -> Residuals:
        """Inflation of the noise in each kept window [-]."""
        return self.inflation.of_windows(self.comparison, self.noise)

    @cached_property
    def bias(self) -> Floats:
        """Mean force residual of a true model in each window [N], shape (m,)."""
        return self.inflation.shift[speed_and_direction(self.comparison)]

    @cached_property
    def white(self) -> list[Floats]:
        """Variances of the gas residuals by noise of the readings [kg^2/s^2]."""
        return [gas_variance(self.reference, self.comparison, chamber) for chamber in (1, 2)]

    def nuisances(self, hypothesis: Hypothesis) -> RunNuisances | None:
        """Return the nuisance parameters under a hypothesis, None where there are none."""
        if not self.comparison.run.has_nuisances:
            return None
        by_rates = estimate_nuisances(hypothesis, self.comparison, self.noise)
        return fitted_to_pressures(hypothesis, self.comparison, by_rates)

    def aligned(self, hypothesis: Hypothesis) -> Comparison:
        """Return the run, corrected for its nuisance parameters under a hypothesis."""
        estimate = self.nuisances(hypothesis)
        if estimate is None:
            return self.comparison
        return Comparison(estimate.correct(self.comparison.run))

    def evaluate(self, hypothesis: Hypothesis) -> Evaluation:
        """Return the residuals with their noise, nuisance parameters marginalised."""
        residuals, noise = self.comparison.residuals(hypothesis), self.noise
        residuals = residuals._replace(force=residuals.force - self.bias)
        if self.comparison.run.has_nuisances:
            temperatures = temperature_columns(hypothesis, self.comparison, residuals)
            noise = noise.with_shared(side_by_side(self.clock, temperatures))
        pairs = zip(noise.whiten(residuals), self.factors, strict=True)
        whitened = Residuals(*(z / factor for z, factor in pairs))
        if _reading_side(hypothesis) != _reading_side(self.reference):  # most causes leave it
            gas_1, gas_2 = (z / w for z, w in zip(whitened, self._wider(hypothesis), strict=False))
            whitened = whitened._replace(gas_1=gas_1, gas_2=gas_2)
        return Evaluation(residuals, noise, whitened)

    def _wider(self, hypothesis: Hypothesis) -> list[Floats]:
        """
        Return by how much the noise of the gas is wider than under the reference [-].

        Without it a hypothesis gains by what makes gas sources of the same readings small: a
        sensor of larger gain, less volume, warmer gas. Forces are left as they are: a mass so
        large that no acceleration shows would explain any of them.
        """
        factors = []
        for chamber, (whiten, before) in enumerate(zip(self.noise, self.white, strict=False), 1):
            change = gas_variance(hypothesis, self.comparison, chamber) - before
            factors.append(np.sqrt(1.0 + change[whiten.kept] / whiten.deviation**2))
        return factors


def _reading_side(hypothesis: Hypothesis) -> tuple[object, ...]:
    """Return what turns readings into gas sources."""
    return hypothesis.model.gas, hypothesis.model.cylinder, hypothesis.gains


@dataclass(frozen=True)
class Dataset:
    """
    Runs with the noise of their residuals under one hypothesis.

    :param cycles: the simulated cycles, None where simulation is not used
    """

    runs: tuple[RunData, ...]
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
        count, aligning = len(comparisons), partial(without_nuisances, hypothesis)
        aligned = map_threads(aligning, comparisons, rng.spawn(count))
        copies = COPIES if inflation is None else REPLICATE_COPIES
        known = inflation or estimate_inflation(hypothesis, aligned, rng)

        def with_noise(run: Comparison, rng: Generator) -> RunData:
            noise = noise_model(hypothesis, run, rng, copies)
            noise = known.with_bias(noise.with_shared(varying_columns(hypothesis, run)), run)
            return RunData(hypothesis, run, noise, known, clock_column(hypothesis, run))

        return cls(tuple(map_threads(with_noise, aligned, rng.spawn(count))))

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """The runs."""
        return tuple(run.comparison for run in self.runs)

    @property
    def inflation(self) -> Inflation:
        """Inflation of the noise, that of all runs."""
        return self.runs[0].inflation

    def with_cycles(self, hypothesis: Hypothesis, rng: Generator, free: bool = False) -> Dataset:
        """Return the dataset with cycles, or free runs, spread as if the hypothesis were true."""
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
        return [Dataset((run,)) for run in self.runs]

    def with_discrepancy(self, other: Dataset, hypothesis: Hypothesis) -> Dataset:
        """
        Return the dataset with a noise as wide as the residuals of a hypothesis.

        :param other: whose residuals give the width, balance by balance
        """
        columns = zip(*other.residuals_by_run(hypothesis), strict=True)
        pairs = zip(self.inflation.factors, columns, strict=True)
        factors = (old * max(rms(np.concatenate(column)), 1.0) for old, column in pairs)
        wider = self.inflation._replace(factors=Residuals(*factors))
        return replace(self, runs=tuple(replace(run, inflation=wider) for run in self.runs))

    def evaluate(self, hypothesis: Hypothesis) -> list[Evaluation]:
        """Return the residuals of each run with their noise, nuisance parameters marginalised."""
        return map_threads(lambda run: run.evaluate(hypothesis), self.runs)

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
