"""
Balances in weak form: averaged with smooth test functions, so that no signal is differentiated.

The mean of a rate dy/dt over a window is weighted with a test function phi that vanishes, with its
slope, at both ends. Integration by parts moves the derivative to phi, which is known exactly::

    mean(phi dy/dt) = -mean(phi' y)

(D. A. Messenger, D. M. Bortz, J. Comput. Phys. 443 (2021) 110525, "weak SINDy"; for parameters
"WENDy", Bull. Math. Biol. 85 (2023) 110). White noise of y becomes noise of known covariance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pneu_rig_ros.arrays import Flags, Floats, Indices


@dataclass(frozen=True)
class TestFunctions:
    """
    Windows of equal length at equal distances, with the weights of a test function.

    :param starts: first interval of each window, shape (m,)
    :param hop: intervals from one window to the next
    :param weights: of the middles of the intervals, sum 1, shape (w,)
    :param slope: of the samples, for the mean derivative [1/s], shape (w + 1,)
    :param curvature: of the samples, for the mean second derivative [1/s^2], shape (w + 1,)
    """

    starts: Indices
    hop: int
    weights: Floats
    slope: Floats
    curvature: Floats

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
        curvature = np.diff(np.concatenate([[0.0], ends, [0.0]]), 2) / interval**2
        starts = np.arange(0, max(count - size, 0) + 1, hop)
        return cls(starts, hop, weights, slope, curvature)

    @property
    def size(self) -> int:
        """Intervals of a window."""
        return self.weights.size

    def means(self, middles: Floats) -> Floats:
        """Return the weighted means of values at the middles of the intervals, shape (m,)."""
        means: Floats = self._windows(middles, self.size) @ self.weights
        return means

    def rates(self, samples: Floats) -> Floats:
        """Return the mean rates of a sampled signal, shape (m,)."""
        rates: Floats = self._windows(samples, self.size + 1) @ self.slope
        return rates

    def accelerations(self, samples: Floats) -> Floats:
        """Return the mean second derivatives of a sampled signal, shape (m,)."""
        accelerations: Floats = self._windows(samples, self.size + 1) @ self.curvature
        return accelerations

    def averages(self, middles: Floats) -> Floats:
        """Return the unweighted means of values at the middles, shape (m,)."""
        averages: Floats = self._windows(middles, self.size).mean(axis=1)
        return averages

    def inside(self, flags: Flags) -> Flags:
        """Return the windows all of whose intervals are flagged, shape (m,)."""
        whole: Flags = self._windows(flags, self.size).all(axis=1)
        return whole

    def correlation(self, weights: Floats) -> Floats:
        """Return the correlation of white noise, weighted so, in windows 1, 2, ... apart."""
        lags = range(self.hop, weights.size, self.hop)
        shared = [float(weights[lag:] @ weights[:-lag]) for lag in lags]
        return np.array(shared) / float(weights @ weights)

    def _windows(self, values: Any, size: int) -> Any:
        if values.size < size:
            return np.empty((0, size), dtype=values.dtype)
        return sliding_window_view(values, size)[self.starts]


def middles(samples: Floats) -> Floats:
    """Return the means of neighbouring samples, shape (n - 1,) or (n - 1, k)."""
    means: Floats = 0.5 * (samples[1:] + samples[:-1])
    return means


def at_samples(middles: Floats) -> Floats:
    """Return values at the samples between, before and after some middles, shape (n,), (n, k)."""
    between = 0.5 * (middles[1:] + middles[:-1])
    return np.concatenate([middles[:1], between, middles[-1:]])
