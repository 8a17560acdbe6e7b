"""
Empirical terms: what describes a gap that no cause explains, and can still be simulated.

A term is a simple function of the signals, and a description a sum of terms with a coefficient
each. ``TERMS`` says what each term is, ``OUTPUTS`` which of them may be added to what. One effect
for each balance is made of the two; ``values`` evaluates the same terms along a recording, so
that a residual can be regressed on exactly what the plant can simulate (``empirical_effects``).

Pressures are above atmosphere and count in units of 5 bar, positions in strokes, speeds in
0.1 m/s, voltages in volts from the centre, masses in kg: units that no run changes, so that one
coefficient holds for runs at different supply pressures.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Signals
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

PRESSURE, SPEED = 5e5, 0.1
"""Units of pressures [Pa] and speeds [m/s]."""
TURN = 1e-3
"""Speed over which the direction turns round [m/s]."""
SLOW = 0.015
"""Speed over which friction leaves its level at rest [m/s]."""


@compiled
def gauge(pressure: float, model: CompiledModel) -> float:
    """Return a pressure [Pa] above atmosphere, in units of ``PRESSURE``."""
    return (pressure - model.gas.atmospheric_pressure) / PRESSURE


@compiled
def cold(pressure: float, volume: float, gas_mass: float, model: CompiledModel) -> float:
    """Return by what share the gas is colder than the supply [-]."""
    temperature = pressure * volume / (gas_mass * model.gas.gas_constant)
    return 1.0 - temperature / model.gas.supply_temperature


@compiled
def direction(s: Signals, model: CompiledModel) -> Any:
    """Return the sign of the velocity without a jump; at rest that of the bristle force."""
    bent = 2.0 * s.seal.bristle_force / model.friction.coulomb_force
    resting = np.minimum(np.maximum(bent, -1.0), 1.0)
    return (s.motion.velocity + TURN * resting) / (abs(s.motion.velocity) + TURN)


@compiled
def slowness(velocity: float) -> Any:
    """Return 1 at rest, falling to 0 with the speed."""
    return np.exp(-abs(velocity) / SLOW)


@compiled
def near_end(position: float, model: CompiledModel) -> Any:
    """Return 1 at both ends of the stroke, and nearly 0 away from them."""
    return (2.0 * position / model.cylinder.stroke - 1.0) ** 8


class Term(NamedTuple):
    """What a coefficient is multiplied with: a signal, or its integral over time."""

    text: str
    signal: Callable[[Signals, CompiledModel], Any]
    integrated: bool = False


TERMS: dict[str, Term] = {
    'constant': Term('1', lambda s, m: 1.0),
    'position': Term('x/L', lambda s, m: s.motion.position / m.cylinder.stroke),
    'position_squared': Term('(x/L)^2', lambda s, m: (s.motion.position / m.cylinder.stroke) ** 2),
    'gauge_1': Term('gauge p1, per 5 bar', lambda s, m: gauge(s.gas.pressure_1, m)),
    'gauge_2': Term('gauge p2, per 5 bar', lambda s, m: gauge(s.gas.pressure_2, m)),
    'difference': Term(
        'p1 - p2, per 5 bar', lambda s, m: (s.gas.pressure_1 - s.gas.pressure_2) / PRESSURE
    ),
    'velocity': Term('v, per 0.1 m/s', lambda s, m: s.motion.velocity / SPEED),
    'speed': Term('|v|, per 0.1 m/s', lambda s, m: abs(s.motion.velocity) / SPEED),
    'slow': Term('exp(-|v|/15 mm/s)', lambda s, m: slowness(s.motion.velocity)),
    'direction': Term('the direction', direction),
    'direction_position': Term(
        'the direction, and x/L',
        lambda s, m: direction(s, m) * s.motion.position / m.cylinder.stroke,
    ),
    'direction_gauge_1': Term(
        'the direction, and gauge p1, per 5 bar',
        lambda s, m: direction(s, m) * gauge(s.gas.pressure_1, m),
    ),
    'direction_gauge_2': Term(
        'the direction, and gauge p2, per 5 bar',
        lambda s, m: direction(s, m) * gauge(s.gas.pressure_2, m),
    ),
    'direction_slow': Term(
        'the direction, and exp(-|v|/15 mm/s)',
        lambda s, m: direction(s, m) * slowness(s.motion.velocity),
    ),
    'ends': Term(
        '(2x/L - 1)^9',
        lambda s, m: (
            near_end(s.motion.position, m) * (2.0 * s.motion.position / m.cylinder.stroke - 1.0)
        ),
    ),
    'ends_velocity': Term(
        'v (2x/L - 1)^8, per 0.1 m/s',
        lambda s, m: near_end(s.motion.position, m) * s.motion.velocity / SPEED,
    ),
    'mass': Term(
        'all that moves, in kg', lambda s, m: m.cylinder.moving_mass + m.operation.load_mass
    ),
    'cold_1': Term(
        '(T_s - T_1)/T_s', lambda s, m: cold(s.gas.pressure_1, s.gas.volume_1, s.gas.gas_mass_1, m)
    ),
    'cold_2': Term(
        '(T_s - T_2)/T_s', lambda s, m: cold(s.gas.pressure_2, s.gas.volume_2, s.gas.gas_mass_2, m)
    ),
    'intake_1': Term(
        'u1 - 2.5 V where above 0, per volt',
        lambda s, m: np.maximum(s.ports.voltage_1 - CENTRE_VOLTAGE, 0.0),
    ),
    'intake_2': Term(
        'u2 - 2.5 V where above 0, per volt',
        lambda s, m: np.maximum(s.ports.voltage_2 - CENTRE_VOLTAGE, 0.0),
    ),
    'exhaust_1': Term(
        '2.5 V - u1 where above 0, per volt',
        lambda s, m: np.maximum(CENTRE_VOLTAGE - s.ports.voltage_1, 0.0),
    ),
    'exhaust_2': Term(
        '2.5 V - u2 where above 0, per volt',
        lambda s, m: np.maximum(CENTRE_VOLTAGE - s.ports.voltage_2, 0.0),
    ),
    'squared_1': Term(
        '(u1 - 2.5 V)|u1 - 2.5 V|, per V^2',
        lambda s, m: (
            (s.ports.voltage_1 - CENTRE_VOLTAGE) * abs(s.ports.voltage_1 - CENTRE_VOLTAGE)
        ),
    ),
    'squared_2': Term(
        '(u2 - 2.5 V)|u2 - 2.5 V|, per V^2',
        lambda s, m: (
            (s.ports.voltage_2 - CENTRE_VOLTAGE) * abs(s.ports.voltage_2 - CENTRE_VOLTAGE)
        ),
    ),
    'log_dwell': Term('ln(1 + dwell time / 1 s)', lambda s, m: np.log1p(s.seal.dwell_time)),
    'travel': Term(
        'the way gone so far, in strokes',
        lambda s, m: abs(s.motion.velocity) / m.cylinder.stroke,
        integrated=True,
    ),
}


class Output(NamedTuple):
    """
    What terms may be added to.

    :param effect: which of ``EFFECTS`` adds it
    :param parameter: of the effect, made of the name of the term
    :param quantity: of each coefficient
    :param terms: names
    """

    effect: str
    parameter: str
    quantity: Quantity
    terms: tuple[str, ...]

    @property
    def parameters(self) -> dict[str, Quantity]:
        """Parameters of the effect, in the order of the terms."""
        return {
            self.parameter.format(name): replace(
                self.quantity, description=f'{self.quantity.description}, times {TERMS[name].text}'
            )
            for name in self.terms
        }


_GAS = 'constant position gauge_1 gauge_2 difference velocity speed'
_LEVEL = (
    'constant position position_squared gauge_1 gauge_2 difference direction direction_position '
    'direction_gauge_1 direction_gauge_2 log_dwell'
)
_FORCE = 'constant position position_squared gauge_1 gauge_2 difference velocity speed'
OUTPUTS: dict[str, Output] = {
    name: Output(
        f'empirical_{effect}', parameter, Quantity(unit, -most, most, what), tuple(t.split())
    )
    for name, effect, parameter, unit, most, what, t in (
        ('flow_1', 'flow', '{}_1', 'kg/s', 0.01, 'into chamber 1', f'{_GAS} intake_1 exhaust_1'),
        ('flow_2', 'flow', '{}_2', 'kg/s', 0.01, 'into chamber 2', f'{_GAS} intake_2 exhaust_2'),
        ('heat_1', 'heat', '{}_1', 'W', 1e3, 'into chamber 1', 'constant gauge_1 cold_1'),
        ('heat_2', 'heat', '{}_2', 'W', 1e3, 'into chamber 2', 'constant gauge_2 cold_2'),
        (
            *('friction', 'friction', '{}', 'N', 1e3, 'added to F_c and F_smax'),
            f'{_LEVEL} speed slow direction_slow travel',
        ),
        ('static_friction', 'friction', 'static_{}', 'N', 1e3, 'added to F_smax alone', _LEVEL),
        (
            'force',
            'force',
            '{}',
            'N',
            1e3,
            'along the outstroke',
            f'{_FORCE} ends ends_velocity mass',
        ),
        (
            *('voltage_1', 'voltage', '{}_1', 'V', 3.0, 'added to u1'),
            'constant intake_1 exhaust_1 squared_1',
        ),
        (
            *('voltage_2', 'voltage', '{}_2', 'V', 3.0, 'added to u2'),
            'constant intake_2 exhaust_2 squared_2',
        ),
        (
            *('position', 'position_reading', '{}', 'm', 0.1, 'added to the reading of x'),
            'constant position position_squared velocity',
        ),
        (
            *('pressure_1', 'pressure_reading', '{}_1', 'Pa', 1e5, 'added to the reading of p1'),
            'constant gauge_1 velocity',
        ),
        (
            *('pressure_2', 'pressure_reading', '{}_2', 'Pa', 1e5, 'added to the reading of p2'),
            'constant gauge_2 velocity',
        ),
    )
}


def terms(output: str) -> tuple[str, ...]:
    """Return the names of the terms that may be added to an output."""
    return OUTPUTS[output].terms


def values(output: str, signals: Signals, model: CompiledModel) -> Floats:
    """
    Return the terms of an output along a recording, shape (n, terms).

    :param signals: arrays of shape (n,); what no term of the output looks at may be NaN
    """
    given: Any = signals
    columns = []
    for term in map(TERMS.__getitem__, OUTPUTS[output].terms):
        column = term.signal(given, model)
        if term.integrated:  # held from each sample to the next
            column = np.append(0.0, np.cumsum(np.diff(given.time) * column[:-1]))
        columns.append(column)
    size = len(given.motion.position)
    return np.column_stack([np.broadcast_to(column, size) for column in columns])
