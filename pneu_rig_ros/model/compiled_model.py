"""
What compiled code takes: the parameters, derived constants worked out, and the signals.

Lists are arrays, and the effects are one table. As a tuple of tuples each function of the plant
would hand on every one of their parameters by value, which took longer to compile than what the
functions do.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.parameters import Cylinder, Friction, Gas, Model, Operation, Valve


class Air(NamedTuple):
    """``Gas`` with what follows from it, so that no power is taken twice."""

    atmospheric_pressure: float
    supply_temperature: float
    heat_capacity_ratio: float
    gas_constant: float
    critical_ratio: float
    choked_coefficient: float
    flow_scale: float


Pair = tuple[float, float]
"""What an effect contributes, see ``effect.Balance``."""

NO_EFFECTS = np.empty((0, 0))


class CompiledModel(NamedTuple):
    """
    ``Model`` for compiled code, with the effects of the plant.

    ``friction.element_*`` are arrays of shape (n,), (n - 1,); ``effects`` has a row for each
    effect, see ``shape.rows``, shape (m, w).
    """

    cylinder: Cylinder
    friction: Friction
    valve: Valve
    gas: Air
    operation: Operation
    effects: Floats


def air(gas: Gas) -> Air:
    """
    Return the gas with its flow constants (Eq. 3-5).

    Critical pressure ratio ``(2/(k+1))^(k/(k-1))`` [-], the exact choked coefficient
    ``(2/(k+1))^((k+1)/(2(k-1)))`` [-] (printed as 0.58), and ``sqrt(k/(R T_s))`` [s/m].
    """
    k = gas.heat_capacity_ratio
    base = 2.0 / (k + 1.0)
    critical = base ** (k / (k - 1.0))
    choked = base ** (0.5 * (k + 1.0) / (k - 1.0))
    scale = math.sqrt(k / (gas.gas_constant * gas.supply_temperature))
    return Air(*gas, critical, choked, scale)


def compiled_model(model: Model, effects: Floats = NO_EFFECTS) -> CompiledModel:
    """Return the model for compiled code."""
    _, law, valve, gas, operation = model
    arrays: dict[str, Any] = {
        'element_stiffness': np.array(law.element_stiffness, dtype=np.float64),
        'element_limit': np.array(law.element_limit, dtype=np.float64),
    }
    law = law._replace(**arrays)
    return CompiledModel(model.cylinder, law, valve, air(gas), operation, effects)


class Motion(NamedTuple):
    """Position [m] and velocity [m/s] of the piston."""

    position: float
    velocity: float


class ChamberGas(NamedTuple):
    """Absolute pressures [Pa], volumes [m^3] and gas masses [kg] of the chambers."""

    pressure_1: float
    pressure_2: float
    volume_1: float
    volume_2: float
    gas_mass_1: float
    gas_mass_2: float


class Ports(NamedTuple):
    """
    Control voltages [V] and supply pressures [Pa, absolute] of the valves.

    The commanded voltages and the supply pressures of the regulator; for ``MASS`` and ``HEAT``
    both as they are at the ports, the contributions to ``SPOOL`` and ``SUPPLY`` in them
    (``SUPPLY`` sees the voltages at the ports).
    """

    voltage_1: float
    voltage_2: float
    supply_1: float
    supply_2: float


class Seal(NamedTuple):
    """
    Bristle deflection [m] and force F(z) [N], whether the piston rests, dwell [s], levels [N].

    ``bristle_force`` has, for ``LEVEL`` and later ones, the contributions to ``BRISTLE`` in it.
    ``dwell_time`` is the dwell that static friction stands for under the reading of Eq. 16;
    latched at breakaway, it is the time at rest so far while the piston sticks, and the dwell
    before the last breakaway while it slides; fading while sliding, it is the dwell that would
    give what is left of F_s. ``coulomb_force`` and ``static_force`` are F_c and F_smax of the law;
    for ``LEVEL`` with what the earlier stages add.
    """

    deflection: float
    bristle_force: float
    sticking: bool
    dwell_time: float
    coulomb_force: float
    static_force: float


class Signals(NamedTuple):
    """
    What a contribution may use besides the parameters; all scalars, SI units.

    Readings see only time and state: for them voltages, bristle force, dwell and levels are NaN.
    """

    time: float
    motion: Motion
    gas: ChamberGas
    ports: Ports
    seal: Seal


@compiled
def behind_spools(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals with the voltages that stages of ``SPOOL`` leave that add so much [V]."""
    s, old = signals, signals.ports
    ports = Ports(old.voltage_1 + first, old.voltage_2 + second, old.supply_1, old.supply_2)
    return Signals(s.time, s.motion, s.gas, ports, s.seal)


@compiled
def behind_supply(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals with the supply pressures to which ``SUPPLY`` adds so much [Pa]."""
    s, old = signals, signals.ports
    ports = Ports(old.voltage_1, old.voltage_2, old.supply_1 + first, old.supply_2 + second)
    return Signals(s.time, s.motion, s.gas, ports, s.seal)


@compiled
def behind_bristles(signals: Signals, force: float) -> Signals:
    """Return the signals with the F(z) to which ``BRISTLE`` adds so much [N]."""
    s, (z, bristles, sticking, dwell, coulomb, static) = signals, signals.seal
    seal = Seal(z, bristles + force, sticking, dwell, coulomb, static)
    return Signals(s.time, s.motion, s.gas, s.ports, seal)


@compiled
def behind_levels(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals with the forces that stages of ``LEVEL`` leave that add so much [N]."""
    s, (z, bristles, sticking, dwell, coulomb, static) = signals, signals.seal
    seal = Seal(z, bristles, sticking, dwell, coulomb + first, static + second)
    return Signals(s.time, s.motion, s.gas, s.ports, seal)
