"""A force that follows the signals with a lag, without a known cause."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.empirical import PRESSURE, SPEED
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """What the lagging signals are multiplied with, and how far they lag."""

    velocity: Annotated[float, Quantity('N', -1e3, 1e3, 'times v ahead of its lag, per 0.1 m/s')]
    difference: Annotated[float, Quantity('N', -1e3, 1e3, 'times lagging p1 - p2, per 5 bar')]
    lag: Annotated[float, Quantity('s', 5e-3, 30.0, 'time constant')]


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """
    Return the force along the outstroke [N] and no added mass.

    The states are the signals behind a lag of first order, zero at the start.
    """
    if parameters.velocity == 0.0 and parameters.difference == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    ahead = signals.motion.velocity / SPEED - state[0]
    difference = (signals.gas.pressure_1 - signals.gas.pressure_2) / PRESSURE
    rate[0] = ahead / parameters.lag
    rate[1] = (difference - state[1]) / parameters.lag
    return parameters.velocity * ahead + parameters.difference * state[1], 0.0


EFFECT = Effect(
    title='a force with a memory, without a known cause',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='a fit to data: a description, not a cause',
    null=Parameters(0.0, 0.0, 0.1),
    contribution=contribution,
    probes=tuple(Parameters(0.5, 0.5, lag) for lag in (0.03, 0.2, 1.0, 5.0)),
    states=('velocity', 'difference'),
    describes=True,
)
