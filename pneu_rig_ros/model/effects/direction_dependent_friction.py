"""Seal friction that differs between outstroke and instroke."""

from itertools import product
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.friction import friction_direction
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Asymmetry of the friction level."""

    asymmetry: Annotated[
        float, Quantity('-', -0.5, 0.5, 'share more on the outstroke and less on the instroke')
    ]
    one_sidedness: Annotated[
        float, Quantity('-', -1.0, 1.0, '1: the outstroke alone differs, -1: the instroke alone')
    ] = 0.0


@Effect(
    title='friction differs between outstroke and instroke',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis '
    'tools and compensation methods for the control of machines with friction, Automatica 30 '
    '(1994)',
    null=Parameters(0.0),
    strengths=('asymmetry',),
    probes=tuple(product((-0.2, -0.05, 0.05, 0.2), (-1.0, 0.0, 1.0))),
    drivers=('position', 'speed', 'pressure_1', 'pressure_2'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return what is added to F_c and to F_smax [N]: their share on the outstroke, less it else.

    Both directions together have twice the asymmetry, of which one of them has all where the other
    has the level of the law.
    """
    law, direction = model.friction, friction_direction(signals, model.friction)
    share = parameters.asymmetry * (direction + parameters.one_sidedness)
    return share * law.coulomb_force, share * law.breakaway_force
