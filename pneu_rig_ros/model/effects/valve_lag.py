"""Delay of the valve spools behind their control voltage."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime, integrated_lag
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE


class Parameters(NamedTuple):
    """Of both spools."""

    time_constant: Annotated[float, Quantity('s', 0.0, 1.0, 'time constant of the spool')]
    share: Annotated[
        float, Quantity('-', 0.01, 1.0, 'part of a step that lags; the rest is immediate')
    ] = 1.0


@Effect(
    title='valve spools follow their voltage with a lag',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='P. Beater, Pneumatic Drives, Springer 2007 (first-order spool); H. C. Roters, '
    'Electromagnetic Devices, Wiley 1941 (eddy currents delay a part of the force)',
    null=Parameters(0.0),
    probes=(*((time,) for time in (0.01, 0.05, 0.2)), *((time, 0.2) for time in (0.05, 0.3))),
    stage=1,
    states=('spool_1', 'spool_2'),
    drivers=('opening',),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what the spools lack of the commanded voltages u1, u2 [V].

    The states are what lags behind the voltages, from the centre, which is where a valve at rest
    stands: the spool positions, where all of a step lags.
    """
    if parameters.time_constant <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    lack_1 = CENTRE_VOLTAGE + state[0] - signals.ports.voltage_1
    lack_2 = CENTRE_VOLTAGE + state[1] - signals.ports.voltage_2
    time, share = integrated_lag(parameters.time_constant)
    share *= parameters.share
    rate[0], rate[1] = -lack_1 / time, -lack_2 / time
    return share * lack_1, share * lack_2
