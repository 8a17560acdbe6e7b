"""Which candidates are worth a fit: how much of the gap each closes as it stands or scaled."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.gap.candidates import Candidate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Explanation, first_of_each
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode

Floats = NDArray[np.float64]

SHARES = np.linspace(0.1, 1.6, 16)
"""Shares of a candidate's change of the prediction that are tried [-]."""

KEPT_PAIRS = 4
"""Of so many pairs one is looked at more closely."""
CHUNK = 16
"""Pairs that are sent to a worker at once."""


class Screened(NamedTuple):
    """
    A candidate and what it may close.

    :param candidate: the candidate
    :param values: the start that did best, scaled where that is possible [SI]
    :param cost: expected from there [-]
    """

    candidate: Candidate
    values: tuple[float, ...]
    cost: float

    @property
    def worth_trying(self) -> tuple[tuple[float, ...], ...]:
        """Starts of a closer look: the best one; of a parameter larger and smaller values."""
        return (self.values,) if self.candidate.is_effect else self.candidate.starts


def screen(
    hypothesis: Hypothesis, pool: Sequence[Candidate], evidence: Evidence,
    modes: Sequence[Mode], executor: Executor,
) -> list[Screened]:  # fmt: skip
    """Return the candidates, the most promising first."""
    here = {mode: evidence.gaps(hypothesis, mode) for mode in modes}
    screened = map_tasks(executor, screen_one, pool, hypothesis, evidence, here)
    return sorted(screened, key=lambda one: one.cost)


def screen_one(
    candidate: Candidate, hypothesis: Hypothesis, evidence: Evidence,
    here: dict[Mode, list[Floats]],
) -> Screened:  # fmt: skip
    """Return what a candidate closes from the best of its starts."""
    tried = [try_start(hypothesis, candidate, s, evidence, here) for s in candidate.starts]
    return min(tried, key=lambda one: one.cost)


def try_start(
    hypothesis: Hypothesis, candidate: Candidate, start: tuple[float, ...], evidence: Evidence,
    here: dict[Mode, list[Floats]],
) -> Screened:  # fmt: skip
    """Return what a candidate closes from one start, its change scaled by the best share."""
    changed = candidate.apply(hypothesis, start)
    pairs = []
    for mode in here:
        there = evidence.gaps(changed, mode)
        pairs.append((_flat(here[mode]), _flat(there)))
    costs = [_cost(pairs, share) for share in SHARES]
    best = int(np.argmin(costs))
    return Screened(candidate, start, min(costs[best], _cost(pairs, 1.0)))


def _flat(gaps: list[Floats]) -> Floats:
    return np.concatenate([g.ravel() for g in gaps])


def _cost(pairs: list[tuple[Floats, Floats]], share: float) -> float:
    each = [np.mean(np.arcsinh(a + share * (b - a)) ** 2) for a, b in pairs]
    return float(np.mean(each))


def screen_pairs(
    given: Hypothesis, base: Explanation, effects: Sequence[Candidate], evidence: Evidence,
    modes: Sequence[Mode], executor: Executor,
) -> list[Explanation]:  # fmt: skip
    """
    Return an explanation with each of the most promising pairs of effects, the best one first.

    Two effects may close a gap that each of them alone makes larger. All are tried on the first
    experiment, and what looks well there on every one.
    """
    pairs = [
        base.plus(one, start).plus(other, second)
        for one, other in combinations(effects, 2)
        for start, second in product(one.starts, other.starts)
    ]
    first = evidence.subset([0])
    for some in (first, evidence):
        chunks = [pairs[start : start + CHUNK] for start in range(0, len(pairs), CHUNK)]
        every = map_tasks(executor, costs_of, chunks, given.roughly(), some, modes)
        costs = [cost for chunk in every for cost in chunk]
        order = np.argsort(costs, kind='stable')[: -(-len(pairs) // KEPT_PAIRS)]
        pairs = [pairs[index] for index in order]
    return first_of_each(pairs, lambda one: one)


def costs_of(
    explanations: Sequence[Explanation], given: Hypothesis, evidence: Evidence,
    modes: Sequence[Mode],
) -> list[float]:  # fmt: skip
    """Return the costs of some explanations as they stand."""
    return [evidence.cost(one.apply(given), modes) for one in explanations]
