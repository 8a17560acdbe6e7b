"""
Random effects: quantities that differ from recording to recording, around a common value.

The residuals of each recording are linear in its quantities. Their standard deviations maximise
the likelihood with the values of the recordings marginalised; the values are the posterior means,
shrunk towards the common one (N. M. Laird, J. H. Ware, Biometrics 38 (1982) 963).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtr

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.diagnosis.residuals.localisation import NOISE_ERROR
from pneu_rig_ros.diagnosis.search.empirical import robust_weights

LEAST_GAIN = 2.7
"""
What the log likelihood gains by the spread of a quantity that is kept, at least [-]: 1 % for a
variance of zero, which is at the end of its range (half of a chi-square of one degree).
"""
LINEAR = 0.1
"""
Up to there residuals are taken to be linear [internal units; of a ratio, 10 %]. It is the standard
deviation of the common values before the data, and what a recording alone has to determine.
"""
LARGEST_RATIO = 100.0
"""Of a variance to that of the values that each recording alone shows [-]."""
START = 0.5
"""Ratio from which the variances are sought [-]."""
TINY = 1e-12
"""Least variance that is sought [internal units squared]."""


class Information(NamedTuple):
    """
    What recordings say about k quantities: of each g'b - b'Ab/2, the log likelihood of values b.

    :param gradients: g, shape (recordings, k)
    :param curvatures: A, shape (recordings, k, k)
    """

    gradients: Floats
    curvatures: Floats

    @property
    def determined(self) -> Flags:
        """Whether each recording alone determines a quantity within ``LINEAR``, shape (k,)."""
        own = np.diagonal(self.curvatures, axis1=1, axis2=2)
        determined: Flags = own.min(axis=0) > 1.0 / LINEAR**2
        return determined

    def only(self, chosen: Flags) -> Information:
        """Return what they say about the chosen quantities if the others are as in the model."""
        return Information(self.gradients[:, chosen], self.curvatures[:, chosen][:, :, chosen])

    @classmethod
    def of(cls, residuals: Sequence[Floats], changes: Sequence[Floats]) -> Information:
        """
        Return what whitened residuals say.

        :param residuals: of each recording, shape (n,) each
        :param changes: their derivatives by the quantities, shape (n, k) each
        """
        gradients, curvatures = [], []
        for residual, change in zip(residuals, changes, strict=True):
            weighted = robust_weights(residual)[:, np.newaxis] * change
            gradient, curvature = -weighted.T @ residual, weighted.T @ change
            left = residual + change @ np.linalg.pinv(curvature, hermitian=True) @ gradient
            excess = max(float(np.mean(robust_weights(left) * left**2)), NOISE_ERROR**2)
            gradients.append(gradient / excess)
            curvatures.append(curvature / excess)
        return cls(np.array(gradients), np.array(curvatures))


class RandomEffects(NamedTuple):
    """
    How k quantities differ between recordings.

    :param spreads: standard deviations between the recordings, 0 of quantities that do not differ,
        shape (k,)
    :param values: in each recording, of quantities that differ, shape (recordings, k)
    :param deviations: standard deviations of the values, shape (recordings, k)
    :param p_values: that a recording alone is like the model, shape (recordings, k)
    """

    spreads: Floats
    values: Floats
    deviations: Floats
    p_values: Floats


class Marginal(NamedTuple):
    """
    Values of recordings and their common ones, given the variances between the recordings.

    :param log_likelihood: of the variances, up to a constant [-]
    :param means: the common values, shape (k,)
    :param mean_covariance: of these, shape (k, k)
    :param covariances: of the values about these, shape (recordings, k, k)
    """

    log_likelihood: float
    means: Floats
    mean_covariance: Floats
    covariances: Floats

    @classmethod
    def of(cls, data: Information, variances: Floats) -> Marginal:
        """Return what follows from variances, shape (k,)."""
        (g, a), root, unit = data, np.sqrt(variances), np.eye(variances.size)
        inner = unit + root[:, np.newaxis] * a * root
        covariances = root[:, np.newaxis] * np.linalg.inv(inner) * root
        left = unit - a @ covariances
        precision = unit / LINEAR**2 + np.sum(left @ a, axis=0)
        towards = np.einsum('rij,rj->i', left, g)
        means = np.linalg.solve(precision, towards)
        squares = float(np.einsum('ri,rij,rj->', g, covariances, g) + means @ towards)
        sizes = np.linalg.slogdet(inner)[1].sum() + np.linalg.slogdet(precision)[1]
        return cls(0.5 * (squares - float(sizes)), means, np.linalg.inv(precision), covariances)


def random_effects(data: Information) -> RandomEffects:
    """
    Return by how much quantities differ; those that do not are as in the model, without a spread.

    Quantities that act alike compete: the one whose spread gains least is dropped first.
    """
    active = list(range(data.gradients.shape[1]))
    variances = _likeliest(data, active)
    while active:
        smaller = [_likeliest(data, [q for q in active if q != dropped]) for dropped in active]
        largest = Marginal.of(data, variances).log_likelihood
        gains = [largest - Marginal.of(data, each).log_likelihood for each in smaller]
        least = int(np.argmin(gains))
        if gains[least] >= LEAST_GAIN:
            break
        variances, active = smaller[least], [q for i, q in enumerate(active) if i != least]
    differs, shape = variances > 0.0, data.gradients.shape
    effects = RandomEffects(np.zeros(shape[1]), np.zeros(shape), np.zeros(shape), np.ones(shape))
    # common values of the others, if estimated too, would bias those that differ
    own = data.only(differs)
    found = _shrunk(own, _likeliest(own, range(int(differs.sum()))))
    for whole, part in zip(effects, found, strict=True):
        whole[..., differs] = part
    return effects


def _likeliest(data: Information, active: Sequence[int]) -> Floats:
    """Return the likeliest variances, shape (k,), zero but for the active quantities."""
    variances = np.zeros(data.gradients.shape[1])
    if not active:
        return variances
    index = list(active)
    own = np.diagonal(data.curvatures, axis1=1, axis2=2)[:, index]
    single = np.divide(data.gradients[:, index], own, out=np.zeros_like(own), where=own > 0.0)
    scale = np.maximum(np.var(single, axis=0), TINY)

    def cost(ratios: Floats) -> float:
        variances[index] = ratios * scale
        return -Marginal.of(data, variances).log_likelihood

    bounds = [(0.0, LARGEST_RATIO)] * len(index)
    found = minimize(cost, np.full(len(index), START), method='L-BFGS-B', bounds=bounds)
    variances[index] = found.x * scale
    return variances


def _shrunk(data: Information, variances: Floats) -> RandomEffects:
    """Return the values of the recordings and their errors under some variances."""
    marginal, (g, a) = Marginal.of(data, variances), data
    left = np.eye(variances.size) - marginal.covariances @ a
    values = left @ marginal.means + np.einsum('rij,rj->ri', marginal.covariances, g)
    covariances = marginal.covariances + left @ marginal.mean_covariance @ left.swapaxes(1, 2)
    deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    alone = np.linalg.inv(a)  # not shrunk: a test of one recording ignores the others
    errors = np.sqrt(np.diagonal(alone, axis1=1, axis2=2))
    p_values = two_sided(np.einsum('rij,rj->ri', alone, g), errors)
    return RandomEffects(np.sqrt(variances), values, deviations, p_values)


def two_sided(differences: Floats, deviations: Floats) -> Floats:
    """Return the p-values [-] of differences with normal errors of these standard deviations."""
    p_values: Floats = 2.0 * ndtr(-np.abs(differences) / deviations)
    return p_values
