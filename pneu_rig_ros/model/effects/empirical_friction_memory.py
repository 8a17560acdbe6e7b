"""A level of friction that follows the signals with a lag, without a known cause."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.empirical import SPEED, gauge
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """What the lagging signals are multiplied with, and how far they lag."""

    speed: Annotated[float, Quantity('N', -1e3, 1e3, 'times the lagging |v|, per 0.1 m/s')]
    gauge_1: Annotated[float, Quantity('N', -1e3, 1e3, 'times the lagging gauge p1, per 5 bar')]
    gauge_2: Annotated[float, Quantity('N', -1e3, 1e3, 'times the lagging gauge p2, per 5 bar')]
    elapsed: Annotated[float, Quantity('N', -1e3, 1e3, 'times 1 - exp(-t / lag)')]
    lag: Annotated[float, Quantity('s', 5e-3, 30.0, 'time constant')]


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """
    Return what is added to F_c and to F_smax [N].

    The states are the signals behind a lag of first order, zero at the start.
    """
    p = parameters
    if p.speed == 0.0 and p.gauge_1 == 0.0 and p.gauge_2 == 0.0 and p.elapsed == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    rate[0] = (abs(signals.motion.velocity) / SPEED - state[0]) / p.lag
    rate[1] = (gauge(signals.gas.pressure_1, model) - state[1]) / p.lag
    rate[2] = (gauge(signals.gas.pressure_2, model) - state[2]) / p.lag
    rate[3] = (1.0 - state[3]) / p.lag
    level = p.speed * state[0] + p.gauge_1 * state[1] + p.gauge_2 * state[2]
    level += p.elapsed * state[3]
    return level, level


EFFECT = Effect(
    title='a level of friction with a memory, without a known cause',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='a fit to data: a description, not a cause',
    null=Parameters(0.0, 0.0, 0.0, 0.0, 0.1),
    contribution=contribution,
    probes=tuple(Parameters(0.3, 0.3, 0.3, 0.3, lag) for lag in (0.03, 0.2, 1.0, 5.0)),
    states=('speed', 'gauge_1', 'gauge_2', 'elapsed'),
    describes=True,
)
