"""A description, not a cause: a level of friction that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity

SPEED = 0.1
"""Unit of the term with the speed [m/s]."""
TURN = 1e-3
"""Speed over which the term with the direction turns round [m/s]."""


class Parameters(NamedTuple):
    """Coefficients; pressures count in supply pressures, positions in strokes."""

    constant: Annotated[float, Quantity('N', -1e3, 1e3, 'added to F_c and F_smax')]
    position: Annotated[float, Quantity('N', -1e3, 1e3, 'times x/L - 1/2')]
    gauge_1: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p1')]
    gauge_2: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p2')]
    speed: Annotated[float, Quantity('N', -1e3, 1e3, 'times |v|, per 0.1 m/s')]
    direction: Annotated[float, Quantity('N', -1e3, 1e3, 'times the sign of v')]
    static: Annotated[float, Quantity('N', -1e3, 1e3, 'added to F_smax alone')]
    static_position: Annotated[float, Quantity('N', -1e3, 1e3, 'times x/L - 1/2')]
    static_gauge_1: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p1')]
    static_gauge_2: Annotated[float, Quantity('N', -1e3, 1e3, 'times gauge p2')]
    static_direction: Annotated[float, Quantity('N', -1e3, 1e3, 'times where the bristles bend')]
    static_dwell: Annotated[float, Quantity('N', -1e3, 1e3, 'times ln(1 + dwell time / 1 s)')]


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
    place = s.position / model.cylinder.stroke - 0.5
    gauge_1, gauge_2 = (s.pressure_1 - outside) / supply, (s.pressure_2 - outside) / supply
    bent = np.minimum(np.maximum(2.0 * s.bristle_force / model.friction.coulomb_force, -1.0), 1.0)
    added = (
        c.constant
        + c.position * place
        + c.gauge_1 * gauge_1
        + c.gauge_2 * gauge_2
        + c.speed * abs(s.velocity) / SPEED
        + c.direction * s.velocity / (abs(s.velocity) + TURN)
    )
    static = (
        c.static
        + c.static_position * place
        + c.static_gauge_1 * gauge_1
        + c.static_gauge_2 * gauge_2
        + c.static_direction * bent
        + c.static_dwell * np.log1p(s.dwell_time)
    )
    return added, added + static


EFFECT = Effect(
    title='a level of friction nobody has named yet',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(*([0.0] * 12)),
    contribution=contribution,
    probes=(Parameters(*([0.5] * 12)), Parameters(*([-0.2] * 12))),
    describes=True,
)
