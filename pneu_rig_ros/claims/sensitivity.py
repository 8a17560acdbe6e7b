"""How far each statement can be moved by one open quantity alone."""

from collections.abc import Callable, Iterator

import numpy as np

from pneu_rig_ros.claims.search import (
    CHOICES,
    LINEAR_RANGES,
    LOG_RANGES,
    Genes,
    Outcome,
    evaluate,
    worker_pool,
)

PLACES = 5
"""Places in its range at which each quantity is tried."""


def sensitivity(
    genes: Genes, workers: int, progress: Callable[[int], None] = lambda _: None
) -> dict[str, dict[int, float]]:
    """
    Vary one quantity at a time about a setting.

    :param genes: the setting
    :param workers: processes
    :param progress: told the number of settings done
    :returns: name of a quantity -> number of a statement -> largest margin reached [-]
    """
    names, settings = zip(*variations(genes), strict=True)
    best: dict[str, dict[int, float]] = {name: {} for name in names}
    with worker_pool(workers) as pool:
        outcomes = pool.map(evaluate, settings)
        for number, (name, outcome) in enumerate(zip(names, outcomes, strict=True), start=1):
            _keep_best(best[name], outcome)
            progress(number)
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
