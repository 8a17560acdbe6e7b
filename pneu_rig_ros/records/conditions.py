"""
The conditions under which a bag was recorded: what its signals do not say.

Supply pressure, load, surroundings and rest before the start. They are looked up one by one,
first in ``conditions.yaml`` beside the bag's data, then in the bag's metadata ``conditions``, then
in the rig configuration that the bag holds. What none of them says is left to the model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import Gas
from pneu_rig_ros.model.quantity import Quantity, specifications, unknown
from pneu_rig_ros.records.units import STANDARD_ATMOSPHERE, convert
from pneu_rig_ros.rig.configuration import OVERRIDES, RigConfiguration, override
from pneu_rig_ros.rig.yaml_file import parse_yaml, read_text, to_yaml

if TYPE_CHECKING:
    from pneu_rig_ros.records.record import Record

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


def conditions_of(bag: Path | str, record: Record) -> dict[str, float]:
    """
    Return the conditions of a bag that are known, SI units, absolute pressures.

    :param bag: the bag's directory, or a file in it
    :param record: what `read_record` read from it
    :return: name of :data:`CONDITIONS` -> value
    :raises RigError: when a source holds anything else
    """
    found = recorded_conditions(record)
    text = record.metadata.get('conditions')
    if text:
        found |= parse_conditions(text, f'{bag}: metadata conditions')
    path = Path(bag)
    file = (path.parent if path.is_file() else path) / FILE_NAME
    return found | read_conditions(file) if file.exists() else found


def recorded_conditions(record: Record) -> dict[str, float]:
    """Return the conditions that the record's rig configuration says, {} without one."""
    if record.configuration is None:
        return {}
    model = record.configuration.model
    values = {name: getattr(model.operation, name) for name in CONDITIONS if name != _ATMOSPHERE}
    return values | {_ATMOSPHERE: model.gas.atmospheric_pressure}


def apply_conditions(
    configuration: RigConfiguration, conditions: Mapping[str, float]
) -> RigConfiguration:
    """
    Return the configuration of a rig under other conditions.

    :param conditions: name of :data:`CONDITIONS` -> value in SI units; what is not there stays
    :raises RigError: for another name, or a value out of range
    """
    checked = {name: _known(name, 'conditions').check(value, f'conditions: {name}')
               for name, value in conditions.items()}  # fmt: skip
    model = configuration.model
    gas = model.gas
    if _ATMOSPHERE in checked:
        gas = gas._replace(atmospheric_pressure=checked.pop(_ATMOSPHERE))
    changed = replace(configuration, model=model._replace(gas=gas))
    return override(changed, checked)


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
    data = {} if data is None else data
    if not isinstance(data, dict):
        raise RigError(f'{origin}: expected a mapping with {", ".join(CONDITIONS)}')
    values: dict[str, float] = {}
    # The atmosphere first, as the zero of the others' gauge pressures.
    for key in sorted(data, key=lambda name: name != _ATMOSPHERE):
        quantity, where = _known(str(key), origin), f'{origin}: {key}'
        zero = None if key == _ATMOSPHERE else values.get(_ATMOSPHERE, STANDARD_ATMOSPHERE)
        values[str(key)] = quantity.check(convert(data[key], quantity.unit, where, zero), where)
    return {name: values[name] for name in CONDITIONS if name in values}


def format_conditions(conditions: Mapping[str, float]) -> str:
    """Return the text that :func:`parse_conditions` reads back to exactly the same values."""
    texts = {name: CONDITIONS[name].format(float(value)) for name, value in conditions.items()}
    return to_yaml(texts) if texts else ''


def _known(name: str, origin: str) -> Quantity:
    if name not in CONDITIONS:
        raise RigError(f'{origin}: {unknown(name, CONDITIONS)}')
    return CONDITIONS[name]
