"""A description, not a cause: a force on the piston that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity

SPEED = 0.1
"""Unit of the terms with the velocity [m/s]."""


class Parameters(NamedTuple):
    """Coefficients; pressures count in supply pressures, positions in strokes."""

    constant: Annotated[float, Quantity('N', -1e3, 1e3, 'driving force')]
    mass: Annotated[float, Quantity('m/s^2', -20.0, 20.0, 'times all that moves')]
    position: Annotated[float, Quantity('N', -1e3, 1e3, 'times x/L')]
    gauge_1: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p1')]
    gauge_2: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p2')]
    velocity: Annotated[float, Quantity('N', -1e3, 1e3, 'times v, per 0.1 m/s')]
    ends: Annotated[float, Quantity('N', -1e3, 1e3, 'times (2x/L - 1)^9')]
    ends_velocity: Annotated[float, Quantity('N', -1e3, 1e3, 'times v (2x/L - 1)^8, per 0.1 m/s')]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """Return the driving force [N] and no added mass."""
    c, s = parameters, signals
    outside, supply = model.gas.atmospheric_pressure, model.operation.supply_pressure
    place = 2.0 * s.position / model.cylinder.stroke - 1.0
    near_end = place**8
    force = (
        c.constant
        + c.mass * (model.cylinder.moving_mass + model.operation.load_mass)
        + c.position * s.position / model.cylinder.stroke
        + c.gauge_1 * (s.pressure_1 - outside) / supply
        + c.gauge_2 * (s.pressure_2 - outside) / supply
        + c.velocity * s.velocity / SPEED
        + c.ends * near_end * place
        + c.ends_velocity * near_end * s.velocity / SPEED
    )
    return force, 0.0


EFFECT = Effect(
    title='a force nobody has named yet',
    balance=Balance.FORCE,
    regimes=tuple(Regime),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(*([0.0] * 8)),
    contribution=contribution,
    probes=(Parameters(*([0.5] * 8)), Parameters(*([-0.5] * 8))),
    describes=True,
)
