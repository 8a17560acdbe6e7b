"""Play between control voltage and spool: a reversal is followed only after a gap."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

DRAG_TIME = 1e-3
"""Time in which a spool is dragged to the edge of the play [s]; below a sampling interval."""


class Parameters(NamedTuple):
    """Play of both spools."""

    width: Annotated[float, Quantity('V', 0.0, 0.5, 'width of the hysteresis loop')]


@compiled
def beyond(gap: float, half: float) -> float:
    """Return how far a gap [V] reaches beyond the play of +-half [V]."""
    return gap - min(max(gap, -half), half)


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """
    Return what the spools lack of the commanded voltages u1, u2 [V].

    The states are the spool positions as voltages from the centre. A spool stands still as long
    as it is within half a width of its voltage; else it is dragged to the nearer edge.
    """
    if parameters.width <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    lack_1 = CENTRE_VOLTAGE + state[0] - signals.ports.voltage_1
    lack_2 = CENTRE_VOLTAGE + state[1] - signals.ports.voltage_2
    rate[0] = -beyond(lack_1, 0.5 * parameters.width) / DRAG_TIME
    rate[1] = -beyond(lack_2, 0.5 * parameters.width) / DRAG_TIME
    return lack_1, lack_2


EFFECT = Effect(
    title='valve spools follow their voltage with play',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source="M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, Springer 1989 (play)",
    parameters=Parameters,
    null=Parameters(0.0),
    contribution=contribution,
    probes=(Parameters(0.01), Parameters(0.03), Parameters(0.1)),
    states=('dragged_1', 'dragged_2'),
    drivers=('opening',),
)
