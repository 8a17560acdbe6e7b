"""
The latent input of a balance over time: what must be added so that the balance holds, smoothed.

The residuals of the windows are a Gaussian process with a Matern-3/2 covariance, observed through
the noise of the windows, whose covariance is known (C. E. Rasmussen, C. K. I. Williams, "Gaussian
Processes for Machine Learning", MIT Press 2006, Eq. 2.23-2.24 and 4.17): a model discrepancy
(M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425). Amplitude and time scale maximise
the marginal likelihood on a grid.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, cholesky, eigh, solve_triangular
from scipy.sparse import csr_array, diags_array

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.residuals.windows import Windows

MOST_GROUPS = 700
"""More windows are averaged in groups of neighbours: the algebra grows with the cube."""
AMPLITUDES = np.geomspace(0.3, 3.0, 8)
"""Amplitudes of the grid, in RMS of the residuals [-]."""
SHORTEST_SCALE = 0.05
"""Least time scale of the grid [s]."""
SCALES = 8
"""Time scales of the grid, up to the length of the recording."""
LEVEL_UNKNOWN = 10.0
"""Shared errors so many times as large as the residuals leave their level open [-]."""


@dataclass(frozen=True)
class Latent:
    """
    The latent input of a balance in one recording, in m groups of windows.

    :param time: middle of each group [s], shape (m,)
    :param mean, deviation: of the latent input, shape (m,)
    :param cleared: residuals less the estimated errors that windows share, shape (m,)
    :param covariance: of the errors that these still have, shape (m, m)
    :param average: maps values of the windows to means of the groups
    :param level: weights of the mean that is taken to be zero where the level is unknown, as is
        the zero of a bench: the mean of the means of both directions; shape (m,)
    :param direction: of the motion in the middle of each group, shape (m,)
    """

    time: Floats
    mean: Floats
    deviation: Floats
    cleared: Floats
    covariance: Floats
    average: csr_array
    level: Floats
    direction: NDArray[np.str_]

    def levelled(self, values: Floats) -> Floats:
        """Return values less their level where that is unknown, shape (m,)."""
        levelled: Floats = values - self.level @ values
        return levelled


def smooth(windows: Windows) -> Latent:
    """Return the latent input of the windows of one balance in one recording."""
    average = averaging(windows.residual.size)
    time, residual = average @ windows.middle, average @ windows.residual
    own, shared = group_noise(windows, average)
    process = matern(time, *maximum_likelihood(time, residual, own + shared))
    factor = cho_factor(process + own + shared, lower=True)
    mean = process @ cho_solve(factor, residual)
    posterior = process - process @ cho_solve(factor, process)
    cleared = residual - shared @ cho_solve(factor, residual)
    errors = own + shared - shared @ cho_solve(factor, shared)
    begins, level = average.indptr, np.zeros(time.size)
    direction = windows.direction[average.indices[(begins[:-1] + begins[1:]) // 2]]
    if np.trace(shared) > LEVEL_UNKNOWN**2 * (residual @ residual):
        names, which, counts = np.unique(direction, return_inverse=True, return_counts=True)
        level = 1.0 / (names.size * counts[which])
        cleared, errors = residual, own
    centre = np.eye(time.size) - level
    variance = np.diag(centre @ posterior @ centre.T)
    deviation = np.sqrt(np.maximum(variance, 0.0))
    covariance = centre @ errors @ centre.T
    smoothed = time, centre @ mean, deviation, centre @ cleared, covariance
    return Latent(*smoothed, average, level, direction)


def averaging(count: int) -> csr_array:
    """Return the matrix that averages groups of neighbours, single windows where they are few."""
    groups = np.arange(count) * min(count, MOST_GROUPS) // max(count, 1)
    sizes = np.bincount(groups)
    return csr_array((1.0 / sizes[groups], (groups, np.arange(count))))


def group_noise(windows: Windows, average: csr_array) -> tuple[Floats, Floats]:
    """Return the covariance of each group's own noise, and that of the shared errors."""
    band, size = windows.whiten.band, windows.residual.size
    lags = range(min(len(band), size))
    factor = diags_array([band[lag, : size - lag] for lag in lags], offsets=[-lag for lag in lags])
    inflated = average @ diags_array([windows.factor], offsets=[0])
    own = inflated @ factor.tocsr()
    shared = inflated @ windows.whiten.shared[windows.whiten.kept]
    return (own @ own.T).toarray(), shared @ shared.T


def matern(time: Floats, amplitude: float, scale: float) -> Floats:
    """Return the Matern-3/2 covariance at some times, shape (m, m)."""
    distance = np.sqrt(3.0) / scale * np.abs(time[:, np.newaxis] - time)
    covariance: Floats = amplitude**2 * (1.0 + distance) * np.exp(-distance)
    return covariance


def maximum_likelihood(time: Floats, residual: Floats, noise: Floats) -> tuple[float, float]:
    """
    Return the amplitude [unit of the residual] and time scale [s] of the largest likelihood.

    In the eigenvectors of the whitened process its amplitude only scales the eigenvalues.
    """
    factor = cholesky(noise, lower=True)
    unit = max(float(np.sqrt(np.mean(residual**2))), float(np.sqrt(noise.diagonal().min())))
    best = np.inf, 0.0, 1.0
    longest = max(float(np.ptp(time)), 2.0 * SHORTEST_SCALE)
    for scale in np.geomspace(SHORTEST_SCALE, longest, SCALES):
        half = solve_triangular(factor, matern(time, unit, scale), lower=True)
        values, vectors = eigh(solve_triangular(factor, half.T, lower=True))
        squares = (vectors.T @ solve_triangular(factor, residual, lower=True)) ** 2
        for amplitude in AMPLITUDES:
            variance = 1.0 + amplitude**2 * np.maximum(values, 0.0)
            cost = float(np.sum(np.log(variance) + squares / variance))
            best = min(best, (cost, float(amplitude) * unit, float(scale)))
    return best[1:]
