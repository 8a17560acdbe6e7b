"""Cylinder axis not level: gravity acts along the stroke."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2], ISO 80000-3."""


class Parameters(NamedTuple):
    """Angle of the axis."""

    angle: Annotated[float, Quantity('rad', -1.6, 1.6, 'rise of the axis along the outstroke')]


@Effect(
    title='cylinder axis is inclined',
    balance=Balance.FORCE,
    regimes=tuple(Regime),
    source='Newton, weight along the axis',
    null=Parameters(0.0),
    probes=((-0.3,), (-0.05,), (0.05,), (0.3,)),
    drivers=('position',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the weight along the outstroke [N] and no added mass."""
    mass = model.cylinder.moving_mass + model.operation.load_mass
    return -mass * STANDARD_GRAVITY * math.sin(parameters.angle), 0.0
