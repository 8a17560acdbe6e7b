"""Pressure sensors whose zero is wrong."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Errors of the zeros."""

    offset_1: Annotated[float, Quantity('Pa', -1e5, 1e5, 'what the sensor of p1 reads too much')]
    offset_2: Annotated[float, Quantity('Pa', -1e5, 1e5, 'what the sensor of p2 reads too much')]


@Effect(
    title='the pressure sensors have an offset',
    balance=Balance.PRESSURE_READING,
    regimes=tuple(Regime),
    source='JCGM 200:2012 (VIM), zero error',
    null=Parameters(0.0, 0.0),
    probes=((2e3, 0.0), (0.0, 2e3), (-4e3, 4e3), (8e3, 8e3)),
    drivers=('pressure', 'time'),  # of another slope; a zero that drifts or warms up
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to the readings of p1 and p2 [Pa]."""
    return parameters.offset_1, parameters.offset_2
