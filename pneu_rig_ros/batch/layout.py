"""
Parameters as rows of numbers, and the compiled code that makes parameters of a row again.

A compiled loop over plants cannot index named tuples of different fields. So each plant's go into
a row of an array, and the code that puts them together is written from one of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Row:
    """
    Nested tuples taken apart.

    :param numbers: floats and integers in their order; these are exact as floats
    :param arrays: arrays in their order
    :param classes: module and name of each named tuple
    :param code: the expression that makes them of ``row`` and, for plant i, ``arrays[j][i]``
    """

    numbers: list[float] = field(default_factory=list)
    arrays: list[Floats] = field(default_factory=list)
    classes: set[tuple[str, str]] = field(default_factory=set)
    code: str = ''

    @property
    def kind(self) -> tuple[object, ...]:
        """What rows must have in common to go through one loop."""
        return self.code, tuple(array.shape for array in self.arrays)


def take_apart(value: Any) -> Row:
    """
    Take nested tuples of floats, integers and arrays apart.

    :raises TypeError: for anything else
    """
    row = Row()
    row.code = _expression(value, row)
    return row


def _expression(value: Any, row: Row) -> str:
    if isinstance(value, tuple):
        items = ''.join(f'{_expression(item, row)}, ' for item in value)
        return f'{_name(value, row)}({items})'
    if isinstance(value, np.ndarray):
        row.arrays.append(value)
        return f'arrays[{len(row.arrays) - 1}][i]'
    if not isinstance(value, float | int):
        raise TypeError(f'{value!r} is no number')
    row.numbers.append(float(value))
    place = f'row[{len(row.numbers) - 1}]'
    return place if isinstance(value, float) else f'int({place})'


def _name(value: tuple[Any, ...], row: Row) -> str:
    """Return what the code calls the class of a tuple; effects' parameters share their name."""
    if type(value) is tuple:
        return ''
    module, name = type(value).__module__, type(value).__name__
    row.classes.add((module, name))
    return alias(module, name)


def alias(module: str, name: str) -> str:
    """Return the name under which the code imports a class."""
    return f'{module.rsplit(".", 1)[-1]}_{name}'
