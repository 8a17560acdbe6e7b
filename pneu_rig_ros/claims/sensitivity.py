"""How far each statement can be moved by one open quantity alone."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from pneu_rig_ros.claims.findings import Statement
from pneu_rig_ros.claims.search import (
    CHEAPEST_FIRST,
    CHOICES,
    LINEAR_RANGES,
    LOG_RANGES,
    Genes,
    Outcome,
    evaluate,
)
from pneu_rig_ros.executor import Executor, map_tasks

PLACES = 5
"""Places in its range at which each quantity is tried."""


def sensitivity(
    genes: Genes, executor: Executor, progress: Callable[[int], None] = lambda _: None,
    statements: Sequence[Statement] = CHEAPEST_FIRST,
) -> dict[str, dict[int, float]]:  # fmt: skip
    """
    Vary one quantity at a time about a setting.

    :param genes: the setting
    :param executor: where settings are measured
    :param progress: told the number of settings done
    :param statements: that are measured
    :returns: name of a quantity -> number of a statement -> largest margin reached [-]
    """
    names, settings = zip(*variations(genes), strict=True)
    best: dict[str, dict[int, float]] = {name: {} for name in names}
    outcomes = map_tasks(executor, evaluate, settings, -np.inf, statements, progress=progress)
    for name, outcome in zip(names, outcomes, strict=True):
        _keep_best(best[name], outcome)
    return best


def variations(genes: Genes) -> Iterator[tuple[str, Genes]]:
    """Yield the name of a quantity and the setting with another value of it."""
    for name in (*LOG_RANGES, *LINEAR_RANGES):
        for place in np.linspace(0.0, 1.0, PLACES):
            yield name, genes | {name: float(place)}
    for name, size in CHOICES.items():
        for index in range(size):
            yield name, genes | {name: index}


def _keep_best(best: dict[int, float], outcome: Outcome) -> None:
    for number, margin in outcome.margins.items():
        best[number] = max(margin, best.get(number, -1.0))
