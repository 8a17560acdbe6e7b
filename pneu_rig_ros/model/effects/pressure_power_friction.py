"""Seal friction that grows with a power of the pressure that presses the lips on."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity

REFERENCE = 1e5
"""Gauge pressure at which the added force is as stated [Pa]."""


class Parameters(NamedTuple):
    """
    Friction that is added at 1 bar above atmosphere, and the power with which it grows.

    Below 1 the lip spreads until it is pressed flat and friction saturates, as an elastic contact
    with the load to the power 1/3 to 1; above 1 more of the lip touches the wall.
    """

    force: Annotated[
        float, Quantity('N', 0.0, 1e3, 'added to F_c and F_smax at 1 bar gauge in one chamber')
    ]
    exponent: Annotated[float, Quantity('-', 0.2, 2.0, 'power of the gauge pressure')]


@compiled
def raised(pressure: float, exponent: float, outside: float) -> float:
    """Return a pressure [Pa] above atmosphere, in bar, to a power; 0 below atmosphere."""
    gauge = (pressure - outside) / REFERENCE
    return math.pow(gauge, exponent) if gauge > 0.0 else 0.0


@Effect(
    title='seal friction grows with a power of the pressure',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='A. Schallamach, The Load Dependence of Rubber Friction, Proc. Phys. Soc. B 65 (1952); '
    'G. Belforte, T. Raparelli, M. Velardocchia, Study of the Behavior of Lip Seals in Pneumatic '
    'Actuators, Lubrication Engineering 49 (1993)',
    null=Parameters(0.0, 1.0),
    probes=((0.5, 0.5), (2.0, 0.7), (2.0, 1.5)),
    drivers=('difference', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to F_c and to F_smax [N]: each lip is pressed on by its chamber."""
    outside, power = model.gas.atmospheric_pressure, parameters.exponent
    lip_1 = raised(signals.gas.pressure_1, power, outside)
    lip_2 = raised(signals.gas.pressure_2, power, outside)
    added = parameters.force * (lip_1 + lip_2)
    return added, added
