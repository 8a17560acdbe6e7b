"""Units of laboratories, and their values in SI units."""

from __future__ import annotations

import functools
import math
import re
from typing import TYPE_CHECKING, NamedTuple

from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pint import UnitRegistry

DEFAULT_ATMOSPHERE = 1e5
"""Default atmospheric pressure [Pa], as in ``config/rig.yaml``."""

ALIASES = {'-': 'dimensionless', '"': 'inch', 'lbs': 'lbf', 'lb': 'lbf', 'kgf': 'kilogram_force'}
"""What laboratories write and `pint` takes for something else. A weight is read as a force."""

MASS_ALIASES = {'lbs': 'pound', 'lb': 'pound'}
"""The same where a mass is asked for."""

_TEXT = re.compile(
    r'^\s*(?P<number>[-+]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(?P<unit>[^\d\s].*)$'
)
_REFERENCE = re.compile(
    r'\s*(?:\(?(?P<word>gauge|absolute|abs|rel)\.?\)?|\(?(?P<letter>[ag])\)?)$'
)
LONGEST_UNIT = 60
"""[character]"""

# A number or a bracket to a power, or one that is not a digit: 9**9**9 would never be done.
_POWER = re.compile(
    r'[\d).]\s*(?:\*\*|\^|[⁰¹²³⁴-⁹⁻])|[⁰¹²³⁴-⁹⁻]{3}'
    r'|(?:\*\*|\^)(?!\s*[-+]?\d(?![\d.eE_]|\s*\*\*|\s*\^))'
)
_PRESSURES = ('bar', 'mbar', 'Pa', 'hPa', 'kPa', 'MPa', 'psi', 'ksi')


class Unit(NamedTuple):
    """SI units in a unit; whether its text says gauge (True), absolute (False) or neither."""

    factor: float
    gauge: bool | None


@functools.cache
def parse_unit(text: str, si_unit: str, where: str) -> Unit:
    """
    Read a unit: 'mm', 'bar', 'psia', 'barg', 'kPa gauge', 'kN', 'inch' ...

    :param si_unit: the unit to convert to, e.g. 'Pa'
    :param where: what to call the place in an error
    :raises RigError: for an unknown unit, or one of another quantity
    """
    if len(text) > LONGEST_UNIT or _POWER.search(text):
        raise RigError(
            f'{where}: unit {text!r}: allowed are up to {LONGEST_UNIT} characters, '
            'and powers of names by one digit, such as m^2'
        )
    name, gauge = _reference(text.strip()) if si_unit == 'Pa' else (text.strip(), None)
    if name == si_unit:
        return Unit(1.0, gauge)
    aliases = ALIASES | MASS_ALIASES if si_unit == 'kg' else ALIASES
    registry, target = _registry(), ALIASES.get(si_unit, si_unit)
    try:
        factor = float(registry.Quantity(1.0, aliases.get(name, name)).to(target).m)
    except Exception as error:
        # pint has a dozen errors of its own, and passes on those of its parsers
        raise RigError(f'{where}: {_complaint(text, si_unit, error)}') from None
    return Unit(factor, gauge)


def convert(text: object, si_unit: str, where: str, atmosphere: float | None = None) -> float:
    """
    Return a number with a unit, such as '4 bar gauge' or '5e5 Pa', in SI units.

    :param atmosphere: pressure of the surroundings [Pa], for gauge pressures
    :raises RigError: for another form, another kind of unit, or a gauge pressure without it
    """
    match = _TEXT.match(text) if isinstance(text, str) else None
    if match is None:
        raise RigError(f'{where}: {text!r} is not a number and its unit, such as 1.5 {si_unit}')
    unit = parse_unit(match['unit'], si_unit, where)
    number = as_number(match['number'])
    if not math.isfinite(number):
        raise RigError(f'{where}: {match["number"]!r} is not a finite number')
    value = number * unit.factor
    if not unit.gauge:
        return value
    if atmosphere is None:
        raise RigError(f'{where}: {text!r} is a gauge pressure, allowed are absolute ones')
    return value + atmosphere


def as_number(text: str) -> float:
    """Return a number, NaN if a text is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _reference(text: str) -> tuple[str, bool | None]:
    """Split 'psig' or 'bar (abs)' into the unit and whether it is gauge."""
    match = _REFERENCE.search(text)
    name = text[: match.start()].strip() if match else text
    if match is None or (match['letter'] and name not in _PRESSURES):
        return text, None
    return name, (match['word'] or match['letter']) in ('gauge', 'rel', 'g')


@functools.cache
def _registry() -> UnitRegistry[float]:
    # Loaded when the first unit is not the SI unit itself: it takes a third of a second.
    try:
        import pint
    except ImportError as error:
        raise RigError('units other than SI need the package pint: pip install pint') from error
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def _complaint(text: str, si_unit: str, error: Exception) -> str:
    examples = {
        'Pa': 'bar, kPa, psi, psig',
        'm': 'mm, cm, inch',
        's': 'ms, us, min',
        'N': 'kN, mN, lbf',
        'V': 'mV',
        'kg': 'g, lb',
        'm/s': 'mm/s, inch/s',
    }
    kind = 'of another kind' if type(error).__name__ == 'DimensionalityError' else 'not known'
    example = examples.get(si_unit, si_unit)
    return f'unit {text!r} is {kind}, allowed is {si_unit} or e.g. {example}'
