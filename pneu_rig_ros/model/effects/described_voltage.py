"""A description, not a cause: an error of the spools, alike in both valves, in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

MEMORY = 0.02
"""Time over which a voltage is still a new one [s]."""


class Parameters(NamedTuple):
    """Coefficients, the same for both valves."""

    constant: Annotated[float, Quantity('V', -0.2, 0.2, 'added to u1 and u2')]
    voltage: Annotated[float, Quantity('V', -0.9, 3.0, 'times u - 2.5 V, per volt')]
    squared: Annotated[float, Quantity('V', -0.9, 3.0, 'times (u - 2.5 V)|u - 2.5 V|, per V^2')]
    change: Annotated[
        float, Quantity('V', -2.0, 2.0, 'times u less its mean over 20 ms, per volt')
    ]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """
    Return what is added to u1 and u2 [V].

    The states are the means of both voltages over ``MEMORY``, from the centre.
    """
    c = parameters
    way_1, way_2 = signals.voltage_1 - CENTRE_VOLTAGE, signals.voltage_2 - CENTRE_VOLTAGE
    new_1, new_2 = way_1 - state[0], way_2 - state[1]
    remembers = 1.0 if c.change != 0.0 else 0.0
    rate[0], rate[1] = remembers * new_1 / MEMORY, remembers * new_2 / MEMORY
    added_1 = c.constant + (c.voltage + c.squared * abs(way_1)) * way_1 + c.change * new_1
    added_2 = c.constant + (c.voltage + c.squared * abs(way_2)) * way_2 + c.change * new_2
    return added_1, added_2


EFFECT = Effect(
    title='an error of the valve spools nobody has named yet',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.SLIDING, Regime.END_STOP),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(0.0, 0.0, 0.0, 0.0),
    contribution=contribution,
    probes=(Parameters(0.01, 0.05, 0.05, 0.2), Parameters(-0.01, -0.05, -0.05, -0.2)),
    stage=3,
    states=('mean_voltage_1', 'mean_voltage_2'),
    describes=True,
)
