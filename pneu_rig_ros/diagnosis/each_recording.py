"""What differs from one recording to the next, as plain data for the answer."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from scipy.stats import norm

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.intervals import CONFIDENCE
from pneu_rig_ros.diagnosis.nuisances import CLOCK_OFFSET, INITIAL_TEMPERATURE
from pneu_rig_ros.diagnosis.workflow import Diagnosis


def each_recording(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return clock offset and temperatures at the start of each run under the answer."""
    search = diagnosis.search
    return [
        row
        for dataset in (search.fitted, search.held)
        for one in dataset.comparisons
        for row in _rows(dataset, one, diagnosis.improved)
    ]


def _rows(dataset: Dataset, one: Comparison, hypothesis: Hypothesis) -> Iterator[dict[str, Any]]:
    run, found = one.run, dataset.errors(hypothesis, one)
    if found is None:
        return
    names = (CLOCK_OFFSET, *(f'{INITIAL_TEMPERATURE}_{i}' for i in (1, 2)))
    allowed = [run.clock_offset > 0.0, *(
        run.temperature_offset > 0.0 and f'gas_{i}' in run.balances for i in (1, 2)
    )]  # fmt: skip
    values = (found.late, *found.temperatures)
    half = norm.ppf(0.5 + 0.5 * CONFIDENCE) * found.deviations
    for name, shown, value, off in zip(names, allowed, values, half.tolist(), strict=True):
        if shown:
            yield {'recording': run.name, 'name': name, 'value': value,
                   'interval': [value - off, value + off],
                   'unit': 's' if name == CLOCK_OFFSET else 'K'}  # fmt: skip
