"""
The parameters as compiled code takes them: lists as arrays, derived constants worked out.

Those of the effects are one array. As a tuple of tuples each function of the plant would hand on
every one of them by value, which took longer to compile than what the functions do.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Flags, Floats
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


class CompiledEffects(NamedTuple):
    """
    The optional effects of a plant.

    :param values: parameters of all effects, one after the other, shape (n,)
    :param acting: which effects act, shape (m,)
    :param shapes: a row an effect, see ``shape.rows``, shape (m, w)
    """

    values: Floats
    acting: Flags
    shapes: Floats


NO_EFFECTS = CompiledEffects(np.empty(0), np.empty(0, dtype=np.bool_), np.empty((0, 0)))


class CompiledModel(NamedTuple):
    """
    ``Model`` for compiled code, with the effects of the plant.

    ``friction.element_*`` are arrays of shape (n,), (n - 1,).
    """

    cylinder: Cylinder
    friction: Friction
    valve: Valve
    gas: Air
    operation: Operation
    effects: CompiledEffects


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


def compiled_model(model: Model, effects: CompiledEffects = NO_EFFECTS) -> CompiledModel:
    """Return the model for compiled code."""
    _, law, valve, gas, operation = model
    arrays: dict[str, Any] = {
        'element_stiffness': np.array(law.element_stiffness, dtype=np.float64),
        'element_limit': np.array(law.element_limit, dtype=np.float64),
    }
    law = law._replace(**arrays)
    return CompiledModel(model.cylinder, law, valve, air(gas), operation, effects)
