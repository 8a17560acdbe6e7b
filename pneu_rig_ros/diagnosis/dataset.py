"""What a hypothesis is judged by: residuals of the weak form, and simulation from rest to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.balances import Comparison, Residuals
from pneu_rig_ros.diagnosis.cycles import Cycles
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.noise import NoiseModel, noise_model
from pneu_rig_ros.diagnosis.parallel import map_runs
from pneu_rig_ros.diagnosis.replicates import Spread, factors_of, spread, with_bias
from pneu_rig_ros.diagnosis.run_errors import (
    RunErrors,
    clock_column,
    estimated,
    in_time,
    start_columns,
)

Floats = NDArray[np.float64]

OUTLIER = 3.0
"""Standard deviations beyond which a residual counts linearly [-]."""
FAR = 1e4
"""Residuals are not taken to be farther off [-]."""
STRETCHES = 12
"""Pieces of a run whose losses are independent of each other."""


@dataclass(frozen=True)
class Dataset:
    """
    Runs with the noise of their residuals under one hypothesis.

    :param comparisons: the runs
    :param noises: of each
    :param spread: of the twins
    :param cycles: the simulated runs, None where simulation is no part of the dataset
    :param clocks: change of the residuals of each run by one standard deviation of its clock's
        offset, shape (m, 1) each
    """

    comparisons: tuple[Comparison, ...]
    noises: tuple[NoiseModel, ...]
    spread: Spread
    cycles: Cycles | None = None
    clocks: tuple[Residuals, ...] = ()

    @classmethod
    def of(
        cls, given: Hypothesis, comparisons: Sequence[Comparison], rng: np.random.Generator
    ) -> Dataset:
        """Return the runs with the noise that they have if the hypothesis is true."""
        count = len(comparisons)
        runs = tuple(map_runs(partial(in_time, given), comparisons, rng.spawn(count)))
        twins = spread(given, runs, rng)
        noises = map_runs(partial(noise_model, given), runs, rng.spawn(count))
        known = tuple(with_bias(*pair, twins.bias) for pair in zip(noises, runs, strict=True))
        clocks = tuple(map_runs(partial(clock_column, given), runs))
        return cls(runs, known, twins, clocks=clocks)

    def errors(self, hypothesis: Hypothesis, comparison: Comparison) -> RunErrors | None:
        """Return what one of the runs is off by under a hypothesis, None where it cannot be."""
        if not comparison.run.has_errors:
            return None
        index = [one is comparison for one in self.comparisons].index(True)
        return estimated(hypothesis, comparison, self.noises[index])

    def aligned(self, hypothesis: Hypothesis, comparison: Comparison) -> Comparison:
        """Return one of the runs without the errors that it has under a hypothesis."""
        found = self.errors(hypothesis, comparison)
        return comparison if found is None else Comparison(found.of(comparison.run))

    def noises_under(self, hypothesis: Hypothesis) -> list[NoiseModel]:
        """Return the noise of each run, with its errors as unknowns of their own."""
        of_each = map_runs(partial(_under, hypothesis), *self._runs)
        return [noise for _, noise in of_each]

    @property
    def _runs(self) -> tuple[Sequence[Comparison], Sequence[NoiseModel], Sequence[Residuals]]:
        return self.comparisons, self.noises, self.clocks

    def simulated(self, hypothesis: Hypothesis, rng: np.random.Generator) -> Dataset:
        """Return the dataset with simulation, spread as if the hypothesis were true."""
        return replace(self, cycles=Cycles.of(hypothesis, self.comparisons, rng))

    def wider(self, by: Dataset, hypothesis: Hypothesis) -> Dataset:
        """
        Return the dataset if what a hypothesis leaves of some runs is discrepancy of any model.

        :param by: dataset of the runs that say how much that is, balance by balance
        """
        runs = by.of_each(hypothesis)
        gas_1, gas_2, force, breakaway = (
            max(rms(np.concatenate([getattr(run, name) for run in runs])), 1.0)
            for name in Residuals._fields
        )
        old = self.spread
        return replace(self, spread=old._replace(
            gas_1=old.gas_1 * gas_1, gas_2=old.gas_2 * gas_2,
            force=tuple(force * one for one in old.force), breakaway=old.breakaway * breakaway,
        ))  # fmt: skip

    @cached_property
    def factors(self) -> list[Residuals]:
        """By how much wider than the noise each window of each run spreads [-]."""
        pairs = zip(self.comparisons, self.noises, strict=True)
        return [factors_of(self.spread, one, noise) for one, noise in pairs]

    def of_each(self, hypothesis: Hypothesis) -> list[Residuals]:
        """Return the whitened residuals of each run."""
        return map_runs(partial(_whitened, hypothesis), *self._runs, self.factors)

    def whitened(self, hypothesis: Hypothesis) -> Floats:
        """Return all residuals, independent and of standard deviation 1, shape (n,)."""
        parts = [part for run in self.of_each(hypothesis) for part in run]
        return np.clip(np.concatenate(parts), -FAR, FAR)

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """Return what a fit makes small, shape (n,); see :func:`loss`."""
        whitened = self.whitened(hypothesis)
        if self.cycles is None:
            return whitened
        return np.concatenate([whitened, self.cycles.residual(hypothesis)])

    def losses(self, hypothesis: Hypothesis) -> Floats:
        """Return the losses of independent stretches of the runs, shape (k,)."""
        parts = []
        for run in self.of_each(hypothesis):
            for whitened in run:
                pieces = np.array_split(huber(np.clip(whitened, -FAR, FAR)), STRETCHES)
                parts += [float(piece.sum()) for piece in pieces]
        if self.cycles is not None:
            parts += self.cycles.losses(hypothesis).tolist()
        return np.array(parts)


def _under(
    hypothesis: Hypothesis, one: Comparison, noise: NoiseModel, clock: Residuals
) -> tuple[Residuals, NoiseModel]:
    """Return residuals and noise of a run."""
    here = one.residuals(hypothesis)
    if one.run.has_errors:
        noise = noise.with_common(clock)
        noise = noise.with_common(start_columns(hypothesis, one, here))
    return here, noise


def _whitened(
    hypothesis: Hypothesis, one: Comparison, noise: NoiseModel, clock: Residuals,
    factors: Residuals,
) -> Residuals:  # fmt: skip
    here, noise = _under(hypothesis, one, noise, clock)
    return Residuals(*(z / f for z, f in zip(noise.whiten(here), factors, strict=True)))


def rms(values: Floats) -> float:
    """Return the root of the mean square, 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def huber(whitened: Floats) -> Floats:
    """Return half the squares, growing linearly beyond ``OUTLIER`` (pseudo-Huber) [-]."""
    scaled = (whitened / OUTLIER) ** 2
    losses: Floats = OUTLIER**2 * (np.sqrt(1.0 + scaled) - 1.0)
    return losses


def loss(residual: Floats) -> float:
    """Return the sum of the losses of residuals [-]."""
    return float(huber(residual).sum())
