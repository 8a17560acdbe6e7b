"""A position sensor that follows the piston with a lag."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime, integrated_lag
from pneu_rig_ros.model.quantity import Quantity

LAG_UNIT = 0.1
"""Unit of the state [m], so that the integrator's tolerance is a small way."""


class Parameters(NamedTuple):
    """Time constant of the sensor and its filter."""

    time_constant: Annotated[
        float, Quantity('s', 0.0, 0.1, 'time constant of the position sensor')
    ]


@Effect(
    title='the position sensor lags behind the piston',
    balance=Balance.MOTION_READING,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING),
    source='JCGM 200:2012 (VIM), step response time; here of first order',
    null=Parameters(0.0),
    probes=((0.003,), (0.01,), (0.03,)),
    states=('behind',),
    needs=(Need.MILLISECONDS,),
    drivers=('speed', 'velocity'),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what the readings lack of position [m] and velocity [m/s].

    The state is how far the reading is behind the position.
    """
    if parameters.time_constant <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    behind = LAG_UNIT * state[0]
    time, share = integrated_lag(parameters.time_constant)
    lack = behind / time - signals.motion.velocity
    rate[0] = -lack / LAG_UNIT
    return -share * behind, share * lack
