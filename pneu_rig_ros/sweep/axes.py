"""What is varied: names, values, and the rig at one point of the grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.quantity import Choice, Quantity, specifications, unknown
from pneu_rig_ros.model.shape import with_values
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.configuration import OVERRIDES, override

COMMAND = Quantity('V', -2.5, 2.5, 'command of Eq. 1')
MOST_POINTS = 1_000_000
"""Points of a grid at most."""


@dataclass(frozen=True)
class Axis:
    """
    One thing that is varied.

    :param name: ``u``, a condition of the run, ``section.key`` or ``effect.parameter``
    :param specification: its unit and range, or the names of its choices
    :param values: SI units, or the index of a choice
    """

    name: str
    specification: Quantity | Choice
    values: tuple[float, ...]

    @property
    def unit(self) -> str:
        """SI unit; '-' for a pure number or a choice."""
        return self.specification.unit if isinstance(self.specification, Quantity) else '-'

    def shown(self, value: float) -> float | str:
        """Return a value as tables have it: the name of a choice, else the number."""
        if isinstance(self.specification, Choice):
            return self.specification.format(int(value))
        return value


def axis(name: str, text: str) -> Axis:
    """
    Return the axis of a name and of values such as ``0.3``, ``0.3,0.4`` or ``0.2:0.4:21``.

    :raises RigError: for an unknown name, or values that are not numbers or out of range
    """
    specification = _specification(name)
    if isinstance(specification, Choice):
        return Axis(
            name, specification, tuple(specification.parse(t, name) for t in text.split(','))
        )
    values = _numbers(text, name)
    return Axis(name, specification, tuple(specification.check(v, name) for v in values))


def _specification(name: str) -> Quantity | Choice:
    section, _, key = name.rpartition('.')
    if not section:
        allowed = {'u': COMMAND, **OVERRIDES}
        if name not in allowed:
            raise RigError(f'{unknown(name, allowed)}, section.key or effect.parameter')
        return allowed[name]
    groups = (*SECTIONS, *library.names())
    if section not in groups:
        raise RigError(f'{name}: {unknown(section, groups)}')
    owner = SECTIONS[section] if section in SECTIONS else library.load(section).parameters
    known = {
        key: one
        for key, one in specifications(owner).items()
        if isinstance(one, Quantity | Choice)
    }
    if key not in known:
        raise RigError(f'{section}: {unknown(key, known)}')
    return known[key]


def _numbers(text: str, name: str) -> list[float]:
    try:
        if ':' not in text:
            return [float(part) for part in text.split(',')]
        low, high, count = text.split(':')
        if int(count) < 2:
            raise ValueError
        return [float(value) for value in np.linspace(float(low), float(high), int(count))]
    except ValueError:
        raise RigError(f'{name} {text}: expected a number, A,B,... or LOW:HIGH:COUNT') from None


def check_size(axes: Sequence[Axis]) -> int:
    """Return the number of points; RigError when a name is given twice or there are too many."""
    names = [one.name for one in axes]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise RigError(f'{twice[0]} is varied twice')
    size = math.prod(len(one.values) for one in axes)
    if size > MOST_POINTS:
        raise RigError(f'{size} points; at most {MOST_POINTS}')
    return size


def at_point(
    configuration: RigConfiguration, names: Sequence[str], point: Sequence[float]
) -> RigConfiguration:
    """
    Return the rig at a point of the grid; a command is no part of it.

    :param names: of the axes
    :param point: their values
    :raises RigError: when values contradict each other
    """
    conditions = {}
    for name, value in zip(names, point, strict=True):
        section, _, key = name.rpartition('.')
        if section in SECTIONS:
            configuration = _with_parameter(configuration, section, key, value)
        elif section:
            own = configuration.effects.get(section, library.load(section).null)
            changed = {**configuration.effects, section: with_values(own, {key: value})}
            configuration = replace(configuration, effects=changed)
        elif name != 'u':
            conditions[name] = value
    return override(configuration, conditions)


def _with_parameter(
    configuration: RigConfiguration, section: str, key: str, value: Any
) -> RigConfiguration:
    changed = getattr(configuration.model, section)._replace(**{key: value})
    return replace(configuration, model=configuration.model._replace(**{section: changed}))
