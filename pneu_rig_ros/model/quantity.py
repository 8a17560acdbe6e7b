"""What a physical parameter is: unit, range, meaning - and how its text is read."""

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from pneu_rig_ros.errors import RigError

_TEXT = re.compile(r'^\s*(?P<number>[^\s]+)\s+(?P<unit>\S+)\s*$')

LARGEST_INTEGER = 2**53
"""Up to here every integer is a number in YAML, JSON and a ROS parameter alike."""


@dataclass(frozen=True)
class Quantity:
    """
    A scalar parameter in SI units with its closed range of allowed values.

    :param unit: SI unit as written in the YAML files, ``-`` for a pure number
    :param low: smallest allowed value [unit]
    :param high: largest allowed value [unit]
    :param description: what it is, with the paper's symbol
    """

    unit: str
    low: float
    high: float
    description: str

    def check(self, value: float, where: str) -> float:
        """Return the value as a float; raise :class:`RigError` unless finite and in range."""
        if not (math.isfinite(value) and self.low <= value <= self.high):
            unit = '' if self.unit == '-' else f' {self.unit}'
            raise RigError(
                f'{where}: {value:g}{unit} is not within {self.low:g} to {self.high:g}{unit}'
            )
        return float(value)

    def within(self, value: float) -> float:
        """Return the allowed value next to a value [unit]."""
        return min(max(value, self.low), self.high)

    def parse(self, text: object, where: str) -> float:
        """
        Read ``'4.91e-4 m^2'``, or a pure number, to which ``-`` may be added.

        :raises RigError: for another unit or range
        """
        pure = self.unit == '-' and isinstance(text, str | int | float)
        if pure and not isinstance(text, bool) and len(str(text).split()) == 1:
            text = f'{text} -'
        match = _TEXT.match(text) if isinstance(text, str) else None
        if match is None:
            unit = '' if self.unit == '-' else f' and its unit {self.unit}'
            raise RigError(f'{where}: {text!r} is not a number{unit}')
        if match['unit'] != self.unit:
            raise RigError(f'{where}: unit {match["unit"]} in {text!r}, allowed is {self.unit}')
        try:
            number = float(match['number'])
        except ValueError:
            raise RigError(f'{where}: {match["number"]!r} is not a number') from None
        return self.check(number, where)

    def format(self, value: float) -> str:
        """Return the text that :meth:`parse` reads back to exactly the same value."""
        return f'{value!r} {self.unit}'


@dataclass(frozen=True)
class QuantityList:
    """A list of quantities of one kind, at most ``longest`` of them."""

    item: Quantity
    longest: int

    @property
    def description(self) -> str:
        """What one item of the list is."""
        return self.item.description

    def parse(self, values: object, where: str) -> tuple[float, ...]:
        """Read a YAML list; raise :class:`RigError` naming the entry that is wrong."""
        if not isinstance(values, list) or len(values) > self.longest:
            raise RigError(f'{where}: expected a list of at most {self.longest} entries')
        return tuple(self.item.parse(v, f'{where}[{i}]') for i, v in enumerate(values))

    def format(self, values: Iterable[float]) -> list[str]:
        """Return the list that :meth:`parse` reads back."""
        return [self.item.format(value) for value in values]


@dataclass(frozen=True)
class Choice:
    """A parameter that is one of a few names, held as the index of the name."""

    names: tuple[str, ...]
    description: str

    def parse(self, name: object, where: str) -> int:
        """Return the index of the name; raise :class:`RigError` with the nearest match."""
        if name not in self.names:
            raise RigError(f'{where}: {unknown(str(name), self.names)}')
        return self.names.index(str(name))

    def format(self, index: int) -> str:
        """Return the name at the index."""
        return self.names[index]


Specification = Quantity | QuantityList | Choice


def unknown(name: str, allowed: Iterable[str]) -> str:
    """Say that a name is not known, with the nearest match and all allowed names."""
    names = list(allowed)
    near = difflib.get_close_matches(name, names, 1)
    hint = f', did you mean {near[0]!r}?' if near else ''
    return f'unknown name {name!r}{hint}, allowed: {", ".join(names) or "none"}'


def mapping_of(data: object, allowed: Iterable[str], where: str) -> dict[str, Any]:
    """Return data of YAML that are a mapping of allowed keys; RigError for anything else."""
    names = list(allowed)
    if not isinstance(data, dict):
        raise RigError(f'{where}: expected a mapping with {", ".join(names)}')
    for key in data:
        if key not in names:
            raise RigError(f'{where}: {unknown(str(key), names)}')
    return data


def read_values(data: object, allowed: Mapping[str, Any], where: str) -> dict[str, Any]:
    """
    Return name -> value [SI] of a mapping in YAML, empty if there is none.

    :raises RigError: for an unknown name, a wrong unit or a value out of range
    """
    given = mapping_of({} if data is None else data, allowed, where).items()
    return {str(key): allowed[key].parse(text, f'{where}.{key}') for key, text in given}


def write_values(values: Mapping[str, Any], allowed: Mapping[str, Any]) -> dict[str, Any]:
    """Return the mapping that :func:`read_values` reads back."""
    return {name: allowed[name].format(value) for name, value in values.items()}


def specifications(section: type[Any]) -> dict[str, Specification]:
    """Return field name -> specification of a section declared with ``Annotated`` fields."""
    hints = get_type_hints(section, include_extras=True)
    return {name: hints[name].__metadata__[0] for name in section._fields}


def read_section(section: type[Any], values: object, where: str) -> Any:
    """
    Build a section (a ``NamedTuple`` class) from a YAML mapping; defaults may be omitted.

    :raises RigError: for a missing or unknown key, a wrong unit, or a value out of range
    """
    wanted = specifications(section)
    given = mapping_of(values, wanted, where)
    if missing := [k for k in wanted if k not in given and k not in section._field_defaults]:
        raise RigError(f'{where}: missing {", ".join(missing)}')
    return section(**{k: wanted[k].parse(value, f'{where}.{k}') for k, value in given.items()})


def write_section(section: Any) -> dict[str, Any]:
    """Return the YAML mapping that :func:`read_section` reads back, without defaults."""
    defaults = section._field_defaults
    return {
        key: specification.format(getattr(section, key))
        for key, specification in specifications(type(section)).items()
        if key not in defaults or getattr(section, key) != defaults[key]
    }
