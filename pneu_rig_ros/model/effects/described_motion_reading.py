"""A description, not a cause: an error of the position sensor that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity

SPEED = 0.1
"""Unit of the term with the velocity [m/s]."""


class Parameters(NamedTuple):
    """Coefficients; positions count in strokes."""

    position: Annotated[float, Quantity('m', -0.1, 0.1, 'times x/L')]
    velocity: Annotated[float, Quantity('m', -0.01, 0.01, 'times v, per 0.1 m/s')]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """
    Return what is added to the readings of position [m] and velocity [m/s].

    The acceleration, of which the velocity would need a share, is not among the signals.
    """
    c, stroke = parameters, model.cylinder.stroke
    position = c.position * signals.position / stroke + c.velocity * signals.velocity / SPEED
    return position, c.position * signals.velocity / stroke


EFFECT = Effect(
    title='an error of the position sensor nobody has named yet',
    balance=Balance.MOTION_READING,
    regimes=(Regime.DWELL, Regime.SLIDING, Regime.END_STOP),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(0.0, 0.0),
    contribution=contribution,
    probes=(Parameters(1e-3, 1e-4), Parameters(-1e-3, -1e-4)),
    describes=True,
)
