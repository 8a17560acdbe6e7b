"""By how much recordings of a system differ from its model, and from each other; their rows."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.diagnosis.answer.intervals import HALF_WIDTH
from pneu_rig_ros.diagnosis.answer.random_effects import (
    Information,
    RandomEffects,
    random_effects,
    two_sided,
)
from pneu_rig_ros.diagnosis.answer.run_differences import (
    FEWEST_OTHERS,
    changes,
    key_of,
    scale_at,
    varying_quantities,
)
from pneu_rig_ros.diagnosis.causes.candidates import Candidate
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.nuisances import (
    CLOCK_OFFSET,
    FORCE_OFFSET,
    INITIAL_TEMPERATURE,
)
from pneu_rig_ros.diagnosis.residuals.windows import BREAKAWAY, windows_of
from pneu_rig_ros.rig.configuration import REPEATABILITY


class Variation(NamedTuple):
    """
    How recordings differ from each other.

    :param recordings: their names
    :param quantities: that differ
    :param effects: by how much [internal units]
    """

    recordings: Sequence[str]
    quantities: Sequence[Candidate]
    effects: RandomEffects

    @property
    def spreads(self) -> dict[str, float]:
        """Name of each quantity -> its standard deviation between the recordings [SI]."""
        pairs = zip(self.quantities, self.effects.spreads.tolist(), strict=True)
        return {key_of(quantity): scale_at(quantity) * spread for quantity, spread in pairs}

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the quantities of each recording, as in diagnosis.json."""
        _, *columns = self.effects
        for recording, *row in zip(self.recordings, *columns, strict=True):
            for quantity, value, deviation, p_value in zip(self.quantities, *row, strict=True):
                half = HALF_WIDTH * deviation
                yield {
                    'recording': recording,
                    'name': key_of(quantity),
                    'value': stated(quantity, value),
                    'interval': [stated(quantity, value - half), stated(quantity, value + half)],
                    'p_value': float(p_value),
                    'unit': REPEATABILITY[key_of(quantity)].unit,
                }


def nuisance_rows(hypothesis: Hypothesis, dataset: Dataset) -> Iterator[dict[str, Any]]:
    """Yield the nuisance parameters of each run, as in diagnosis.json."""
    names = CLOCK_OFFSET, f'{INITIAL_TEMPERATURE}_1', f'{INITIAL_TEMPERATURE}_2'
    for data in dataset.runs:
        run, estimate = data.comparison.run, data.nuisances(hypothesis)
        if estimate is None:
            continue
        warm = run.temperature_sd > 0.0
        used = run.delay_sd > 0.0, *(warm and f'gas_{i}' in run.balances for i in (1, 2))
        shown = np.flatnonzero(used).tolist()
        values, deviations = estimate.values[shown], estimate.deviations[shown]
        p_values = two_sided(values - estimate.prior[shown], deviations)
        half = HALF_WIDTH * deviations
        columns = (each.tolist() for each in (values, values - half, values + half, p_values))
        for i, value, low, high, p_value in zip(shown, *columns, strict=True):
            yield {
                'recording': run.name,
                'name': names[i],
                'value': value,
                'interval': [low, high],
                'p_value': p_value,
                'unit': 's' if names[i] == CLOCK_OFFSET else 'K',
            }


def stated(quantity: Candidate, value: float) -> float:
    """Return an internal value as a ratio to that of the model or as a difference from it."""
    (c,) = quantity.coordinates
    return math.exp(value) if c.logarithmic else c.scale * value


def variation(
    hypothesis: Hypothesis, runs: Sequence[Dataset], candidates: Sequence[Candidate]
) -> Variation:
    """
    Return the quantities that differ between runs more than their residuals explain.

    :param runs: of one recording each; of fewer than four the spread is hardly known
    :param candidates: whose conditions and parameters of friction are the quantities
    """
    names = [run.comparisons[0].run.name for run in runs]
    quantities = [each for each in varying_quantities(candidates) if key_of(each) in REPEATABILITY]
    if len(runs) <= FEWEST_OTHERS or not quantities:
        none = np.zeros((len(runs), 0))
        return Variation(names, [], RandomEffects(none[0], none, none, none))
    residuals = [run.whitened(hypothesis) for run in runs]
    columns = [
        np.column_stack([changes(each, hypothesis, run, residual) for each in quantities])
        for run, residual in zip(runs, residuals, strict=True)
    ]
    data = Information.of(residuals, columns)
    found = random_effects(data.only(data.determined))
    differs = found.spreads > 0.0
    shown = [quantities[i] for i in np.flatnonzero(data.determined)[differs]]
    return Variation(names, shown, RandomEffects(*(each[..., differs] for each in found)))


def repeatability(
    system: System,
    improved: Hypothesis,
    datasets: Sequence[Dataset],
    spreads: Mapping[str, float],
) -> dict[str, float]:
    """
    Return balance -> standard deviation of the residuals beyond their noise [unit].

    What the system had before is part of it.

    :param spreads: of quantities between the recordings, which are part of it, too
    """
    groups = [each for data in datasets for each in windows_of(data, improved)]
    deviations = dict(system.repeatability)
    for balance in dict.fromkeys(group.balance for group in groups):
        # breakaways, single numbers, and readings at stops are groups of their own
        own = [g for g in groups if g.balance == balance and not g.at_stops]
        own = [group for group in own if set(group.regime) != {BREAKAWAY}]
        if not own:
            continue
        # the zero of a bench is unknown
        offset = balance == 'force' and FORCE_OFFSET in system.each_recording
        left = [g.residual - (g.residual.mean() if offset else 0.0) for g in own]
        squares = np.mean(np.concatenate(left) ** 2)
        noise = np.mean(np.concatenate([group.deviation**2 for group in own]))
        before = deviations.get(balance, 0.0)
        deviations[balance] = float(np.sqrt(before**2 + max(squares - noise, 0.0)))
    for name, spread in spreads.items():
        both = float(np.hypot(deviations.get(name, 0.0), spread))
        deviations[name] = REPEATABILITY[name].within(both)
    return {name: value for name, value in deviations.items() if value > 0.0}
