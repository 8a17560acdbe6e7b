"""
The conditions under which a bag was recorded: what its signals do not say.

They are looked up one by one, first in ``conditions.yaml`` beside the bag's data (of a text table
``daq.csv`` in ``daq.conditions.yaml``), then in the bag's metadata ``conditions``, then in the rig
configuration that the bag holds. The model keeps its own values for all others.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import cast

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import Gas
from pneu_rig_ros.model.quantity import Quantity, mapping_of, specifications
from pneu_rig_ros.records.bag import folder_of
from pneu_rig_ros.records.recording import SIGNALS, WHOLE
from pneu_rig_ros.records.units import DEFAULT_ATMOSPHERE, convert
from pneu_rig_ros.rig.configuration import (
    OVERRIDES,
    RigConfiguration,
    load_configuration,
    override,
)
from pneu_rig_ros.rig.yaml_file import parse_yaml, read_text, shipped, to_yaml

FILE_NAME = 'conditions.yaml'
"""In the bag's directory."""

_ATMOSPHERE = 'atmospheric_pressure'

CONDITIONS: dict[str, Quantity] = {
    'supply_pressure': OVERRIDES['supply_pressure'],
    'load_mass': OVERRIDES['load_mass'],
    _ATMOSPHERE: cast(Quantity, specifications(Gas)[_ATMOSPHERE]),
    'rest_time': OVERRIDES['rest_time'],
}
"""Name -> unit, range and meaning; pressures absolute."""

BEYOND = 0.25
"""How far beyond the end stops a position may be, as a share of the stroke [-]."""
LEAST, MOST = 0.5, 5.0
"""Of absolute pressures: in pressures of the surroundings, and of the supply [-]."""


def conditions_of(
    path: Path | str, configuration: RigConfiguration | None, metadata: Mapping[str, str]
) -> dict[str, float]:
    """
    Return the conditions of a run that are known, SI units, absolute pressures.

    :param path: the bag's directory, a file in it, or a text table
    :param configuration: the rig, where the bag holds it
    :return: name of :data:`CONDITIONS` -> value
    :raises RigError: when a source holds anything else
    """
    found = configured_conditions(configuration) if configuration else {}
    if text := metadata.get('conditions'):
        found |= parse_conditions(text, f'{path}: metadata conditions')
    return found | conditions_beside(path)


def configured_conditions(configuration: RigConfiguration) -> dict[str, float]:
    """Return the conditions in the configuration of a rig."""
    values = configuration.model.operation._asdict() | configuration.model.gas._asdict()
    return {name: values[name] for name in CONDITIONS}


def conditions_beside(path: Path | str) -> dict[str, float]:
    """Return the conditions in the file beside the data, {} without one."""
    path = Path(path)
    folder = folder_of(path)
    file = folder / FILE_NAME if folder else path.with_suffix(f'.{FILE_NAME}')
    return read_conditions(file) if file.exists() else {}


def with_zero(conditions: Mapping[str, float], zero: float | None) -> dict[str, float]:
    """
    Return the conditions of a run whose gauge pressures were counted from ``zero`` [Pa].

    :param zero: None where there were none
    :raises RigError: when the conditions have another atmospheric pressure
    """
    given = conditions.get(_ATMOSPHERE, zero)
    if zero is not None and given != zero:
        raise RigError(
            f'the gauge pressures were counted from {zero:g} Pa, but the conditions '
            f'say atmospheric_pressure: {given:g} Pa; give one of them'
        )
    return dict(conditions) if zero is None else {**conditions, _ATMOSPHERE: zero}


def apply_conditions(
    configuration: RigConfiguration, conditions: Mapping[str, float]
) -> RigConfiguration:
    """
    Return the configuration of a rig under other conditions.

    :param conditions: name of :data:`CONDITIONS` -> value in SI units; others stay
    :raises RigError: for another name, or a value out of range
    """
    known = mapping_of(dict(conditions), CONDITIONS, 'conditions')
    checked = {n: CONDITIONS[n].check(value, f'conditions: {n}') for n, value in known.items()}
    if (surroundings := checked.pop(_ATMOSPHERE, None)) is not None:
        configuration = configuration.with_parameter('gas', _ATMOSPHERE, surroundings)
    return override(configuration, checked)


def read_conditions(path: Path | str) -> dict[str, float]:
    """Read a conditions file; see :func:`parse_conditions`."""
    return parse_conditions(read_text(path), str(path))


def parse_conditions(text: str, origin: str) -> dict[str, float]:
    """
    Read conditions such as ``supply_pressure: 5e5 Pa`` or ``supply_pressure: 4 bar gauge``.

    A gauge pressure counts from the ``atmospheric_pressure`` of the same text, else from 1e5 Pa.

    :param origin: what to call the text in an error
    :return: name of :data:`CONDITIONS` -> value in SI units, pressures absolute
    :raises RigError: for an unknown name, a wrong unit or a value out of range
    """
    data = parse_yaml(text, origin)
    data = mapping_of({} if data is None else data, CONDITIONS, origin)
    values: dict[str, float] = {}
    # The atmosphere first, as the zero of the others' gauge pressures.
    for key in sorted(data, key=lambda name: name != _ATMOSPHERE):
        quantity, where = CONDITIONS[key], f'{origin}: {key}'
        zero = None if key == _ATMOSPHERE else values.get(_ATMOSPHERE, DEFAULT_ATMOSPHERE)
        values[key] = quantity.check(convert(data[key], quantity.unit, where, zero), where)
    return {name: values[name] for name in CONDITIONS if name in values}


def format_conditions(conditions: Mapping[str, float]) -> str:
    """Return the text that :func:`parse_conditions` reads back to exactly the same values."""
    texts = {name: CONDITIONS[name].format(float(value)) for name, value in conditions.items()}
    return to_yaml(texts) if texts else ''


def check_plausible(
    origin: object, signals: Mapping[str, Floats], configuration: RigConfiguration
) -> None:
    """
    Check that position [m] and absolute pressures [Pa] can be those of a rig.

    A wrong unit is off by a factor. Impossible values would make the simulation take ever smaller
    steps, and a diagnosis meaningless.

    :param origin: their name in errors
    :param signals: name -> values, shape (n,), NaN for missing values
    :param configuration: the rig under the conditions of the run
    :raises RigError: when one is out of range, with a likely reason
    """
    model = configuration.model
    absolute = LEAST * model.gas.atmospheric_pressure, MOST * model.operation.supply_pressure
    for name in WHOLE:
        low, high = _travel(configuration) if name == 'position' else absolute
        values = signals.get(name, np.empty(0))
        values = values[np.isfinite(values)]
        if values.size and not (low <= values.min() and values.max() <= high):
            reason = f'that of {_longer(values)}' if name == 'position' else 'a gauge pressure'
            raise RigError(
                f'{origin}: {name} from {values.min():.4g} to {values.max():.4g} {SIGNALS[name]}, '
                f'{configuration.name} allows {low:.4g} to {high:.4g} {SIGNALS[name]}; '
                f'is it in another unit, or {reason}?'
            )


def _travel(configuration: RigConfiguration) -> tuple[float, float]:
    """Return the least and the largest position that a rig may have [m]."""
    stroke = configuration.model.cylinder.stroke
    return -BEYOND * stroke, (1.0 + BEYOND) * stroke


def _longer(position: Floats) -> str:
    """Return the names of the shipped cylinders that may have a position [m]."""
    names = []
    for name in shipped('cylinder_*.yaml'):
        low, high = _travel(load_configuration(name))
        if low <= position.min() and position.max() <= high:
            names.append(name)
    return ' or '.join(names) or 'another cylinder'
