"""Leak between the chambers around one place of the stroke, where the bore is worn or scored."""

import math
from itertools import product
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import port_flow


class Parameters(NamedTuple):
    """How much, where, and how far around."""

    area: Annotated[float, Quantity('m^2', 0.0, 1e-4, 'effective leak area past the piston there')]
    place: Annotated[float, Quantity('-', 0.0, 1.0, 'where, as a share of the stroke L')]
    width: Annotated[
        float, Quantity('-', 0.01, 0.5, 'share of L at which it has fallen to 1/e of that')
    ]


@Effect(
    title='the piston seal leaks around one place of the stroke',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='ISO 10099, Pneumatic fluid power - Cylinders - Final examination and acceptance '
    'criteria (leakage past the piston), here of a part of the bore',
    null=Parameters(0.0, 0.5, 0.1),
    # a bell that does not reach into the right one is no start at all
    probes=tuple(product((2e-9, 2e-8), (0.1, 0.3, 0.5, 0.7, 0.9), (0.15,))),
    needs=(Need.BOTH_CHAMBERS,),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the mass flows [kg/s] into chamber 1 and 2, equal and opposite: Eq. 3, in a bell."""
    p1, p2 = signals.gas.pressure_1, signals.gas.pressure_2
    away = signals.motion.position / model.cylinder.stroke - parameters.place
    area = parameters.area * math.exp(-((away / parameters.width) ** 2))
    leak = port_flow(p1, p2, area, model.valve, model.gas)
    return -leak, leak
