"""Converts the values of a column or topic to SI units and absolute pressures by a mapping."""

from __future__ import annotations

from collections.abc import Mapping

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.mapping import Source
from pneu_rig_ros.records.recording import PRESSURES, SIGNALS, Floats
from pneu_rig_ros.records.units import Unit, convert, parse_unit, scaled

LIKELY_GAUGE = 5e4
"""An absolute pressure below this is probably a gauge pressure [Pa]."""


def in_si(
    values: Floats, signal: str, source: Source, unit: Unit, where: str, zero: float
) -> tuple[Floats, bool]:
    """
    Return values of a source in SI units, absolute pressures, and whether they were gauge.

    :param unit: of the values before scaling
    :param zero: pressure of the surroundings [Pa]
    """
    si_unit = SIGNALS[signal]
    converted = scaled(values, unit)
    if source.scale is not None and not isinstance(source.scale, str):
        converted = converted * source.scale
    gauge = unit.gauge if source.gauge is None else source.gauge
    if unit.gauge is not None and source.gauge not in (None, unit.gauge):
        raise RigError(
            f'{where}: the unit says {"gauge" if unit.gauge else "absolute"}, '
            f'gauge: {str(source.gauge).lower()} says the opposite'
        )
    if source.offset is not None:
        converted = converted + convert(source.offset, si_unit, f'{where}.offset')
    return (converted + zero, True) if gauge else (converted, False)


def unit_of(source: Source, text: str, signal: str, where: str) -> Unit:
    """
    Return the unit of a source's values; a scale such as '50 N/V' is worked into the factor.

    :param text: the unit as written
    """
    if not isinstance(source.scale, str):
        return parse_unit(text, SIGNALS[signal], where)
    number, _, scale_unit = source.scale.strip().partition(' ')
    factor = convert(f'{number} -', '-', f'{where}.scale')
    product = parse_unit(f'({scale_unit or "1"})*({text})', SIGNALS[signal], f'{where}.scale')
    return product._replace(factor=product.factor * factor)


def low_pressures(signals: Mapping[str, Floats]) -> tuple[str, ...]:
    """Return a note for each absolute pressure that is so low that it may be gauge."""
    return tuple(
        f'{name} goes down to {signals[name].min():.4g} Pa absolute: is it gauge?'
        for name in PRESSURES
        if name in signals and signals[name].min() < LIKELY_GAUGE
    )
