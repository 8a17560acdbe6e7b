"""
Fit over the whole range of an explanation, where a fit from its starts ends in a false minimum.

Differential evolution (R. Storn, K. Price, J. Global Optim. 11 (1997) 341) from a Sobol sequence,
then least squares. Where slip follows slip, the cost has a valley for each number of slips; and
beside the best valley there may be a better one along one coordinate, so that hops follow.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.gap.candidates import Candidate
from pneu_rig_ros.gap.fitting import Explanation
from pneu_rig_ros.gap.scoring import Scored, Setting, cost_of, fit_from

Floats = NDArray[np.float64]

BEYOND = 3.0
"""The range reaches so many times beyond the starts of a part, either way [-]."""
POPULATION, GENERATIONS = 32, 8
"""Of the differential evolution; the population is a power of two, for the Sobol sequence."""
ROUNDS = 12
"""Of the least squares from the best that it finds."""
HOPS, HOPPING_ROUNDS = (1.0 / 3.0, 3.0), 8
"""Multiples of the distance from the null that each coordinate hops to, and rounds from there."""
MOST_HOPS, LEAST_GAIN = 2, 0.85
"""Times that all coordinates hop, as long as the cost falls below this share of it [-]."""


def fit_globally(
    starts: Sequence[Explanation], setting: Setting, own: int, executor: Executor
) -> list[Scored]:
    """
    Return explanations fitted over the range of their parts.

    :param starts: with the best values known so far
    :param own: parts at the front that keep their values until the least squares
    """
    fits = map_tasks(executor, evolved, starts, setting, own)
    hopping = list(range(len(fits)))
    for _ in range(MOST_HOPS):
        tried = [(index, hop) for index in hopping for hop in hops(fits[index], own)]
        landed = map_tasks(executor, fit_from, [hop for _, hop in tried], setting, HOPPING_ROUNDS)
        before = list(fits)
        for (index, _), one in zip(tried, landed, strict=True):
            fits[index] = min(fits[index], one, key=cost_of)
        hopping = [i for i in hopping if cost_of(fits[i]) <= LEAST_GAIN * cost_of(before[i])]
    return fits


def evolved(start: Explanation, setting: Setting, own: int) -> Scored:
    """
    Return the least-squares fit from the best of an evolution over the range.

    Every other experiment, roughly simulated, has to do for the evolution.
    """
    front = start.seen[: count_of(start, own)]
    first = start.seen[front.size :]
    low, high = np.concatenate([span(part) for part in start.parts[own:]], axis=1)
    low, high = np.minimum(low, first), np.maximum(high, first)
    half = setting.fitted.subset(range(0, len(setting.fitted.experiments), 2))
    given = setting.given.roughly()

    def at(seen: Floats) -> Explanation:
        return start.moved(np.concatenate([front, seen]))

    def cost(seen: Floats) -> float:
        return half.cost(at(seen).apply(given), setting.modes)

    points = qmc.Sobol(first.size, seed=0).random(POPULATION)
    population = low + points * (high - low)
    population[0] = first
    solution = differential_evolution(
        cost, list(zip(low, high, strict=True)), init=population, maxiter=GENERATIONS, tol=0.0,
        polish=False, seed=0,
    )  # fmt: skip
    return fit_from(at(solution.x), setting, ROUNDS)


def count_of(explanation: Explanation, own: int) -> int:
    """Return how many coordinates the parts at the front have."""
    return sum(len(part.coordinates) for part in explanation.parts[:own])


def hops(one: Scored, own: int) -> Iterator[Explanation]:
    """
    Yield a fitted explanation with one coordinate or the other much larger or smaller.

    :param own: parts at the front that stay
    """
    explanation = one.fit.explanation
    front = count_of(explanation, own)
    for index, coordinate in enumerate(explanation.coordinates[front:], start=front):
        for factor in HOPS:
            seen = explanation.seen
            seen[index] = coordinate.scaled(float(seen[index]), factor)
            yield explanation.moved(seen)


def span(part: Candidate) -> Floats:
    """Return from where to where a part is looked for, as the fit sees it, shape (2, n)."""
    ends = []
    for index, coordinate in enumerate(part.coordinates):
        starts = [start[index] for start in part.starts]
        if coordinate.logarithmic:
            ends.append((min(starts) / BEYOND, max(starts) * BEYOND))
        else:
            reach = max(abs(start - coordinate.null) for start in starts) * BEYOND
            ends.append((coordinate.null - reach, coordinate.null + reach))
    pairs = zip(part.coordinates, ends, strict=True)
    return np.array([[c.inward(low), c.inward(high)] for c, (low, high) in pairs]).T
