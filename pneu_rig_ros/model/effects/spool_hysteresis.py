"""Play between control voltage and spool: a reversal is followed only after a gap."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

DRAG_TIME = 1e-3
"""Time in which the memory of a spool follows its edge of the play [s]; below a reversal."""


class Parameters(NamedTuple):
    """Play of both spools."""

    width: Annotated[float, Quantity('V', 0.0, 0.5, 'width of the hysteresis loop')]


@compiled
def within(gap: float, half: float) -> float:
    """Return a gap [V] within the play of +-half [V]."""
    return min(max(gap, -half), half)


@Effect(
    title='valve spools follow their voltage with play',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source="M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, Springer 1989 (play)",
    null=Parameters(0.0),
    probes=((0.01,), (0.03,), (0.1,)),
    states=('dragged_1', 'dragged_2'),
    drivers=('opening',),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what the spools lack of the commanded voltages u1, u2 [V].

    A spool stands still as long as it is within half a width of its voltage; else it is at the
    nearer edge at once. The states are the positions where the spools stood last, as voltages from
    the centre, which follow within a millisecond: only a quicker reversal would be noticed late.
    """
    if parameters.width <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    gap_1 = CENTRE_VOLTAGE + state[0] - signals.ports.voltage_1
    gap_2 = CENTRE_VOLTAGE + state[1] - signals.ports.voltage_2
    lack_1 = within(gap_1, 0.5 * parameters.width)
    lack_2 = within(gap_2, 0.5 * parameters.width)
    rate[0], rate[1] = (lack_1 - gap_1) / DRAG_TIME, (lack_2 - gap_2) / DRAG_TIME
    return lack_1, lack_2
