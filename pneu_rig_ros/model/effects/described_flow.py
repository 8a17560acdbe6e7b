"""A description, not a cause: a flow into each chamber that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

SPEED = 0.1
"""Unit of the terms with the velocity [m/s]."""


class Parameters(NamedTuple):
    """Coefficients of chamber 1 and 2; pressures count in supply pressures."""

    constant_1: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'flow into chamber 1')]
    gauge_1: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times gauge p1')]
    difference_1: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times p2 - p1')]
    voltage_1: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times u1 - 2.5 V, per volt')]
    velocity_1: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times v, per 0.1 m/s')]
    constant_2: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'flow into chamber 2')]
    gauge_2: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times gauge p2')]
    difference_2: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times p1 - p2')]
    voltage_2: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times u2 - 2.5 V, per volt')]
    velocity_2: Annotated[float, Quantity('kg/s', -0.01, 0.01, 'times -v, per 0.1 m/s')]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """Return the flows into chamber 1 and 2 [kg/s], less out of one with little gas left."""
    c, s = parameters, signals
    outside, supply = model.gas.atmospheric_pressure, model.operation.supply_pressure
    excess = (s.pressure_1 - s.pressure_2) / supply
    flow_1 = (
        c.constant_1
        + c.gauge_1 * (s.pressure_1 - outside) / supply
        - c.difference_1 * excess
        + c.voltage_1 * (s.voltage_1 - CENTRE_VOLTAGE)
        + c.velocity_1 * s.velocity / SPEED
    )
    flow_2 = (
        c.constant_2
        + c.gauge_2 * (s.pressure_2 - outside) / supply
        + c.difference_2 * excess
        + c.voltage_2 * (s.voltage_2 - CENTRE_VOLTAGE)
        - c.velocity_2 * s.velocity / SPEED
    )
    left_1 = np.minimum(s.pressure_1 / outside, 1.0)
    left_2 = np.minimum(s.pressure_2 / outside, 1.0)
    return np.maximum(flow_1, flow_1 * left_1), np.maximum(flow_2, flow_2 * left_2)


EFFECT = Effect(
    title='a flow nobody has named yet',
    balance=Balance.MASS,
    regimes=tuple(Regime),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(*([0.0] * 10)),
    contribution=contribution,
    probes=(
        Parameters(*([1e-6] * 10)),
        Parameters(*([-1e-6] * 10)),
    ),
    describes=True,
)
