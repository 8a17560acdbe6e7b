"""Recordings of a part, the gap of a hypothesis on them, and fits to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.fitting import Explanation, Fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.parts.part import Part
from pneu_rig_ros.gap.parts.prediction import Channel, compare
from pneu_rig_ros.gap.parts.recording import COMPARED, Recording

Floats = NDArray[np.float64]

STEP = 1e-2
"""Step of the finite differences, in units of a coordinate [-]."""
EDGE = 1e-6
"""How far inside its bounds a fit starts [-]."""


@dataclass(frozen=True)
class PartEvidence:
    """
    Recordings of a part.

    :param part: the given part
    :param recordings: measured runs
    :raises RigError: when a signal that is compared never changes, so that its noise is unknown
    """

    part: Part
    recordings: Sequence[Recording]

    def __post_init__(self) -> None:
        for one in self.recordings:
            for name in COMPARED[self.part.kind]:
                if one.noise.get(name) == 0.0:
                    raise RigError(
                        f'{one.name}: {name} never changes: its noise is unknown; leave it out'
                    )

    def channels(self, hypothesis: Hypothesis) -> list[list[Channel]]:
        """Return measured less predicted of every signal of each recording."""
        return [compare(self.part, hypothesis, recording) for recording in self.recordings]

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """
        Return the gaps in noises, weighted so that their square sum is a mean square, shape (n,).

        Each recording, signal and regime counts the same.
        """
        rows = []
        for recording, channels in zip(self.recordings, self.channels(hypothesis), strict=True):
            for one in channels:
                said = np.isfinite(one.gap)
                weights = recording.weights[said] / recording.weights[said].sum()
                scaled = one.gap[said] / one.noise[said] * np.sqrt(weights / len(channels))
                rows.append(np.nan_to_num(scaled, nan=1e6, posinf=1e6, neginf=-1e6))
        every: Floats = np.concatenate(rows) / np.sqrt(len(self.recordings))
        return every

    def level(self, hypothesis: Hypothesis) -> float:
        """Return the root of the mean square gap in noises [-], 1 for a true hypothesis."""
        return float(np.linalg.norm(self.residual(hypothesis)))

    def fit(self, given: Hypothesis, start: Explanation, rounds: int) -> Fit:
        """Return the explanation fitted from a start, its cost the mean square gap."""
        low, high = np.array([one.bounds for one in start.coordinates]).T

        def residual(seen: Floats) -> Floats:
            return self.residual(start.moved(seen).apply(given))

        def slopes(seen: Floats) -> Floats:
            here, columns = residual(seen), []
            for index in range(seen.size):
                there = seen.copy()
                there[index] += STEP if seen[index] + STEP < high[index] else -STEP
                columns.append((residual(there) - here) / (there[index] - seen[index]))
            return np.column_stack(columns)

        first = np.clip(start.seen, low + EDGE, high - EDGE)
        solution = least_squares(
            residual, first, jac=slopes, bounds=(low, high), max_nfev=rounds, xtol=1e-4,
            ftol=1e-3, gtol=1e-8,
        )  # fmt: skip
        deviations = _deviations(solution, self._samples(start.moved(solution.x).apply(given)))
        return Fit(start.moved(solution.x), 2.0 * float(solution.cost), deviations)

    def _samples(self, hypothesis: Hypothesis) -> int:
        """Return how many independent samples there are, as a gap that is left drifts slowly."""
        return sum(
            _independent(one.gap[np.isfinite(one.gap)])
            for channels in self.channels(hypothesis)
            for one in channels
        )


def _independent(gap: Floats) -> int:
    """Return the number of independent samples by the time in which a gap forgets itself."""
    centred = gap - gap.mean()
    power = np.abs(np.fft.rfft(centred, 2 * centred.size)) ** 2
    memory = np.fft.irfft(power)[: centred.size]
    if memory[0] <= 0.0:
        return gap.size
    falls = np.flatnonzero(memory < memory[0] / np.e)
    return max(gap.size // (2 * int(falls[0])) if falls.size else 1, 1)


def _deviations(solution: Any, samples: int) -> Floats:
    """Return standard deviations of the coordinates from the curvature at the solution."""
    jacobian, spare = solution.jac, max(samples - solution.x.size, 1)
    covariance = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    variance = float(solution.fun @ solution.fun) / spare
    deviations: Floats = np.sqrt(np.maximum(np.diag(covariance) * variance, 0.0))
    return deviations
