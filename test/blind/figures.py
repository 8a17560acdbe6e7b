"""Shares, medians and pooled scores, each with its 95 % interval."""

from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binomtest, quantile_test

Figure = dict[str, Any]
"""``value``, ``trials``, and the bounds ``low`` and ``high``, all None of no trials."""


class Wanted(NamedTuple):
    """What a figure should be, ``at least`` or ``at most`` a bound, and what it is."""

    sense: str
    bound: float
    meaning: str


RESAMPLED, SEED = 2000, 1
DIGITS = 9
"""Decimals of a pooled score: Python 3.12 adds floats with other last digits than 3.11."""
NOTHING: Figure = {'value': None, 'trials': 0, 'low': None, 'high': None}


def as_wanted(
    at_least: Mapping[str, tuple[float, str]], at_most: Mapping[str, tuple[float, str]]
) -> dict[str, Wanted]:
    """Return figure -> what it should be, from bound and meaning of each."""
    return {
        **{name: Wanted('at least', *row) for name, row in at_least.items()},
        **{name: Wanted('at most', *row) for name, row in at_most.items()},
    }


def share(answers: Sequence[Any], good: Callable[[Any], bool]) -> Figure:
    """Return the share of the answers that are good, with Wilson's interval."""
    if not answers:
        return dict(NOTHING)
    count = sum(map(good, answers))
    bounds = binomtest(count, len(answers)).proportion_ci(method='wilson')
    return _figure(count / len(answers), len(answers), float(bounds.low), float(bounds.high))


def middle(values: Sequence[float], trials: int | None = None) -> Figure:
    """Return the median, with the interval of the binomial distribution of the values' ranks."""
    if not values:
        return dict(NOTHING)
    bounds = quantile_test(np.array(values), q=0.0, p=0.5).confidence_interval()
    # of few values no two ranks hold the median so surely: then all of them do not
    low, high = (float(b) if np.isfinite(b) else None for b in (bounds.low, bounds.high))
    return _figure(median(values), trials or len(values), low, high)


def pooled(rows: Sequence[Any], score: Callable[[Sequence[Any]], float | None]) -> Figure:
    """Return a score of all rows together, with the interval of samples drawn from them."""
    value = score(rows) if rows else None
    if value is None:
        return dict(NOTHING)
    random = np.random.default_rng(SEED)
    draws = [
        score([rows[i] for i in random.integers(len(rows), size=len(rows))])
        for _ in range(RESAMPLED)
    ]
    low, high = np.percentile([draw for draw in draws if draw is not None], (2.5, 97.5))
    value, low, high = (round(float(each), DIGITS) for each in (value, low, high))
    return _figure(value, len(rows), low, high)


def _figure(value: float, trials: int, low: float | None, high: float | None) -> Figure:
    return {'value': value, 'trials': trials, 'low': low, 'high': high}
