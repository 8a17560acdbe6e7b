"""Conditions that are not as stated, in the answer: what was stated, and what is true."""

from collections.abc import Mapping, Sequence
from typing import Any

from pneu_rig_ros.diagnosis.causes.candidates import CONDITIONS
from pneu_rig_ros.diagnosis.measured.hypothesis import POSITION_ZERO, SENSOR_CLOCK
from pneu_rig_ros.model.parameters import Operation

DISPLAYED = {
    'supply_pressure': (1e-5, 'bar'),
    'load_mass': (1.0, 'kg'),
    POSITION_ZERO: (1e3, 'mm'),
    SENSOR_CLOCK: (1e3, 'ms'),
}
"""Condition -> factor on its SI value, unit for a reader."""


def condition_row(
    cause: str, estimate: Mapping[str, Any], operations: Sequence[Operation]
) -> dict[str, Any]:
    """
    Return a condition whose value was fitted, as in diagnosis.json.

    :param cause: its name among the candidates
    :param estimate: value, interval and unit of the ratio to what is stated, or of the difference
        from zero
    :param operations: conditions as stated, of the training data
    """
    name, value = cause.removeprefix(CONDITIONS), estimate['value']
    if name in Operation._fields:
        stated = [float(getattr(each, name)) for each in operations]
        true = [value * each for each in stated]
    else:
        stated, true = [0.0], [value]
    return {'name': name, 'stated': _span(stated, name), 'true': _span(true, name), **estimate}


def _span(values: Sequence[float], name: str) -> str:
    """Return the values [SI] of a condition in all recordings for a reader."""
    factor, unit = DISPLAYED[name]
    texts = [f'{factor * value:.3g}' for value in (min(values), max(values))]
    return f'{" to ".join(dict.fromkeys(texts))} {unit}'
