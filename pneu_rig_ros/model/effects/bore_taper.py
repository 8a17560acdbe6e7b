"""Piston area that changes along the stroke: a bore that is conical, or wider than the seal."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Change of the area of the bore along the stroke."""

    taper: Annotated[
        float, Quantity('-', -0.1, 0.1, 'share of A1 by which the area grows from x = 0 to x = L')
    ]


@Effect(
    title='piston area changes along the stroke',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='ISO 286-1:2010 and ISO 1101:2017 (tolerances of diameter and cylindricity of bores); '
    'force of Eq. 8 with the area at the seal',
    null=Parameters(0.0),
    probes=((-0.03,), (-0.01,), (0.01,), (0.03,)),
    drivers=('position',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return the added force along the outstroke [N] and no added mass.

    The bore is as stated at mid-stroke and linear in x. What it has more of area there, both
    chambers press on. Volumes are as stated: they differ by an eighth of the taper at most.
    """
    share = parameters.taper * (signals.motion.position / model.cylinder.stroke - 0.5)
    difference = signals.gas.pressure_1 - signals.gas.pressure_2
    return share * model.cylinder.cap_area * difference, 0.0
