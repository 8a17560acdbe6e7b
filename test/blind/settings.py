"""Configuration files as plain numbers: read as YAML, changed, written back with units."""

import copy
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml

CONFIG = Path(__file__).resolve().parents[2] / 'config'
Settings = dict[str, dict[str, Any]]
UNITS_OF_LISTS = {'element_stiffness': 'N/m', 'element_limit': 'N'}


@cache
def texts(cylinder: str) -> dict[str, Any]:
    """Return the complete configuration of a shipped cylinder as printed; not to be changed."""
    shared = yaml.safe_load((CONFIG / 'rig.yaml').read_text())
    merged = {**shared, **yaml.safe_load((CONFIG / f'{cylinder}.yaml').read_text())}
    # the sensors of the trials are calibrated, and the model file says so
    calibrated = {'position_class': '0.0 -', 'pressure_class': '0.0 -'}
    return {**merged, 'sensors': {**merged['sensors'], **calibrated}}


def number(text: Any) -> Any:
    """Return the number of '4.91e-4 m^2', lists item by item, names as they are."""
    if isinstance(text, list):
        return [number(item) for item in text]
    try:
        return float(text.split()[0])
    except (ValueError, AttributeError):
        return text


def settings(cylinder: str) -> Settings:
    """Return section -> key -> number of a shipped cylinder."""
    return {
        section: {key: number(text) for key, text in keys.items()}
        for section, keys in texts(cylinder).items()
        if isinstance(keys, dict) and section != 'effects'
    }


def changed(base: Settings, changes: dict[str, Any]) -> Settings:
    """Return the settings with section.key replaced."""
    result = copy.deepcopy(base)
    for name, value in changes.items():
        section, key = name.split('.')
        assert key in result[section], f'{name}: no such setting'
        result[section][key] = value
    return result


def operation(values: dict[str, float]) -> dict[str, float]:
    """Return keys of the section ``operation`` as changes."""
    return {f'operation.{key}': value for key, value in values.items()}


def model_file(cylinder: str, changes: dict[str, Any]) -> str:
    """Return a complete configuration file, with section.key replaced (in SI units)."""
    data = copy.deepcopy(texts(cylinder))
    for name, value in changes.items():
        section, key = name.split('.')
        data[section][key] = _with_unit(key, data[section][key], value)
    return yaml.safe_dump(data, sort_keys=False)


def section_texts(rig: Settings, keys: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    """Return section -> key -> text with unit, of the keys asked for."""
    shipped = texts('cylinder_1')
    return {
        section: {key: _with_unit(key, shipped[section][key], rig[section][key]) for key in own}
        for section, own in keys.items()
    }


def _with_unit(key: str, text: Any, value: Any) -> Any:
    if isinstance(value, list):
        unit = UNITS_OF_LISTS[key]
        return [f'{item!r} {unit}' for item in value]
    if isinstance(value, str):
        return value
    return f'{value!r} {text.split()[1]}'
