"""
Readings of the paper by name or from a file: read strictly, written back.

A file says only what differs from the shipped cylinders, for all of them or for a single one::

    friction:
      stop_velocity: 0.001 m/s
      static_friction_reading: follows_clock
    rest_time: 900.0 s
    initial_position: 0.05 m
    cylinder_1:
      dwell_coefficient: 0.3 s^-alpha
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pneu_rig_ros.claims.experiments import CYLINDERS, Reading
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import Friction
from pneu_rig_ros.model.quantity import (
    Quantity,
    QuantityList,
    Specification,
    specifications,
    unknown,
)
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.configuration import (
    OVERRIDES,
    configuration_folder,
    configuration_from_yaml,
)
from pneu_rig_ros.rig.yaml_file import parse_yaml, read_text

DEFAULT = 'default'
"""The reading of the shipped cylinder files, and its name."""
NOT_PRINTED = (
    'element_stiffness',
    'element_limit',
    'fluid_time_constant',
    'stop_velocity',
    'start_velocity',
    'static_friction_reading',
    'film_reading',
    'film_rest_velocity',
    'film_rest_reading',
)
"""Fields of ``Friction`` that the paper leaves open; Table 2 prints the others."""
CONDITIONS = ('rest_time', 'initial_position')
"""Conditions of an experiment that the captions do not give."""
SPECIFICATIONS = {k: v for k, v in specifications(Friction).items() if k != 'model'}
"""Fields that a reading may give: all but the friction law, which each experiment chooses."""
LONGEST_NAME = 60
"""[character]"""


def shipped_readings() -> list[str]:
    """Return the names of the readings that come with the package."""
    folder = configuration_folder() / 'readings'
    return sorted(path.stem for path in folder.glob('*.yaml'))


def load_reading(source: str | Path) -> Reading:
    """
    Return a reading.

    :param source: 'default', the name of a shipped reading, or the path of a YAML file
    :raises RigError: for anything unknown, of a wrong unit, out of range or contradictory
    """
    if str(source) == DEFAULT:
        return Reading()
    path = _locate(source)
    reading = _read(parse_yaml(read_text(path), str(path)), str(path), path.stem)
    _check_with_cylinders(reading, str(path))
    return reading


def reading_values(reading: Reading) -> dict[str, Any]:
    """Return the mapping that, as YAML or JSON, reads back to the same reading."""
    return {
        'name': reading.name,
        'friction': _formatted(reading.friction),
        **{key: OVERRIDES[key].format(value) for key, value in reading.operation.items()},
        **{name: _formatted(friction) for name, friction in reading.single.items()},
    }


def _formatted(friction: Mapping[str, Any]) -> dict[str, Any]:
    return {key: SPECIFICATIONS[key].format(value) for key, value in friction.items()}


def short_text(specification: Specification, value: Any) -> str:
    """Return a value to be read by people, in six digits."""
    if isinstance(specification, QuantityList):
        return ' + '.join(short_text(specification.item, item) for item in value) or 'none'
    if isinstance(specification, Quantity):
        return f'{value:.6g} {specification.unit}'
    return specification.format(value).replace('_', ' ')


def printed_values_changed(reading: Reading) -> list[str]:
    """Return the fields in which the reading departs from what Table 2 prints."""
    return [
        key
        for key in SPECIFICATIONS
        if key not in NOT_PRINTED
        and any(
            getattr(_friction(name), key) != value
            for name in CYLINDERS
            if (value := reading.friction_of(name).get(key)) is not None
        )
    ]


def _friction(cylinder: str) -> Friction:
    return load_configuration(cylinder).model.friction


def _locate(source: str | Path) -> Path:
    path, names = Path(source), shipped_readings()
    if path.suffix in ('.yaml', '.yml'):
        return path
    if str(source) in names:
        return configuration_folder() / 'readings' / f'{source}.yaml'
    if path.exists():
        return path
    raise RigError(f'reading: {unknown(str(source), [DEFAULT, *names])}, or a YAML file')


def _read(data: object, origin: str, stem: str) -> Reading:
    values = _mapping(data, ('name', 'friction', *CONDITIONS, *CYLINDERS), origin)
    return Reading(
        _name(values.get('name', stem), origin),
        _parsed_friction(values.get('friction', {}), f'{origin}: friction'),
        {
            key: OVERRIDES[key].parse(values[key], f'{origin}: {key}')
            for key in CONDITIONS
            if key in values
        },
        {
            name: _parsed_friction(values[name], f'{origin}: {name}')
            for name in CYLINDERS
            if name in values
        },
    )


def _parsed_friction(data: object, where: str) -> dict[str, Any]:
    values = _mapping(data, SPECIFICATIONS, where)
    return {k: SPECIFICATIONS[k].parse(value, f'{where}.{k}') for k, value in values.items()}


def _mapping(data: object, allowed: Iterable[str], where: str) -> dict[str, Any]:
    """Return a YAML mapping of allowed keys."""
    allowed = list(allowed)
    if not isinstance(data, dict):
        raise RigError(f'{where}: expected a mapping with some of {", ".join(allowed)}')
    for key in data:
        if key not in allowed:
            raise RigError(f'{where}: {unknown(str(key), allowed)}')
    return data


def _name(name: object, origin: str) -> str:
    if isinstance(name, str) and name.isprintable() and 0 < len(name.strip()) <= LONGEST_NAME:
        return name
    raise RigError(f'{origin}: name: {name!r} is not a line of 1 to {LONGEST_NAME} characters')


def _check_with_cylinders(reading: Reading, origin: str) -> None:
    """Refuse what contradicts itself once it is put into the shipped cylinders."""
    for name in CYLINDERS:
        shipped = load_configuration(name)
        friction = shipped.model.friction._replace(**reading.friction_of(name))
        operation = shipped.model.operation._replace(**reading.operation)
        model = shipped.model._replace(friction=friction, operation=operation)
        changed = replace(shipped, model=model)
        configuration_from_yaml(changed.to_yaml(), f'{origin}: with {name}')
