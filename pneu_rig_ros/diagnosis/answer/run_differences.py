"""
Recordings that differ from the others: the machine or its surroundings changed, not the model.

Each quantity is estimated in each recording alone, by one Gauss-Newton step. A recording is
compared with what the others predict, whose spread maximises the restricted likelihood (J. P. T.
Higgins, S. G. Thompson, D. J. Spiegelhalter, J. R. Stat. Soc. A 172 (2009) 137).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import false_discovery_control, t

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.answer.intervals import CONFIDENCE
from pneu_rig_ros.diagnosis.causes.candidates import (
    CONDITIONS,
    FORCE,
    PARAMETER_RATIO,
    Candidate,
    Coordinate,
    Explanation,
)
from pneu_rig_ros.diagnosis.inputs.system import value_of
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.residuals.localisation import (
    FALSE_DISCOVERY_RATE,
    NOISE_ERROR,
    localise,
)
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.diagnosis.search.empirical import robust_weights
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, STEP, fit
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE, LITTLE_LEFT, remaining_share
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.model.quantity import Quantity

FEWEST_OTHERS = 3
"""Recordings with which one is compared: the spread of fewer is hardly known."""


@dataclass(frozen=True)
class FrictionLevel(Candidate):
    """The level of friction, Coulomb and breakaway force, relative to the model's."""

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis with both forces multiplied."""
        return hypothesis.with_friction_level(values[0])


CHANGING = 'friction.coulomb_force', 'friction.breakaway_force', 'friction.viscous_coefficient'
"""Parameters that may change from recording to recording, as conditions do."""
RATIO = Quantity('-', 1.0 / PARAMETER_RATIO, PARAMETER_RATIO, "times the model's")
LEVEL = FrictionLevel(
    CONDITIONS + 'friction_level',
    FORCE,
    (Coordinate('times', RATIO, RATIO.low, RATIO.high, 1.0, True, 1.0),),
    ((1.0,),),
)
"""What wear, lubrication and warmth change."""


@dataclass(frozen=True)
class RunDifference:
    """
    A quantity in which a recording differs from the others.

    :param recording: its name
    :param quantity: a parameter, or a condition
    :param difference: from the mean of the others [unit]
    :param interval: of 95 % of the difference, with the spread of the others [unit]
    :param spread: standard deviation between the others [unit]
    :param p_value: of the difference
    """

    recording: str
    quantity: Candidate
    difference: float
    interval: tuple[float, float]
    spread: float
    p_value: float

    @property
    def unit(self) -> str:
        """Unit of the difference; '-' of a ratio to what was stated."""
        return self.quantity.coordinates[0].quantity.unit

    def to_dict(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        return {
            'recording': self.recording,
            'name': self.quantity.name,
            'difference': self.difference,
            'interval': list(self.interval),
            'spread': self.spread,
            'p_value': self.p_value,
            'unit': self.unit,
        }


def run_differences(
    hypothesis: Hypothesis,
    runs: Sequence[Dataset],
    candidates: Sequence[Candidate],
    executor: Executor,
    earlier: Mapping[str, float],
) -> dict[int, RunDifference]:
    """
    Return the runs that differ from the others, each with the quantity that shows it best.

    Of the runs with significant residuals, and of all quantities, the false-discovery rate is
    controlled.

    :param runs: of one recording each
    :param candidates: whose conditions and parameters of friction are the quantities
    :param earlier: quantity -> standard deviation between earlier recordings, with which it is
        compared where there are too few others
    """
    odd = [i for i, run in enumerate(runs) if localise(windows_of(run, hypothesis))]
    if not odd or (len(runs) <= FEWEST_OTHERS and not earlier):
        return {}
    quantities = varying_quantities(candidates)
    base = [run.whitened(hypothesis) for run in runs]
    results = map_tasks(executor, estimates, quantities, hypothesis, runs, base)
    tests = [
        (i, test)
        for quantity, (values, variances) in zip(quantities, results, strict=True)
        for i, test in _tests(quantity, hypothesis, runs, values, variances, earlier)
        if i in odd
    ]
    rates = false_discovery_control([test.p_value for _, test in tests]) if tests else []
    best: dict[int, RunDifference] = {}
    for (i, test), rate in zip(tests, rates, strict=True):
        clearest = i not in best or test.p_value < best[i].p_value
        if rate < FALSE_DISCOVERY_RATE and clearest:
            best[i] = test
    return best


def sufficient_differences(search: Search, earlier: Mapping[str, float]) -> list[RunDifference]:
    """
    Return the differences between runs if these are all that is wrong, else none.

    The other runs agree with the given model, and no cause that acts in all runs explains as much.

    :param earlier: see :func:`run_differences`
    """
    runs = search.initial.single_runs
    found = run_differences(search.given, runs, search.pool, search.executor, earlier)
    others = [run for i, run in enumerate(runs) if i not in found]
    if not found or len(others) < (1 if earlier else FEWEST_OTHERS):
        return []
    if localise([each for run in others for each in windows_of(run, search.given)]):
        return []
    left = sum(loss(run.whitened(search.given)) for run in others)
    for i, difference in found.items():
        quantity = difference.quantity
        start = Explanation(search.given).with_part(quantity, quantity.starts[0])
        fitted = fit(start, runs[i], ROUNDS)
        if remaining_share(runs[i], search.given, fitted.hypothesis) > LITTLE_LEFT:
            return []
        left += fitted.loss
    everywhere = sum(loss(run.whitened(search.hypothesis)) for run in runs)
    return list(found.values()) if everywhere - left > DECISIVE else []


def estimates(
    quantity: Candidate, hypothesis: Hypothesis, runs: Sequence[Dataset], base: Sequence[Floats]
) -> tuple[Floats, Floats]:
    """
    Return by how much a quantity differs in each run, and its variance, infinite if it is unseen.

    :param base: whitened residuals of each run
    :returns: in internal units of the quantity [-], shape (runs,) each
    """
    values, variances = np.zeros(len(runs)), np.full(len(runs), np.inf)
    for i, (run, residual) in enumerate(zip(runs, base, strict=True)):
        change, weights = changes(quantity, hypothesis, run, residual), robust_weights(residual)
        information = float(np.sum(weights * change**2))
        if information > 0.0:
            values[i] = -float(np.sum(weights * change * residual)) / information
            excess = float(np.mean(weights * residual**2))
            variances[i] = max(excess, NOISE_ERROR**2) / information
    return values, variances


def _tests(
    quantity: Candidate,
    hypothesis: Hypothesis,
    runs: Sequence[Dataset],
    values: Floats,
    variances: Floats,
    earlier: Mapping[str, float],
) -> Iterator[tuple[int, RunDifference]]:
    """
    Yield the test of each run against the others that show the quantity.

    :param earlier: standard deviations between earlier recordings, those of the hypothesis
    """
    factor, shows = scale_at(quantity, value_in(quantity, hypothesis)), np.isfinite(variances)
    for i in np.flatnonzero(shows).tolist():
        others = shows & (np.arange(shows.size) != i)
        if others.sum() >= FEWEST_OTHERS:
            spread = spread_between(values[others], variances[others])
            weights = 1.0 / (variances[others] + spread**2)
            expected, uncertain = weights @ values[others] / weights.sum(), 1.0 / weights.sum()
            freedom = float(others.sum() - 1)
        elif (known := earlier.get(key_of(quantity))) is not None:
            spread, expected, uncertain, freedom = known / scale_at(quantity), 0.0, 0.0, np.inf
        else:
            continue
        difference = float(values[i] - expected)
        error = float(np.sqrt(variances[i] + spread**2 + uncertain))
        p_value = 2.0 * float(t.sf(abs(difference) / error, freedom))
        half = float(t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * error
        low, size, high, spread = (
            factor * each for each in (difference - half, difference, difference + half, spread)
        )
        name = runs[i].comparisons[0].run.name
        yield i, RunDifference(name, quantity, size, (low, high), spread, p_value)


def spread_between(values: Floats, variances: Floats) -> float:
    """Return the standard deviation between values that are known to some variances."""

    def negative_log(spread: float) -> float:
        weights = 1.0 / (variances + spread**2)
        squares = weights @ (values - weights @ values / weights.sum()) ** 2
        return float(0.5 * (squares - np.log(weights).sum() + np.log(weights.sum())))

    widest = float(np.ptp(values))
    if widest <= 0.0:
        return 0.0
    best = float(minimize_scalar(negative_log, bounds=(0.0, widest), method='bounded').x)
    return best if negative_log(best) < negative_log(0.0) else 0.0


def varying_quantities(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the quantities among candidates that may change from recording to recording."""
    quantities = {c.name: c for c in candidates if c.is_condition or c.name in CHANGING}
    if any(quantity.group == FORCE for quantity in quantities.values()):
        quantities[LEVEL.name] = LEVEL
    return list(quantities.values())


def key_of(quantity: Candidate) -> str:
    """Return the name of a quantity without its section."""
    return quantity.name.split('.')[-1]


def changes(quantity: Candidate, hypothesis: Hypothesis, run: Dataset, residual: Floats) -> Floats:
    """
    Return the derivative of the whitened residuals of a run by a quantity, shape (n,).

    :param residual: they themselves
    """
    value = value_in(quantity, hypothesis)
    moved = quantity.apply(hypothesis, (value + STEP * scale_at(quantity, value),))
    derivative: Floats = (run.whitened(moved) - residual) / STEP
    return derivative


def value_in(quantity: Candidate, hypothesis: Hypothesis) -> float:
    """Return the value of a quantity in a hypothesis [unit]."""
    if quantity.is_condition:
        return hypothesis.conditions.get(
            quantity.name.removeprefix(CONDITIONS), quantity.coordinates[0].null
        )
    return value_of(hypothesis.model, quantity.name)


def scale_at(quantity: Candidate, value: float = 1.0) -> float:
    """
    Return by how much a quantity changes with its internal value, at some value [unit].

    Without one it is the unit of the internal value: 1 for a ratio, to the first order.
    """
    (c,) = quantity.coordinates
    return value if c.logarithmic else c.scale
