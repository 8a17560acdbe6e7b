"""A tank between regulator and valves: its pressure falls while gas is drawn, then recovers."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import mass_flow_of_both

PRESSURE_UNIT = 1e4
"""Unit of the state [Pa], so that the integrator's tolerance is a small pressure."""


class Parameters(NamedTuple):
    """Size of the tank, and how fast it is filled."""

    fall: Annotated[
        float, Quantity('Pa/kg', 0.0, 1e9, 'fall of the supply pressure with the mass drawn')
    ]
    recovery_time: Annotated[
        float, Quantity('s', 0.05, 1e3, 'time constant with which the tank is filled again')
    ]


@Effect(
    title='supply pressure falls with the mass drawn from a tank, and recovers',
    balance=Balance.SUPPLY,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='B. W. Andersen, The Analysis and Design of Pneumatic Systems, Wiley 1967 (tank filled '
    'through a restriction; regulator with a lag)',
    null=Parameters(0.0, 1.0),
    probes=(
        *((fall, 0.3) for fall in (3e8, 1e9)),
        *((fall, 3.0) for fall in (3e7, 2e8)),
        *((fall, 100.0) for fall in (3e6, 3e7)),
    ),
    states=('lack_of_tank',),
    drivers=(),  # a factor would lose or make the gas of the tank
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what both valves lack of the supply pressure [Pa].

    The state is what the tank lacks. Its gas is at supply temperature, and it is filled in
    proportion to the difference of the pressures.
    """
    if parameters.fall <= 0.0:
        rate[0] = 0.0
        return 0.0, 0.0
    lack = PRESSURE_UNIT * state[0]
    flow = mass_flow_of_both(signals, model, max(signals.ports.supply_1 - lack, 0.0))
    rate[0] = (parameters.fall * flow - lack / parameters.recovery_time) / PRESSURE_UNIT
    return -lack, -lack
