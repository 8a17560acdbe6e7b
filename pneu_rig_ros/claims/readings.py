"""
Readings of the paper by name or from a file: read strictly, written back.

A file says only what differs from the shipped cylinders, section by section as in their files, for
all of them or below the name of a single one.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from pneu_rig_ros.claims.experiments import CYLINDERS, Changes, Reading, shipped
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.quantity import (
    Quantity,
    QuantityList,
    Specification,
    mapping_of,
    specifications,
)
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.configuration import configuration_from_yaml
from pneu_rig_ros.rig.yaml_file import locate, parse_yaml, read_text

DEFAULT = 'default'
"""The reading of the shipped cylinder files, and its name."""
NOT_PRINTED = {
    'friction': (
        'element_stiffness',
        'element_limit',
        'fluid_time_constant',
        'stop_velocity',
        'start_velocity',
        'static_friction_reading',
        'memory_time',
        'film_reading',
        'film_rest_velocity',
        'film_rest_reading',
    ),
    'valve': ('laminar_pressure_ratio',),
    'gas': ('gas_constant',),
    'operation': ('initial_position', 'initial_pressure_1', 'initial_pressure_2', 'rest_time'),
}
"""Section -> fields that the paper leaves open."""
AS_PRINTED: dict[str, dict[str, tuple[float, ...]]] = {
    'valve': {'exhaust_zero_voltage': (2.65,)},
    'operation': {'supply_pressure': (4e5, 5e5)},
}
"""Section -> fields that can be read in more ways than one -> values that are no change of it."""
EXPERIMENT = {'friction': ('model',), 'operation': ('load_mass',)}
"""Section -> fields that each experiment chooses."""
SPECIFICATIONS: dict[str, dict[str, Specification]] = {
    section: {
        key: value
        for key, value in specifications(fields).items()
        if key not in EXPERIMENT.get(section, ())
    }
    for section, fields in SECTIONS.items()
}
"""Section -> field -> what a reading may give for it."""
LONGEST_NAME = 60
"""[character]"""


def load_reading(source: str | Path) -> Reading:
    """
    Return a reading.

    :param source: 'default', the name of a shipped reading, or the path of a YAML file
    :raises RigError: for anything unknown, of a wrong unit, out of range or contradictory
    """
    if str(source) == DEFAULT:
        return Reading()
    path = locate(source, 'reading', 'readings/*.yaml', [DEFAULT])
    reading = _read(parse_yaml(read_text(path), str(path)), str(path), path.stem)
    for name in CYLINDERS:  # refuse what contradicts itself once it is put into them
        changed = replace(load_configuration(name), model=reading.model(name))
        configuration_from_yaml(changed.to_yaml(), f'{path}: with {name}')
    return reading


def reading_values(reading: Reading) -> dict[str, Any]:
    """Return the mapping that, as YAML or JSON, reads back to the same reading."""
    return {
        'name': reading.name,
        **_formatted(reading.common),
        **{name: _formatted(changes) for name, changes in reading.single.items()},
    }


def _formatted(changes: Changes) -> dict[str, dict[str, Any]]:
    return {
        section: {key: SPECIFICATIONS[section][key].format(v) for key, v in values.items()}
        for section, values in changes.items()
    }


def short_text(specification: Specification, value: Any) -> str:
    """Return a value to be read by people, in six digits."""
    if isinstance(specification, QuantityList):
        return ' + '.join(short_text(specification.item, item) for item in value) or 'none'
    if isinstance(specification, Quantity):
        return f'{value:.6g} {specification.unit}'
    return specification.format(value).replace('_', ' ')


def open_quantities() -> Iterator[str]:
    """Yield section.field of all that the paper leaves open or that can be read twice."""
    for section in SPECIFICATIONS:
        for key in (*NOT_PRINTED.get(section, ()), *AS_PRINTED.get(section, ())):
            yield f'{section}.{key}'


def printed_values_changed(reading: Reading) -> list[str]:
    """Return section.field of what the reading gives another value than the paper prints."""
    return sorted(
        {
            f'{section}.{key}'
            for name in CYLINDERS
            for changes in (reading.common, reading.single.get(name, {}))
            for section, values in changes.items()
            for key, value in values.items()
            if _departs(name, section, key, value)
        }
    )


def _departs(cylinder: str, section: str, key: str, value: Any) -> bool:
    if key in NOT_PRINTED.get(section, ()):
        return False
    if key in AS_PRINTED.get(section, ()):
        return value not in AS_PRINTED[section][key]
    return bool(getattr(getattr(shipped(cylinder), section), key) != value)


def _read(data: object, origin: str, stem: str) -> Reading:
    values = mapping_of(data, ('name', *SPECIFICATIONS, *CYLINDERS), origin)
    return Reading(
        _name(values.get('name', stem), origin),
        _changes({key: values[key] for key in SPECIFICATIONS if key in values}, origin),
        {
            name: _changes(values[name], f'{origin}: {name}')
            for name in CYLINDERS
            if name in values
        },
    )


def _changes(data: object, where: str) -> dict[str, dict[str, Any]]:
    """Return sections with their fields in SI units."""
    changes = {}
    for section, fields in mapping_of(data, SPECIFICATIONS, where).items():
        allowed, place = SPECIFICATIONS[section], f'{where}: {section}'
        values = mapping_of(fields, allowed, place)
        changes[section] = {k: allowed[k].parse(v, f'{place}.{k}') for k, v in values.items()}
    return changes


def _name(name: object, origin: str) -> str:
    if isinstance(name, str) and name.isprintable() and 0 < len(name.strip()) <= LONGEST_NAME:
        return name
    raise RigError(f'{origin}: name: {name!r} is not a line of 1 to {LONGEST_NAME} characters')
