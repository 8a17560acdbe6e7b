"""Seal friction that differs around one place of the stroke: a dent, a worn or a dry patch."""

import math
from itertools import product
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """How much, where, and how far around."""

    share: Annotated[float, Quantity('-', -0.9, 2.0, 'share by which F_c and F_smax grow there')]
    place: Annotated[float, Quantity('-', 0.0, 1.0, 'where, as a share of the stroke L')]
    width: Annotated[
        float, Quantity('-', 0.01, 0.5, 'share of L at which it has fallen to 1/e of that')
    ]


@Effect(
    title='friction differs around one place of the stroke',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='B. Armstrong-Hélouvry, Control of Machines with Friction, Kluwer (1991): friction '
    'that depends on the position',
    null=Parameters(0.0, 0.5, 0.1),
    strengths=('share',),
    # a bell that does not reach into the right one is no start at all
    probes=tuple(product((-0.2, 0.2), (0.1, 0.3, 0.5, 0.7, 0.9), (0.15,))),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to F_c and to F_smax [N], a bell around the place."""
    law = model.friction
    away = signals.motion.position / model.cylinder.stroke - parameters.place
    share = parameters.share * math.exp(-((away / parameters.width) ** 2))
    return share * law.coulomb_force, share * law.breakaway_force
