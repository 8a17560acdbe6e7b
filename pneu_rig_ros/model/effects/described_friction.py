"""A description, not a cause: a level of friction that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Signals
from pneu_rig_ros.model.quantity import Quantity

SPEED = 0.1
"""Unit of the term with the speed [m/s]."""
TURN = 1e-3
"""Speed over which the term with the direction turns round [m/s]."""


class Parameters(NamedTuple):
    """Coefficients; pressures count in supply pressures, positions in strokes."""

    constant: Annotated[float, Quantity('N', -1e3, 1e3, 'added to F_c and F_smax')]
    static: Annotated[float, Quantity('N', -1e3, 1e3, 'added to F_smax alone')]
    position: Annotated[float, Quantity('N', -1e3, 1e3, 'times x/L')]
    gauge_1: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p1')]
    gauge_2: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p2')]
    speed: Annotated[float, Quantity('N', -1e3, 1e3, 'times |v|, per 0.1 m/s')]
    direction: Annotated[float, Quantity('N', -1e3, 1e3, 'times the sign of v')]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """Return what is added to F_c and to F_smax [N]."""
    c, s = parameters, signals
    outside, supply = model.gas.atmospheric_pressure, model.operation.supply_pressure
    added = (
        c.constant
        + c.position * s.position / model.cylinder.stroke
        + c.gauge_1 * (s.pressure_1 - outside) / supply
        + c.gauge_2 * (s.pressure_2 - outside) / supply
        + c.speed * abs(s.velocity) / SPEED
        + c.direction * s.velocity / (abs(s.velocity) + TURN)
    )
    return added, added + c.static


EFFECT = Effect(
    title='a level of friction nobody has named yet',
    balance=Balance.LEVEL,
    regimes=('breakaway', 'sliding'),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    contribution=contribution,
    probes=(Parameters(*([0.5] * 7)), Parameters(*([-0.2] * 7))),
    describes=True,
)
