"""
Free shapes: an effect of another functional form, as a factor that varies over one variable.

The factor multiplies what the effect contributes. It is linear between knots and constant beyond
them. Over a variable of a chamber each of the two contributions has the factor of its own.

:func:`rows` makes the table of all effects that compiled code reads: whether each acts, its shape,
its parameters.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled import called, compiled
from pneu_rig_ros.model.compiled_model import Air, Signals
from pneu_rig_ros.model.effect import Effect
from pneu_rig_ros.model.quantity import (
    Quantity,
    QuantityList,
    read_section,
    unknown,
    write_section,
)
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

KNOTS = 8
"""Knots of a shape, at most."""
FACTOR = Quantity('-', 0.01, 100.0, 'factor at a knot')
SIGNED = Quantity(
    '-', -1e6, 1e6, 'factor at a knot of an empirical term, which may change its sign'
)
DRIVERS: dict[str, Quantity] = {
    'position': Quantity('m', -1.0, 100.0, 'x'),
    'velocity': Quantity('m/s', -100.0, 100.0, 'v'),
    'speed': Quantity('m/s', 0.0, 100.0, '|v|'),
    'pressure_1': Quantity('Pa', 0.0, 1e8, 'p1, absolute'),
    'pressure_2': Quantity('Pa', 0.0, 1e8, 'p2, absolute'),
    'difference': Quantity('Pa', 0.0, 1e8, '|p1 - p2|'),
    'dwell': Quantity('s', 0.0, 1e9, 'the dwell that static friction stands for'),
    'time': Quantity('s', 0.0, 1e9, 'since the start'),
    'pressure': Quantity('Pa', 0.0, 1e8, 'pressure of its own chamber, absolute'),
    'temperature': Quantity('K', 0.0, 1e4, 'temperature of the gas in its own chamber'),
    'opening': Quantity('V', -10.0, 10.0, 'voltage of its own valve, from the centre'),
}
"""What a factor may vary over; compiled code knows them by their place."""


class Shape(NamedTuple):
    """
    A factor, linear between knots.

    :param over: name of one of ``DRIVERS``
    :param at: where the knots are, increasing [unit of the driver]
    :param times: the factor at each knot [-]
    """

    over: str
    at: tuple[float, ...]
    times: tuple[float, ...]


class Shaped(NamedTuple):
    """Parameters of an effect with a shape, in place of the parameters alone."""

    parameters: Any
    shape: Shape


def without_shape(own: Any) -> Any:
    """Return the parameters of an effect, with or without a shape."""
    return own.parameters if isinstance(own, Shaped) else own


def with_values(own: Any, values: Mapping[str, float]) -> Any:
    """Return the parameters of an effect with other values, and the shape they had."""
    parameters = without_shape(own)._replace(**values)
    return own._replace(parameters=parameters) if isinstance(own, Shaped) else parameters


def read_effect(effect: Effect, values: object, where: str) -> Any:
    """
    Build the parameters of an effect from a YAML mapping, with or without a ``shape``.

    :raises RigError: as :func:`read_section`
    """
    if not (isinstance(values, dict) and 'shape' in values):
        return read_section(effect.parameters, values, where)
    own = {key: value for key, value in values.items() if key != 'shape'}
    parameters = read_section(effect.parameters, own, where)
    return Shaped(parameters, _read(values['shape'], effect, f'{where}.shape'))


def write_effect(own: Any) -> dict[str, Any]:
    """Return the YAML mapping that :func:`read_effect` reads back."""
    values = write_section(without_shape(own))
    if isinstance(own, Shaped):
        over, at, times = own.shape
        knots = [DRIVERS[over].format(value) for value in at]
        values['shape'] = {'over': over, 'at': knots, 'times': list(times)}
    return values


def _read(values: object, effect: Effect, where: str) -> Shape:
    if not isinstance(values, dict) or set(values) != set(Shape._fields):
        raise RigError(f'{where}: expected a mapping with {", ".join(Shape._fields)}')
    over = _driver(values['over'], effect, where)
    at = QuantityList(DRIVERS[over], KNOTS).parse(values['at'], f'{where}.at')
    times = values['times']
    if not isinstance(times, list) or any(type(one) not in (int, float) for one in times):
        raise RigError(f'{where}.times: expected a list of numbers')
    shape = Shape(over, at, tuple(float(one) for one in times))
    check(shape, effect, where)
    return shape


def _driver(name: object, effect: Effect, where: str) -> str:
    if name not in effect.drivers:
        raise RigError(f'{where}.over: {unknown(str(name), effect.drivers)}')
    return str(name)


def check(shape: Shape, effect: Effect, where: str) -> None:
    """Raise :class:`RigError` unless the shape is one that the effect can have."""
    _driver(shape.over, effect, where)
    if not 2 <= len(shape.at) <= KNOTS or any(np.diff(shape.at) <= 0.0):
        raise RigError(f'{where}.at: expected 2 to {KNOTS} increasing values')
    if len(shape.times) != len(shape.at):
        raise RigError(f'{where}.times: {len(shape.times)} factors for {len(shape.at)} knots')
    for number, factor in enumerate(shape.times):
        (SIGNED if effect.describes else FACTOR).check(factor, f'{where}.times[{number}]')


ACTS, COUNT, OVER, FIRST = range(4)
"""
An effect in compiled code: whether it acts; number of knots of its shape, none for no shape;
driver; knots, then factors; then the parameters.
"""
VALUES = FIRST + 2 * KNOTS


def rows(effects: Iterable[tuple[str, Effect, Any]]) -> Floats:
    """
    Return the effects for compiled code, one row each.

    :param effects: name, record and parameters of each effect
    :raises RigError: for a shape that the effect cannot have
    """
    chosen = list(effects)
    most = max((len(effect.null) for _, effect, _ in chosen), default=0)
    table = np.zeros((len(chosen), VALUES + most))
    for row, (name, effect, own) in zip(table, chosen, strict=True):
        parameters = without_shape(own)
        if parameters != effect.null:  # else nothing reads them
            row[ACTS] = 1.0
            row[VALUES : VALUES + len(parameters)] = parameters
        if isinstance(own, Shaped):
            check(own.shape, effect, f'effects.{name}.shape')
            over, at, times = own.shape
            row[COUNT], row[OVER] = len(at), list(DRIVERS).index(over)
            row[FIRST : FIRST + len(at)] = at
            row[FIRST + KNOTS : FIRST + KNOTS + len(at)] = times
    return table


@compiled
def _common(driver: int, s: Signals) -> float:
    """Return a driver of both contributions; the order is that of ``DRIVERS``."""
    if driver == 0:
        return s.motion.position
    if driver == 1:
        return s.motion.velocity
    if driver == 2:
        return abs(s.motion.velocity)
    if driver == 3:
        return s.gas.pressure_1
    if driver == 4:
        return s.gas.pressure_2
    if driver == 5:
        return abs(s.gas.pressure_1 - s.gas.pressure_2)
    return s.seal.dwell_time if driver == 6 else s.time


@compiled
def _own(
    driver: int, pressure: float, volume: float, gas_mass: float, voltage: float, gas: Air
) -> float:
    """Return a driver of one chamber and its valve."""
    if driver == 8:
        return pressure
    if driver == 9:
        return chambers.temperature(pressure, volume, gas_mass, gas)
    return voltage - CENTRE_VOLTAGE


@called
def _factor(row: Floats, value: float) -> float:
    count = int(row[COUNT])
    at, times = row[FIRST : FIRST + count], row[FIRST + KNOTS : FIRST + KNOTS + count]
    if value <= at[0]:
        return float(times[0])
    for i in range(1, count):
        if value < at[i]:
            share = (value - at[i - 1]) / (at[i] - at[i - 1])
            return float(times[i - 1] + share * (times[i] - times[i - 1]))
    return float(times[count - 1])


@called
def factors(row: Floats, s: Signals, gas: Air) -> tuple[float, float]:
    """Return the factors of both contributions of an effect with the shape of a row."""
    driver = int(row[OVER])
    if driver < 8:
        factor = _factor(row, _common(driver, s))
        return factor, factor
    own, ports = s.gas, s.ports
    first = _own(driver, own.pressure_1, own.volume_1, own.gas_mass_1, ports.voltage_1, gas)
    second = _own(driver, own.pressure_2, own.volume_2, own.gas_mass_2, ports.voltage_2, gas)
    return _factor(row, first), _factor(row, second)
