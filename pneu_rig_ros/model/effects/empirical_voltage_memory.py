"""An error of the valve spools that follows the commands with a lag, without a known cause."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

LARGEST_ERROR = 3.0
"""Of a spool [V]."""


class Parameters(NamedTuple):
    """What the lagging voltages are multiplied with, and how far they lag."""

    behind_1: Annotated[float, Quantity('V', -3.0, 3.0, 'times how far u1 is ahead of its lag')]
    behind_2: Annotated[float, Quantity('V', -3.0, 3.0, 'times how far u2 is ahead of its lag')]
    elapsed_1: Annotated[float, Quantity('V', -3.0, 3.0, 'added to u1, times 1 - exp(-t / lag)')]
    elapsed_2: Annotated[float, Quantity('V', -3.0, 3.0, 'added to u2, times 1 - exp(-t / lag)')]
    lag: Annotated[float, Quantity('s', 5e-3, 30.0, 'time constant')]


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """
    Return what is added to the control voltages u1, u2 [V].

    The states are the voltages from the centre, and twice a step at the start, behind a lag of
    first order; all begin at zero.
    """
    p = parameters
    if p.behind_1 == 0.0 and p.behind_2 == 0.0 and p.elapsed_1 == 0.0 and p.elapsed_2 == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    first, second = signals.ports.voltage_1, signals.ports.voltage_2
    ahead_1, ahead_2 = first - CENTRE_VOLTAGE - state[0], second - CENTRE_VOLTAGE - state[1]
    rate[0], rate[1] = ahead_1 / p.lag, ahead_2 / p.lag
    rate[2] = (1.0 - state[2]) / p.lag
    rate[3] = rate[2]
    error_1 = p.elapsed_1 * state[2] - p.behind_1 * ahead_1
    error_2 = p.elapsed_2 * state[3] - p.behind_2 * ahead_2
    return _within(error_1), _within(error_2)


@compiled
def _within(error: float) -> float:
    return min(max(error, -LARGEST_ERROR), LARGEST_ERROR)


EFFECT = Effect(
    title='an error of the valve spools with a memory, without a known cause',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.SLIDING, Regime.END_STOP),
    source='a fit to data: a description, not a cause',
    null=Parameters(0.0, 0.0, 0.0, 0.0, 0.1),
    contribution=contribution,
    probes=tuple(Parameters(0.05, 0.05, 0.02, 0.02, lag) for lag in (0.02, 0.1, 0.5, 4.0)),
    stage=3,
    states=('behind_1', 'behind_2', 'elapsed_1', 'elapsed_2'),
    describes=True,
)
