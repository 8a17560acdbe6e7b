"""Which effects are worth a fit: how much of the gap each closes along with the parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.gap.candidates import Candidate
from pneu_rig_ros.gap.fitting import Explanation
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.parts.evidence import STEP, PartEvidence

Floats = NDArray[np.float64]

SHARES = (0.3, 3.0)
"""Multiples of a start's change of the prediction that are held to be possible [-]."""
STARTS = 2
"""Starts that are kept of each effect."""
APART = 1.5
"""Factor by which one of the values of two starts differs at least [-]."""


@dataclass(frozen=True)
class PartScreened:
    """A candidate effect, its best starts, and the gap in noises to expect from the first."""

    candidate: Candidate
    starts: tuple[tuple[float, ...], ...]
    gap: float


def screen(
    evidence: PartEvidence, base: Explanation, pool: Sequence[Candidate],
    tell: Callable[[str], None], executor: Executor,
) -> list[PartScreened]:  # fmt: skip
    """Return the effects, the most promising first, each seen with the parameters moving along."""
    hypothesis = base.apply(evidence.part.hypothesis)
    here = evidence.residual(hypothesis)
    slopes = _slopes(evidence, base, here)
    tell(f'screening {len(pool)} effects')
    screened = map_tasks(executor, screen_one, pool, evidence, hypothesis, here, slopes)
    return sorted(screened, key=lambda one: one.gap)


def screen_one(
    candidate: Candidate, evidence: PartEvidence, hypothesis: Hypothesis, here: Floats,
    slopes: Floats,
) -> PartScreened:  # fmt: skip
    """Return an effect with its best starts."""
    tried = []
    for start in candidate.starts:
        change = evidence.residual(candidate.apply(hypothesis, start)) - here
        gap, share = _expected(here, slopes, change)
        tried.append((gap, _strengthened(candidate, start, share)))
    tried.sort()
    return PartScreened(candidate, _apart([s for _, s in tried]), tried[0][0])


def _slopes(evidence: PartEvidence, base: Explanation, here: Floats) -> Floats:
    """Return how the residual changes with what an explanation has, shape (n, coordinates)."""
    columns = [np.zeros((here.size, 0))]
    seen = base.seen
    for index in range(seen.size):
        high = base.coordinates[index].bounds[1]
        there = seen.copy()
        there[index] += STEP if seen[index] + STEP < high else -STEP
        moved = base.moved(there).apply(evidence.part.hypothesis)
        change = evidence.residual(moved) - here
        columns.append((change / (there[index] - seen[index]))[:, np.newaxis])
    return np.hstack(columns)


def _expected(here: Floats, slopes: Floats, change: Floats) -> tuple[float, float]:
    """Return the gap to expect, and how many times the change brings it there."""
    both = np.column_stack([slopes, change])
    share = float(np.linalg.lstsq(both, -here, rcond=None)[0][-1])
    share = min(max(share, SHARES[0]), SHARES[1])
    shifted = here + share * change
    if slopes.shape[1]:
        shifted = shifted + slopes @ np.linalg.lstsq(slopes, -shifted, rcond=None)[0]
    return float(np.linalg.norm(shifted)), share


def _strengthened(one: Candidate, start: Sequence[float], share: float) -> tuple[float, ...]:
    """Return a start with its strengths multiplied; what is no strength stays."""
    pairs = zip(one.coordinates, start, strict=True)
    return tuple(
        min(max(value * (share if c.null == 0.0 else 1.0), c.quantity.low), c.quantity.high)
        for c, value in pairs
    )


def _apart(starts: Sequence[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Return the first starts that differ from one another."""
    kept: list[tuple[float, ...]] = []
    for start in starts:
        if all(_differ(start, other) for other in kept):
            kept.append(start)
    return tuple(kept[:STARTS])


def _differ(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    for a, b in zip(one, other, strict=True):
        if a * b <= 0.0:
            if a != b:
                return True
        elif max(a / b, b / a) > APART:
            return True
    return False
