"""Excitations from files: what is driven, the valve command or the position, and its shape."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from pneu_rig_ros.control.shapes import LEVEL, SHAPES, Shape
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import (
    Quantity,
    QuantityList,
    Specification,
    read_section,
    specifications,
    unknown,
)
from pneu_rig_ros.rig.configuration import configuration_folder
from pneu_rig_ros.rig.yaml_file import parse_yaml, read_text

COMMAND, REFERENCE = 'u', 'reference'
LEVELS = {
    COMMAND: LEVEL,
    REFERENCE: Quantity('m', 0.0, 10.0, 'position that the piston shall have'),
}
"""Topic that is driven -> what its level is."""


@dataclass(frozen=True)
class Excitation:
    """
    A level over time.

    :param name: of the file
    :param drives: topic: 'u' [V] or 'reference' [m]
    :param shape: level as a function of time
    """

    name: str
    drives: str
    shape: Shape

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.shape.duration

    def level(self, time: float) -> float:
        """
        Return the level at a time since the start [s], in V or m.

        Afterwards the valves are shut (u = 0), and a position is kept.
        """
        if time < self.duration:
            return self.shape.level(time)
        return 0.0 if self.drives == COMMAND else self.shape.level(self.duration)


def excitation_folder() -> Path:
    """Return the folder of the shipped excitations."""
    return configuration_folder() / 'excitations'


def shipped_excitations() -> list[str]:
    """Return the names of the excitations that come with the package."""
    return sorted(path.stem for path in excitation_folder().glob('*.yaml'))


def load_excitation(source: str | Path) -> Excitation:
    """
    Read an excitation.

    :param source: name of a shipped one, or path of a YAML file
    :raises RigError: for anything missing, unknown, of a wrong unit or out of range
    """
    path = _locate(source)
    data = _mapping(path)
    drives = _name(data, 'drives', list(LEVELS), path)
    kind = _name(data, 'shape', list(SHAPES), path)
    values = {key: value for key, value in data.items() if key not in ('drives', 'shape')}
    shape = read_section(_with_level(SHAPES[kind], LEVELS[drives]), values, str(path))
    excitation = Excitation(path.stem, drives, shape)
    if not excitation.duration > 0.0:
        raise RigError(f'{path}: lasts 0 s, must be longer')
    return excitation


def _locate(source: str | Path) -> Path:
    path = Path(source)
    if path.suffix in ('.yaml', '.yml') or path.exists():
        return path
    if str(source) in shipped_excitations():
        return excitation_folder() / f'{source}.yaml'
    raise RigError(f'excitation: {unknown(str(source), shipped_excitations())}, or a YAML file')


def _mapping(path: Path) -> dict[str, Any]:
    data = parse_yaml(read_text(path), str(path))
    if not isinstance(data, dict):
        raise RigError(f'{path}: expected a mapping with drives, shape and its parameters')
    return data


def _name(data: dict[str, Any], key: str, allowed: list[str], path: Path) -> str:
    if key not in data:
        raise RigError(f'{path}: missing {key}, one of {", ".join(allowed)}')
    if data[key] not in allowed:
        raise RigError(f'{path}: {key}: {unknown(str(data[key]), allowed)}')
    return str(data[key])


def _with_level(shape: type[Shape], level: Quantity) -> type[Shape]:
    """Return the shape with another unit and range of its levels."""

    def of(specification: Specification) -> Specification:
        if isinstance(specification, QuantityList) and specification.item is LEVEL:
            return replace(specification, item=level)
        return level if specification is LEVEL else specification

    hints = {key: Annotated[Any, of(spec)] for key, spec in specifications(shape).items()}
    return type(shape.__name__, (shape,), {'__annotations__': hints})
