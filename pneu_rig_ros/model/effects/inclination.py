"""Cylinder axis not level: gravity acts along the stroke."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2], ISO 80000-3."""


class Parameters(NamedTuple):
    """Angle of the axis."""

    angle: Annotated[float, Quantity('rad', -1.6, 1.6, 'rise of the axis along the outstroke')]


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """Return the weight along the outstroke [N] and no added mass."""
    mass = model.cylinder.moving_mass + model.operation.load_mass
    return -mass * STANDARD_GRAVITY * math.sin(parameters.angle), 0.0


EFFECT = Effect(
    title='cylinder axis is inclined',
    balance=Balance.FORCE,
    regimes=tuple(Regime),
    source='Newton, weight along the axis',
    null=Parameters(0.0),
    contribution=contribution,
    probes=(Parameters(-0.3), Parameters(-0.05), Parameters(0.05), Parameters(0.3)),
    drivers=('position',),
)
