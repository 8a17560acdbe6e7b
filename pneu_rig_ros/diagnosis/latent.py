"""
The latent input of a balance over time: what must be added so that it holds, smoothed.

The residuals of the windows are a Gaussian process with a Matern-3/2 covariance, seen through the
noise of the windows, whose covariance is known (C. E. Rasmussen, C. K. I. Williams, "Gaussian
Processes for Machine Learning", MIT Press 2006, Eq. 2.23-2.24 and 4.17; as what a model lacks
M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425). Its amplitude and time scale are the
most likely ones of a grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, cholesky, eigh, solve_triangular
from scipy.sparse import csr_array, diags_array

from pneu_rig_ros.diagnosis.localisation import Windows

Floats = NDArray[np.float64]

MOST = 700
"""More windows are averaged in groups of neighbours."""
AMPLITUDES = np.geomspace(0.3, 3.0, 8)
"""Of the process in RMS of the residuals [-]."""
SHORTEST = 0.05
"""Least time scale [s]."""
SCALES = 8
"""Time scales of the grid, up to the length of the recording."""
UNKNOWN = 10.0
"""Errors in common so many times the residuals say nothing of their level [-]."""


@dataclass(frozen=True)
class Latent:
    """
    The latent input of a balance in one recording, in m groups of windows.

    :param time: middle of each group [s], shape (m,)
    :param mean, deviation: of the latent input, shape (m,)
    :param cleared: residuals less the likely errors that windows have in common, shape (m,)
    :param covariance: of the errors that these still have, shape (m, m)
    :param average: makes means of the groups of what is known of each window
    :param level: weights of the mean that is taken to be zero where the level is not known, that
        of a bench's zero: the mean of the means of both directions; shape (m,)
    """

    time: Floats
    mean: Floats
    deviation: Floats
    cleared: Floats
    covariance: Floats
    average: csr_array
    level: Floats

    def levelled(self, values: Floats) -> Floats:
        """Return values less their level where that is not known, shape (m,)."""
        lower: Floats = values - self.level @ values
        return lower

    @cached_property
    def members(self) -> NDArray[np.intp]:
        """The window in the middle of each group, shape (m,)."""
        return members(self.average)


def smooth(windows: Windows) -> Latent:
    """Return the latent input of the windows of one balance in one recording."""
    average = averaging(windows.residual.size)
    time, residual = average @ windows.middle, average @ windows.residual
    own, shared = noise_of(windows, average)
    process = matern(time, *likeliest(time, residual, own + shared))
    factor = cho_factor(process + own + shared, lower=True)
    mean = process @ cho_solve(factor, residual)
    left = process - process @ cho_solve(factor, process)
    cleared = residual - shared @ cho_solve(factor, residual)
    errors = own + shared - shared @ cho_solve(factor, shared)
    level = np.zeros(time.size)
    if np.trace(shared) > UNKNOWN**2 * (residual @ residual):
        level, cleared, errors = level_of(windows.direction[members(average)]), residual, own
    centre = np.eye(time.size) - level
    deviation = np.sqrt(np.maximum(np.diag(centre @ left @ centre.T), 0.0))
    return Latent(time, centre @ mean, deviation, centre @ cleared, centre @ errors @ centre.T,
                  average, level)  # fmt: skip


def members(average: csr_array) -> NDArray[np.intp]:
    """Return the window in the middle of each group."""
    begins = average.indptr
    return np.asarray(average.indices[(begins[:-1] + begins[1:]) // 2], dtype=np.intp)


def level_of(direction: NDArray[np.str_]) -> Floats:
    """Return the weights of the mean of the means of all directions, shape (m,)."""
    names, which, counts = np.unique(direction, return_inverse=True, return_counts=True)
    weights: Floats = 1.0 / (names.size * counts[which])
    return weights


def averaging(count: int) -> csr_array:
    """Return the matrix that averages groups of neighbours, one each where there are few."""
    groups = np.arange(count) * min(count, MOST) // max(count, 1)
    sizes = np.bincount(groups)
    return csr_array((1.0 / sizes[groups], (groups, np.arange(count))))


def noise_of(windows: Windows, average: csr_array) -> tuple[Floats, Floats]:
    """Return the covariance of each group's own noise, and of the errors in common."""
    band, size = windows.whiten.band, windows.residual.size
    lags = range(min(len(band), size))
    factor = diags_array([band[lag, : size - lag] for lag in lags], offsets=[-lag for lag in lags])
    wider = average @ diags_array([windows.factor], offsets=[0])
    own = wider @ factor.tocsr()
    shared = wider @ windows.whiten.shared[windows.whiten.kept]
    return (own @ own.T).toarray(), shared @ shared.T


def matern(time: Floats, amplitude: float, scale: float) -> Floats:
    """Return the covariance of a process with continuous slope, shape (m, m)."""
    apart = np.sqrt(3.0) / scale * np.abs(time[:, np.newaxis] - time)
    covariance: Floats = amplitude**2 * (1.0 + apart) * np.exp(-apart)
    return covariance


def likeliest(time: Floats, residual: Floats, noise: Floats) -> tuple[float, float]:
    """Return the amplitude [unit of the residual] and time scale [s] of the largest likelihood."""
    factor = cholesky(noise, lower=True)
    rms = max(float(np.sqrt(np.mean(residual**2))), float(np.sqrt(noise.diagonal().min())))
    best = np.inf, 0.0, 1.0
    for scale in np.geomspace(SHORTEST, max(float(np.ptp(time)), 2.0 * SHORTEST), SCALES):
        half = solve_triangular(factor, matern(time, rms, scale), lower=True)
        values, vectors = eigh(solve_triangular(factor, half.T, lower=True))
        squares = (vectors.T @ solve_triangular(factor, residual, lower=True)) ** 2
        for amplitude in AMPLITUDES:
            total = 1.0 + amplitude**2 * np.maximum(values, 0.0)
            cost = float(np.sum(np.log(total) + squares / total))
            best = min(best, (cost, float(amplitude) * rms, float(scale)))
    return best[1:]
