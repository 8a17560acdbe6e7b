"""
The mapping file: where the signals are in a table or bag of another rig, and their units.

All its keys are in docs/measured_data.md. In a table a signal names its column, in a bag, under
``topics``, a topic and a field of its messages::

    time: {column: 't [ms]', unit: ms}          # or {rate: 862 Hz}, {interval: 1.16 ms}
    pressure_1: {column: p1, unit: bar, gauge: true}
    force:                                      # the sum of columns
      - {column: load cell, unit: N}
      - {column: p hydraulic, unit: bar, scale: 9e-4 m^2}
    topics: {position: {topic: /axis/state, field: 'position[0]'}}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import mapping_of
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS
from pneu_rig_ros.records.units import Unit, convert, parse_unit
from pneu_rig_ros.rig.yaml_file import parse_yaml, read_text

SEPARATORS = {sign: sign for sign in ',;\t '}
SEPARATORS |= {'comma': ',', 'semicolon': ';', 'tab': '\t', 'blank': ' ', 'space': ' '}
"""What a mapping may call a separator -> the separator."""

DATETIME = 'datetime'
"""Unit of a time column that holds date and time of day."""

_KINDS: dict[str, tuple[tuple[type, ...], str]] = {
    'column': ((str, int), 'a text or a number'),
    'unit': ((str,), 'a text'),
    'gauge': ((bool,), 'true or false'),
    'scale': ((str, int, float), 'a text or a number'),
    'offset': ((str,), 'a text'),
    'topic': ((str,), 'a text'),
    'field': ((str,), 'a text'),
}
"""Key of an entry -> types of its value, and their names."""


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


_LAYOUT: dict[str, tuple[Callable[[Any], bool], str]] = {
    'separator': (lambda value: value in [*SEPARATORS], "allowed: ',', ';', tab, blank"),
    'decimal': (lambda value: value in ('.', ','), "allowed: '.', ','"),
    'comment': (lambda value: isinstance(value, str), 'must be a text'),
    'skip_rows': (_is_count, 'must be a number of lines'),
    'skip_after_header': (_is_count, 'must be a number of lines'),
    'header': (lambda value: value in (None, 'auto', True, False), 'allowed: true, false, auto'),
}
"""Key of the layout of a table -> check of its value, and what is allowed."""

_SIGNAL = ('column', 'unit', 'gauge', 'scale', 'offset')
_TOPIC = ('topic', 'field', 'unit', 'gauge', 'scale', 'offset')
_TIME = ('column', 'unit', 'rate', 'interval')


@dataclass(frozen=True)
class Source:
    """
    Where one signal is.

    :param column: name, or number counted from 1; None in a bag
    :param unit: as written, None if given by the header or the message type
    :param gauge: whether pressures count from the atmosphere, None if given by the unit
    :param scale: factor with unit before the unit of the signal counts, e.g. '50 N/V'
    :param offset: added after scaling, with unit
    :param topic: of the bag, '' in a table
    :param field: of its messages, '' for the usual one
    :param added: further columns of a force, whose values are added
    """

    column: str | int | None = None
    unit: str | None = None
    gauge: bool | None = None
    scale: str | float | None = None
    offset: str | None = None
    topic: str = ''
    field: str = ''
    added: tuple[Source, ...] = ()


@dataclass(frozen=True)
class Layout:
    """Format of a text table; None is detected from its first lines."""

    separator: str | None = None
    decimal: str | None = None
    comment: str = '#'
    skip_rows: int = 0
    skip_after_header: int = 0
    header: bool | None = None


@dataclass(frozen=True)
class TableMapping:
    """
    A mapping file, checked.

    :param origin: its name in errors
    :param signals: name of `recording.SIGNALS` -> where it is
    :param time: column of the time, None if the interval is given, or in a bag
    :param interval: [s], None if there is a time column
    :param layout: of a text table
    :param atmospheric_pressure: zero of gauge pressures [Pa], None if not given
    """

    origin: str
    signals: Mapping[str, Source]
    time: Source | None = None
    interval: float | None = None
    layout: Layout = field(default_factory=Layout)
    atmospheric_pressure: float | None = None

    @property
    def of_bag(self) -> bool:
        """Whether it maps topics."""
        return any(source.topic for source in self.signals.values())


def read_mapping(source: Path | str | Mapping[str, Any]) -> TableMapping:
    """
    Return a mapping from a YAML file, or from what such a file would hold.

    :raises RigError: for a name or a key that is not known, or a value of a wrong kind
    """
    if isinstance(source, Mapping):
        origin, data = 'mapping', dict(source)
    else:
        origin, data = str(source), parse_yaml(read_text(source), str(source))
    mapping_of(data, ('time', *SIGNALS, *_LAYOUT, 'atmospheric_pressure', 'topics'), origin)
    in_bag = 'topics' in data
    where, entries = (f'{origin}: topics', data['topics']) if in_bag else (origin, data)
    if in_bag:
        mapping_of(entries, SIGNALS, where)
    signals = {
        name: _source(entries[name], f'{where}: {name}', in_bag, name)
        for name in SIGNALS
        if name in entries
    }
    if not signals:
        raise RigError(f'{where}: names no signal, allowed: {", ".join(SIGNALS)}')
    _check_once(signals, where)
    time, interval = _time(data.get('time'), f'{origin}: time', in_bag)
    zero = data.get('atmospheric_pressure')
    if zero is not None:
        zero = convert(zero, 'Pa', f'{origin}: atmospheric_pressure')
    return TableMapping(origin, signals, time, interval, _layout(data, origin), zero)


def _check_once(signals: Mapping[str, Source], where: str) -> None:
    """Raise RigError when two signals are read from the same place."""
    seen: dict[tuple[object, ...], str] = {}
    places = ((name, part) for name, whole in signals.items() for part in (whole, *whole.added))
    for name, source in places:
        # without a field the signal selects it, but all of a pressure topic is one field
        field = source.field or ('' if name in PRESSURES or not source.topic else name)
        place = source.topic, field, source.column
        if (other := seen.setdefault(place, name)) != name:
            text = source.topic or f'column {source.column!r}'
            raise RigError(f'{where}: {name} and {other} are both {text}')


def _source(entry: object, where: str, in_bag: bool, signal: str) -> Source:
    """Return a signal's entry; a bare name or number stands for its column or topic."""
    if isinstance(entry, list):
        return _sum(entry, where, in_bag, signal)
    key, allowed = ('topic', _TOPIC) if in_bag else ('column', _SIGNAL)
    fields = _fields(entry, where, key, allowed)
    if key not in fields:
        raise RigError(f'{where}: missing {key}')
    if 'gauge' in fields and signal not in PRESSURES:
        raise RigError(f'{where}: gauge is for pressures only')
    return Source(**fields)


def _sum(entries: list[object], where: str, in_bag: bool, signal: str) -> Source:
    """Return the entry of a force that is the sum of several columns."""
    if in_bag or signal != 'force' or not entries or any(isinstance(e, list) for e in entries):
        raise RigError(f'{where}: a list is for the columns of a table that add up to the force')
    first, *others = (
        _source(entry, f'{where}[{number}]', in_bag, signal)
        for number, entry in enumerate(entries, start=1)
    )
    return replace(first, added=tuple(others))


def _time(entry: object, where: str, in_bag: bool) -> tuple[Source | None, float | None]:
    """Return the column of the time, or the sampling interval [s]; neither in a bag."""
    if in_bag:
        if entry is not None:
            raise RigError(f'{where}: not for a bag, whose messages are stamped')
        return None, None
    if entry is None:
        raise RigError(f'{where}: missing; name its column and unit, or give {{rate: 862 Hz}}')
    fields = _fields(entry, where, 'column', _TIME)
    given = [key for key in ('column', 'rate', 'interval') if key in fields]
    if len(given) != 1:
        raise RigError(f'{where}: give one of column, rate, interval')
    (key,) = given
    if key == 'column':
        return Source(**fields), None
    if 'unit' in fields:
        raise RigError(f'{where}: unit is for a column; write {key}: 862 Hz or 1.16 ms')
    value = convert(fields[key], 'Hz' if key == 'rate' else 's', f'{where}.{key}')
    if value <= 0:
        raise RigError(f'{where}.{key}: {fields[key]!r}, must be positive')
    return None, 1.0 / value if key == 'rate' else value


def _fields(entry: object, where: str, key: str, allowed: tuple[str, ...]) -> dict[str, Any]:
    """Return the fields of an entry, checked; a bare value is that of the key."""
    fields = mapping_of(entry if isinstance(entry, dict) else {key: entry}, allowed, where)
    for name, value in fields.items():
        kinds, words = _KINDS.get(name, ((object,), ''))
        # True is an int in Python, but no number here.
        if not isinstance(value, kinds) or (isinstance(value, bool) and int in kinds):
            raise RigError(f'{where}.{name}: {value!r} is not {words}')
    column = fields.get('column')
    if isinstance(column, int) and column < 1:
        raise RigError(f'{where}.column: {column}, columns are counted from 1')
    return fields


def _layout(data: dict[str, Any], origin: str) -> Layout:
    given = {key: data[key] for key in _LAYOUT if key in data}
    for key, value in given.items():
        is_valid, allowed = _LAYOUT[key]
        if not is_valid(value):
            raise RigError(f'{origin}: {key} {value!r}, {allowed}')
    if 'separator' in given:
        given['separator'] = SEPARATORS[given['separator']]
    if given.get('decimal') == ',' and given.get('separator') == ',':
        raise RigError(f'{origin}: a comma cannot be both separator and decimal sign')
    if not isinstance(given.get('header'), bool):
        given['header'] = None
    return Layout(**given)


def in_si(
    values: Floats, signal: str, source: Source, text: str, where: str, zero: float
) -> tuple[Floats, bool]:
    """
    Return values of a source in SI units, absolute pressures, and whether they were gauge.

    :param text: the unit of the values before scaling, as written
    :param zero: pressure of the surroundings [Pa]
    """
    unit = _unit_of(source, text, signal, where)
    with np.errstate(over='ignore'):  # the recording reports values that are not finite
        converted = values * unit.factor
    if source.scale is not None and not isinstance(source.scale, str):
        converted = converted * source.scale
    if None not in (unit.gauge, source.gauge) and unit.gauge != source.gauge:
        raise RigError(
            f'{where}: the unit says {"gauge" if unit.gauge else "absolute"}, '
            f'gauge: {str(source.gauge).lower()} says the opposite'
        )
    if source.offset is not None:
        converted = converted + convert(source.offset, SIGNALS[signal], f'{where}.offset')
    gauge = bool(unit.gauge if source.gauge is None else source.gauge)
    return (converted + zero if gauge else converted), gauge


def _unit_of(source: Source, text: str, signal: str, where: str) -> Unit:
    """Return the unit of the values; a scale such as '50 N/V' is worked into its factor."""
    if not isinstance(source.scale, str):
        return parse_unit(text, SIGNALS[signal], where)
    number, _, scale_unit = source.scale.strip().partition(' ')
    factor = convert(f'{number} -', '-', f'{where}.scale')
    product = parse_unit(f'({scale_unit or "1"})*({text})', SIGNALS[signal], f'{where}.scale')
    return product._replace(factor=product.factor * factor)
