"""Valve spools whose speed is limited."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import LEAST_TIME, Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE


class Parameters(NamedTuple):
    """The limit, as a time."""

    time_per_volt: Annotated[
        float, Quantity('s/V', 0.0, 1.0, 'least time in which a spool moves by 1 V')
    ]


@compiled
def speed(lack: float, time_per_volt: float) -> float:
    """Return the speed [V/s] of a spool that lacks so much [V]: near its place a fast lag."""
    limit = 1.0 / time_per_volt
    return max(-limit, min(-lack / LEAST_TIME, limit))


@Effect(
    title='the speed of the valve spools is limited',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967 (saturated torque motor)',
    null=Parameters(0.0),
    probes=((0.01,), (0.05,), (0.2,)),
    stage=1,
    states=('limited_spool_1', 'limited_spool_2'),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what the spools lack of the commanded voltages u1, u2 [V].

    The states are the spool positions as voltages from the centre.
    """
    time = parameters.time_per_volt
    if time <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    lack_1 = CENTRE_VOLTAGE + state[0] - signals.ports.voltage_1
    lack_2 = CENTRE_VOLTAGE + state[1] - signals.ports.voltage_2
    rate[0], rate[1] = speed(lack_1, time), speed(lack_2, time)
    share = min(time / LEAST_TIME, 1.0)
    return share * lack_1, share * lack_2
