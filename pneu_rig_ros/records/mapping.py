"""
The mapping file: where the signals are in a table or bag of another rig, and their units.

For a table (CSV and its relatives)::

    separator: ';'                  # ',', ';', tab, blank; detected if omitted
    decimal: ','                    # '.' or ','; detected if omitted
    comment: '#'                    # lines that begin with it are skipped
    skip_rows: 0                    # lines before the header
    skip_after_header: 0            # lines between header and data, e.g. of units
    header: auto                    # true, false, or auto
    time: {column: 't [ms]', unit: ms}          # or {rate: 862 Hz}, {interval: 1.16 ms},
                                                # or {column: stamp, unit: datetime}
    position: {column: 5, unit: mm}             # a name, or a number counted from 1
    pressure_1: {column: p1, unit: bar, gauge: true}
    force: {column: ai0, unit: V, scale: 50 N/V, offset: -3 N}

For a bag, the signals stand under ``topics`` and name a topic and a field of its messages::

    topics:
      position: {topic: /axis/state, field: 'position[0]'}
      pressure_1: {topic: /cap/pressure, unit: bar, gauge: true, field: data}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS
from pneu_rig_ros.records.units import convert
from pneu_rig_ros.rig.yaml_file import parse_yaml, read_text

SEPARATORS = {
    ',': ',',
    ';': ';',
    '\t': '\t',
    ' ': ' ',
    'comma': ',',
    'semicolon': ';',
    'tab': '\t',
    'blank': ' ',
    'space': ' ',
}
"""What a mapping may call a separator -> the separator."""

DATETIME = 'datetime'
"""Unit of a time column that holds date and time of day."""

_LAYOUT = ('separator', 'decimal', 'comment', 'skip_rows', 'skip_after_header', 'header')
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
    """

    column: str | int | None = None
    unit: str | None = None
    gauge: bool | None = None
    scale: str | float | None = None
    offset: str | None = None
    topic: str = ''
    field: str = ''


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


def read_mapping(source: Path | str | Mapping[str, Any] | TableMapping) -> TableMapping:
    """
    Return a mapping from a YAML file, or from what such a file would hold.

    :raises RigError: for a name or a key that is not known, or a value of a wrong kind
    """
    if isinstance(source, TableMapping):
        return source
    if isinstance(source, Mapping):
        return _checked(dict(source), 'mapping')
    data = parse_yaml(read_text(source), str(source))
    if not isinstance(data, dict):
        raise RigError(f'{source}: expected a mapping of signals: {", ".join(SIGNALS)}')
    return _checked(data, str(source))


def _checked(data: dict[str, Any], origin: str) -> TableMapping:
    allowed = ['time', *SIGNALS, *_LAYOUT, 'atmospheric_pressure', 'topics']
    for key in data:
        if key not in allowed:
            raise RigError(f'{origin}: {unknown(str(key), allowed)}')
    in_bag = 'topics' in data
    where, entries = (f'{origin}: topics', data['topics']) if in_bag else (origin, data)
    if in_bag and not isinstance(entries, dict):
        raise RigError(f'{where}: expected a mapping of signals: {", ".join(SIGNALS)}')
    for key in entries if in_bag else ():
        if key not in SIGNALS:
            raise RigError(f'{where}: {unknown(str(key), SIGNALS)}')
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
    for name, source in signals.items():
        # without a field the signal selects it, but all of a pressure topic is one field
        field = source.field or ('' if name in PRESSURES or not source.topic else name)
        place = source.topic, field, source.column
        if (other := seen.setdefault(place, name)) != name:
            text = source.topic or f'column {source.column!r}'
            raise RigError(f'{where}: {name} and {other} are both {text}')


def _source(entry: object, where: str, in_bag: bool, signal: str) -> Source:
    """Return a signal's entry; a bare name or number stands for its column or topic."""
    key, allowed = ('topic', _TOPIC) if in_bag else ('column', _SIGNAL)
    fields = _entry(entry, where, key, allowed)
    if key not in fields:
        raise RigError(f'{where}: missing {key}')
    _check_kinds(fields, where)
    if 'gauge' in fields and signal not in PRESSURES:
        raise RigError(f'{where}: gauge is for pressures only')
    return Source(**fields)


def _time(entry: object, where: str, in_bag: bool) -> tuple[Source | None, float | None]:
    if in_bag:
        if entry is not None:
            raise RigError(f'{where}: not for a bag, whose messages are stamped')
        return None, None
    if entry is None:
        raise RigError(f'{where}: missing; name its column and unit, or give {{rate: 862 Hz}}')
    fields = _entry(entry, where, 'column', _TIME)
    given = [key for key in ('column', 'rate', 'interval') if key in fields]
    if len(given) != 1:
        raise RigError(f'{where}: give one of column, rate, interval')
    if 'column' in fields:
        _check_kinds(fields, where)
        return Source(**fields), None
    if 'unit' in fields:
        raise RigError(f'{where}: unit is for a column; write {given[0]}: 862 Hz or 1.16 ms')
    rate = given[0] == 'rate'
    value = convert(fields[given[0]], 'Hz' if rate else 's', f'{where}.{given[0]}')
    if value <= 0:
        raise RigError(f'{where}.{given[0]}: {fields[given[0]]!r}, must be positive')
    return None, 1.0 / value if rate else value


def _entry(entry: object, where: str, key: str, allowed: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(entry, dict):
        entry = {key: entry}
    for name in entry:
        if name not in allowed:
            raise RigError(f'{where}: {unknown(str(name), allowed)}')
    return entry


def _check_kinds(fields: dict[str, Any], where: str) -> None:
    kinds: dict[str, tuple[type, ...]] = {
        'column': (str, int),
        'unit': (str,),
        'gauge': (bool,),
        'scale': (str, int, float),
        'offset': (str,),
        'topic': (str,),
        'field': (str,),
    }
    for key, value in fields.items():
        boolean = isinstance(value, bool) and bool not in kinds[key]
        if boolean or not isinstance(value, kinds[key]):
            names = ' or '.join(_WORDS[kind] for kind in kinds[key] if kind is not float)
            raise RigError(f'{where}.{key}: {value!r} is not {names}')
    column = fields.get('column')
    if isinstance(column, int) and column < 1:
        raise RigError(f'{where}.column: {column}, columns are counted from 1')


_WORDS = {str: 'a text', int: 'a number', bool: 'true or false'}


def _layout(data: dict[str, Any], origin: str) -> Layout:
    given = {key: data[key] for key in _LAYOUT if key in data}
    if 'separator' in given:
        if given['separator'] not in SEPARATORS:
            names = "',', ';', tab, blank"
            raise RigError(f'{origin}: separator {given["separator"]!r}, allowed: {names}')
        given['separator'] = SEPARATORS[given['separator']]
    if given.get('decimal', '.') not in ('.', ','):
        raise RigError(f"{origin}: decimal {given['decimal']!r}, allowed: '.', ','")
    if given.get('decimal') == ',' and given.get('separator') == ',':
        raise RigError(f'{origin}: a comma cannot be both separator and decimal sign')
    header = given.get('header')
    if header not in (None, 'auto', True, False):
        raise RigError(f'{origin}: header {header!r}, allowed: true, false, auto')
    given['header'] = header if isinstance(header, bool) else None
    comment = given.setdefault('comment', '#')
    if not isinstance(comment, str):
        raise RigError(f'{origin}: comment {comment!r} is not a text')
    for key in ('skip_rows', 'skip_after_header'):
        value = given.get(key, 0)
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise RigError(f'{origin}: {key} {value!r}, must be a number of lines')
    return Layout(**given)
