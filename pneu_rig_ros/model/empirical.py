"""
Empirical terms: what describes a gap that no cause explains, and can still be simulated.

A term is a simple function of the signals, and a description a sum of terms with a coefficient
each. ``TERMS`` says what each term is, ``OUTPUTS`` which of them may be added to what. One effect
for each balance is made of the two, see ``empirical_effects``.

Pressures are above atmosphere and count in units of 5 bar, positions in strokes, speeds in
0.1 m/s, voltages in volts from the centre, masses in kg: units that no run changes, so that one
coefficient holds for runs at different supply pressures.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Signals
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
    temperature = chambers.temperature(pressure, volume, gas_mass, model.gas)
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


@compiled
def intake(voltage: float) -> float:
    """Return how far a spool is beyond its centre towards the intake [V], else 0."""
    return max(voltage - CENTRE_VOLTAGE, 0.0)


@compiled
def exhaust(voltage: float) -> float:
    """Return how far a spool is beyond its centre towards the exhaust [V], else 0."""
    return max(CENTRE_VOLTAGE - voltage, 0.0)


@compiled
def squared(voltage: float) -> float:
    """Return the square of a voltage from the centre, with its sign [V^2]."""
    return (voltage - CENTRE_VOLTAGE) * abs(voltage - CENTRE_VOLTAGE)


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
    'intake_1': Term('u1 - 2.5 V where above 0, per volt', lambda s, m: intake(s.ports.voltage_1)),
    'intake_2': Term('u2 - 2.5 V where above 0, per volt', lambda s, m: intake(s.ports.voltage_2)),
    'exhaust_1': Term(
        '2.5 V - u1 where above 0, per volt', lambda s, m: exhaust(s.ports.voltage_1)
    ),
    'exhaust_2': Term(
        '2.5 V - u2 where above 0, per volt', lambda s, m: exhaust(s.ports.voltage_2)
    ),
    'squared_1': Term(
        '(u1 - 2.5 V)|u1 - 2.5 V|, per V^2', lambda s, m: squared(s.ports.voltage_1)
    ),
    'squared_2': Term(
        '(u2 - 2.5 V)|u2 - 2.5 V|, per V^2', lambda s, m: squared(s.ports.voltage_2)
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


def _output(
    effect: str, parameter: str, unit: str, most: float, description: str, terms: str
) -> Output:
    quantity = Quantity(unit, -most, most, description)
    return Output(f'empirical_{effect}', parameter, quantity, tuple(terms.split()))


_GAS = 'constant position gauge_1 gauge_2 difference velocity speed'
_LEVEL = (
    'constant position position_squared gauge_1 gauge_2 difference direction direction_position '
    'direction_gauge_1 direction_gauge_2 log_dwell'
)
_FRICTION = f'{_LEVEL} speed slow direction_slow travel'
_FORCE = (
    'constant position position_squared gauge_1 gauge_2 difference velocity speed ends '
    'ends_velocity mass'
)
_POSITION = 'constant position position_squared velocity'
_PRESSURE = 'constant gauge_{} velocity'
_SPOOL = 'constant intake_{0} exhaust_{0} squared_{0}'
OUTPUTS: dict[str, Output] = {
    'flow_1': _output(
        'flow', '{}_1', 'kg/s', 0.01, 'into chamber 1', f'{_GAS} intake_1 exhaust_1'
    ),
    'flow_2': _output(
        'flow', '{}_2', 'kg/s', 0.01, 'into chamber 2', f'{_GAS} intake_2 exhaust_2'
    ),
    'heat_1': _output('heat', '{}_1', 'W', 1e3, 'into chamber 1', 'constant gauge_1 cold_1'),
    'heat_2': _output('heat', '{}_2', 'W', 1e3, 'into chamber 2', 'constant gauge_2 cold_2'),
    'friction': _output('friction', '{}', 'N', 1e3, 'added to F_c and F_smax', _FRICTION),
    'static_friction': _output('friction', 'static_{}', 'N', 1e3, 'added to F_smax alone', _LEVEL),
    'force': _output('force', '{}', 'N', 1e3, 'along the outstroke', _FORCE),
    'voltage_1': _output('voltage', '{}_1', 'V', 3.0, 'added to u1', _SPOOL.format(1)),
    'voltage_2': _output('voltage', '{}_2', 'V', 3.0, 'added to u2', _SPOOL.format(2)),
    'position': _output(
        'position_reading', '{}', 'm', 0.1, 'added to the reading of x', _POSITION
    ),
    'pressure_1': _output(
        'pressure_reading', '{}_1', 'Pa', 1e5, 'added to the reading of p1', _PRESSURE.format(1)
    ),
    'pressure_2': _output(
        'pressure_reading', '{}_2', 'Pa', 1e5, 'added to the reading of p2', _PRESSURE.format(2)
    ),
}
