"""Viscous friction that differs between outstroke and instroke."""

from itertools import product
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Asymmetry of the viscous coefficient."""

    asymmetry: Annotated[
        float, Quantity('N*s/m', -500.0, 500.0, 'more on the outstroke and less on the instroke')
    ]
    one_sidedness: Annotated[
        float, Quantity('-', -1.0, 1.0, '1: the outstroke alone differs, -1: the instroke alone')
    ] = 0.0


@Effect(
    title='viscous friction differs between outstroke and instroke',
    balance=Balance.FORCE,
    regimes=(Regime.SLIDING,),
    source='B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis '
    'tools and compensation methods for the control of machines with friction, Automatica 30 '
    '(1994)',
    null=Parameters(0.0),
    strengths=('asymmetry',),
    probes=tuple(product((-30.0, 30.0), (-1.0, 0.0, 1.0))),
    needs=(Need.FREE_MOTION,),
    drivers=('speed',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the force of the asymmetry along the outstroke [N] and no added mass."""
    velocity = signals.motion.velocity
    drag = parameters.asymmetry * (abs(velocity) + parameters.one_sidedness * velocity)
    return -drag, 0.0
