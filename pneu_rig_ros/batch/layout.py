"""
Parameters packed into rows of numbers, and the source code that unpacks a row.

A compiled loop over plants cannot index named tuples of different fields. So the parameters of
each plant are packed into a row of an array, and the code that unpacks it is generated.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class PackedParameters:
    """
    Nested tuples packed into numbers and arrays.

    :param numbers: floats and integers in their order; integers are exact as floats
    :param arrays: arrays in their order
    :param classes: module and name of each named tuple
    :param code: expression for the tuples of plant i, from ``row`` and ``arrays[j][i]``
    """

    numbers: list[float] = field(default_factory=list)
    arrays: list[Floats] = field(default_factory=list)
    classes: set[tuple[str, str]] = field(default_factory=set)
    code: str = ''

    @property
    def kind(self) -> tuple[object, ...]:
        """Equal for parameters that one loop can unpack."""
        return self.code, tuple(array.shape for array in self.arrays)


def pack_parameters(value: Any) -> PackedParameters:
    """
    Pack nested tuples of floats, integers and arrays.

    :raises TypeError: for anything else
    """
    packed = PackedParameters()
    packed.code = _expression(value, packed)
    return packed


def _expression(value: Any, packed: PackedParameters) -> str:
    if isinstance(value, tuple):
        items = ''.join(f'{_expression(item, packed)}, ' for item in value)
        return f'{_name(value, packed)}({items})'
    if isinstance(value, np.ndarray):
        packed.arrays.append(value)
        return f'arrays[{len(packed.arrays) - 1}][i]'
    if not isinstance(value, float | int):
        raise TypeError(f'{value!r} is not a number')
    packed.numbers.append(float(value))
    place = f'row[{len(packed.numbers) - 1}]'
    return place if isinstance(value, float) else f'int({place})'


def _name(value: tuple[Any, ...], packed: PackedParameters) -> str:
    """Return the name of a tuple's class in the code; parameters of effects share their name."""
    if type(value) is tuple:
        return ''
    module, name = type(value).__module__, type(value).__name__
    packed.classes.add((module, name))
    return alias(module, name)


def alias(module: str, name: str) -> str:
    """Return the name under which the code imports a class."""
    return f'{module.rsplit(".", 1)[-1]}_{name}'
