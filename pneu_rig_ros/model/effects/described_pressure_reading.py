"""A description, not a cause: an error of the pressure sensors that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Coefficients for p1 and p2; pressures count in supply pressures."""

    constant_1: Annotated[float, Quantity('Pa', -1e5, 1e5, 'added to the reading of p1')]
    gauge_1: Annotated[float, Quantity('Pa', -1e5, 1e5, 'times gauge p1')]
    constant_2: Annotated[float, Quantity('Pa', -1e5, 1e5, 'added to the reading of p2')]
    gauge_2: Annotated[float, Quantity('Pa', -1e5, 1e5, 'times gauge p2')]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """Return what is added to the readings of p1 and p2 [Pa]."""
    c, s = parameters, signals
    outside, supply = model.gas.atmospheric_pressure, model.operation.supply_pressure
    return (
        c.constant_1 + c.gauge_1 * (s.pressure_1 - outside) / supply,
        c.constant_2 + c.gauge_2 * (s.pressure_2 - outside) / supply,
    )


EFFECT = Effect(
    title='an error of the pressure sensors nobody has named yet',
    balance=Balance.PRESSURE_READING,
    regimes=tuple(Regime),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(0.0, 0.0, 0.0, 0.0),
    contribution=contribution,
    probes=(Parameters(*([1e3] * 4)), Parameters(*([-1e3] * 4))),
    describes=True,
)
