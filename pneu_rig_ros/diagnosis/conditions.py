"""Conditions that are not as stated, in the answer: what was stated, and what is true."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pneu_rig_ros.diagnosis.hypothesis import POSITION_ZERO, SENSOR_CLOCK
from pneu_rig_ros.diagnosis.restated import Restated
from pneu_rig_ros.model.parameters import Operation

DISPLAYED = {
    'supply_pressure': (1e-5, 'bar'),
    'load_mass': (1.0, 'kg'),
    POSITION_ZERO: (1e3, 'mm'),
    SENSOR_CLOCK: (1e3, 'ms'),
}
"""Condition -> factor on its SI value, unit for a reader."""


def fitted_row(
    name: str, value: float, interval: tuple[float, float], operations: Sequence[Operation]
) -> dict[str, Any]:
    """
    Return a condition whose value was fitted, as in diagnosis.json.

    :param value: ratio to what is stated [-], or the difference from zero [m, s]
    :param operations: conditions as stated, of the training data
    """
    is_ratio = name in Operation._fields
    stated = [float(getattr(each, name)) if is_ratio else 0.0 for each in operations]
    true = [value * each if is_ratio else each + value for each in stated]
    factor, unit = DISPLAYED[name]
    return {
        'name': name,
        'stated': _span([factor * each for each in stated], unit),
        'true': _span([factor * each for each in true], unit),
        'value': value,
        'interval': list(interval),
        'unit': '-' if is_ratio else {'mm': 'm', 'ms': 's'}[unit],
    }


def restated_row(restated: Restated) -> dict[str, Any]:
    """Return what is otherwise than stated as a whole, as in diagnosis.json."""
    stated, true = restated.stated, restated.true
    unknown: Mapping[str, Any] = {'value': None, 'interval': None, 'unit': ''}
    return {'name': restated.name, 'stated': stated, 'true': true, **unknown}


def sentence(row: Mapping[str, Any]) -> str:
    """Return a row in words."""
    return f'{row["name"]} {row["true"]}, stated {row["stated"]}'


def _span(values: Sequence[float], unit: str) -> str:
    """Return the values of all recordings for a reader."""
    texts = list(dict.fromkeys(f'{value:.3g}' for value in (min(values), max(values))))
    return f'{" to ".join(texts)} {unit}'
