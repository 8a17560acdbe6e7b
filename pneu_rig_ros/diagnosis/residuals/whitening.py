"""
Whitening of residuals whose covariance is known.

The windows of a balance form a chain: neighbours that overlap are correlated (a banded matrix).
Nuisance parameters, errors that many windows share, add a few directions (a matrix of low rank).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky_banded, solve_banded

from pneu_rig_ros.arrays import Flags, Floats

NOT_FINITE = 1e4
"""Residual of a window in which a hypothesis yields no finite value [standard deviations]."""
NUGGET = 0.02
"""
White share added to a variance [-]: without it the sum of all windows, which is the difference of
two readings, would have a smaller error than any model.
"""


@dataclass(frozen=True)
class Whitener:
    """
    The covariance of the residuals of one balance in one run.

    :param kept: windows that are used, shape (m,)
    :param deviation: standard deviation of each kept residual, shape (kept,)
    :param band: Cholesky factor of the covariance of the kept ones, lower banded form
    :param shared: effect of one standard deviation of each nuisance parameter, shape (m, k)
    """

    kept: Flags
    deviation: Floats
    band: Floats
    shared: Floats

    def __call__(self, residual: Floats) -> Floats:
        """Return the kept residuals, independent and of standard deviation 1, shape (kept,)."""
        values = residual[self.kept]
        return self.columns(np.where(np.isfinite(values), values, NOT_FINITE * self.deviation))

    def columns(self, values: Floats) -> Floats:
        """Return finite kept residuals whitened, shape (kept,) or (kept, k) for k of them."""
        if not values.size:
            return values
        whitened = self._own(values)
        directions, shrinkage = self._shared
        both: Floats = whitened - directions @ (shrinkage * (directions.T @ whitened).T).T
        return both

    @cached_property
    def _shared(self) -> tuple[Floats, Floats]:
        """Whitened directions of the shared errors, and by how much each is shrunk."""
        own = self._own(self.shared[self.kept])
        directions, scale, _ = np.linalg.svd(own, full_matrices=False)
        return directions, 1.0 - 1.0 / np.sqrt(1.0 + scale**2)

    def _own(self, values: Floats) -> Floats:
        """Return kept residuals, shape (kept,) or (kept, k), whitened for their own noise."""
        whitened: Floats = solve_banded((self.band.shape[0] - 1, 0), self.band, values)
        return whitened

    def with_shared(self, columns: Floats) -> Whitener:
        """
        Return the whitener with more nuisance parameters.

        :param columns: effect of one standard deviation of each on all windows, shape (m, k)
        """
        return replace(self, shared=np.hstack([self.shared, columns]))


@dataclass(frozen=True)
class Source:
    """
    Noise of one kind.

    :param variance: of each window, shape (m,)
    :param lags: correlation of windows 1, 2, ... apart [-]
    """

    variance: Floats
    lags: Floats = field(default_factory=lambda: np.zeros(0))


def whitener(kept: Flags, sources: Sequence[Source], excess: Floats) -> Whitener:
    """
    Return the whitener of a chain of windows.

    :param sources: noise in closed form
    :param excess: variance of uncorrelated errors, shape (m,)
    """
    where = np.flatnonzero(kept)
    closed = sum((source.variance[where] for source in sources), np.zeros(where.size))
    total, most = closed + excess[where], max((each.lags.size for each in sources), default=0)
    band = np.zeros((most + 1, where.size))
    band[0] = total + NUGGET * closed
    for source in sources:
        deviation = np.sqrt(source.variance[where])
        for lag, correlation in enumerate(source.lags, start=1):
            # windows that were dropped between two kept ones separate them
            neighbours = where[lag:] - where[:-lag] == lag
            covariance = correlation * deviation[lag:] * deviation[:-lag]
            band[lag, : max(where.size - lag, 0)] += np.where(neighbours, covariance, 0.0)
    factor = cholesky_banded(band, lower=True) if where.size else band
    return Whitener(kept, np.sqrt(total), factor, np.zeros((kept.size, 0)))
