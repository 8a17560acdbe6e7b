"""
Balances in weak form: averaged with smooth test functions, so that nothing is differentiated.

Of a rate dy/dt = s, what counts is the mean over a window with a weight phi that is zero, and
level, at both ends. By integration by parts the derivative then falls on phi, which is known
exactly::

    mean(phi dy/dt) = -mean(phi' y)

(D. A. Messenger, D. M. Bortz, J. Comput. Phys. 443 (2021) 110525, "weak SINDy"; for parameters
"WENDy", Bull. Math. Biol. 85 (2023) 110). White noise of y so becomes noise of known covariance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class TestFunctions:
    """
    Windows of equal length, one after the other.

    :param starts: first interval of each window, shape (m,)
    :param weights: of the middles of its intervals, sum 1, shape (w,)
    :param slope: weights of its samples whose sum is the mean of the derivative [1/s],
        shape (w + 1,)
    :param bend: the same for the second derivative [1/s^2], shape (w + 1,)
    """

    starts: Indices
    weights: Floats
    slope: Floats
    bend: Floats

    @classmethod
    def of(cls, power: int, size: int, hop: int, count: int, interval: float) -> TestFunctions:
        """
        Return the windows sin^power over ``size`` intervals, every ``hop`` of ``count``.

        :param interval: between samples [s]
        """
        middle = np.sin(np.pi * (np.arange(size) + 0.5) / size) ** power
        ends = np.sin(np.pi * np.arange(size + 1) / size) ** power / middle.sum()
        weights = middle / middle.sum()
        slope = -np.diff(np.concatenate([[0.0], weights, [0.0]])) / interval
        padded = np.concatenate([[0.0], ends, [0.0]])
        bend = np.diff(padded, 2) / interval**2
        starts = np.arange(0, max(count - size, 0) + 1, hop)
        return cls(starts, weights, slope, bend)

    @property
    def size(self) -> int:
        """Intervals of a window."""
        return self.weights.size

    def means(self, middles: Floats) -> Floats:
        """Return the weighted means of values at the middles of the intervals, shape (m,)."""
        means: Floats = self._windows(middles, self.size) @ self.weights
        return means

    def rates(self, samples: Floats) -> Floats:
        """Return the mean rates of a signal at the samples, shape (m,)."""
        rates: Floats = self._windows(samples, self.size + 1) @ self.slope
        return rates

    def accelerations(self, samples: Floats) -> Floats:
        """Return the mean second derivatives of a signal at the samples, shape (m,)."""
        bends: Floats = self._windows(samples, self.size + 1) @ self.bend
        return bends

    def inside(self, flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return the windows all of whose intervals are flagged, shape (m,)."""
        whole: NDArray[np.bool_] = self._windows(flags, self.size).all(axis=1)
        return whole

    def plain_means(self, middles: Floats) -> Floats:
        """Return the unweighted means, shape (m,)."""
        means: Floats = self._windows(middles, self.size).mean(axis=1)
        return means

    def _windows(self, values: Any, size: int) -> Any:
        if values.size < size:
            return np.empty((0, size), dtype=values.dtype)
        return sliding_window_view(values, size)[self.starts]


def correlation(weights: Floats, hop: int) -> Floats:
    """Return the correlation of white noise in windows 1, 2, ... hops apart, without the 0th."""
    whole = float(weights @ weights)
    lags = range(hop, weights.size, hop)
    return np.array([float(weights[lag:] @ weights[:-lag]) for lag in lags]) / whole
