"""Static friction that differs between outstroke and instroke."""

from itertools import product
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.friction import friction_direction
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Asymmetry of what static friction is above F_c."""

    asymmetry: Annotated[
        float,
        Quantity('-', -0.5, 0.5, 'share of F_smax - F_c more on the outstroke and less else'),
    ]
    one_sidedness: Annotated[
        float, Quantity('-', -1.0, 1.0, '1: the outstroke alone differs, -1: the instroke alone')
    ] = 0.0


@Effect(
    title='static friction differs between outstroke and instroke',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis '
    'tools and compensation methods for the control of machines with friction, Automatica 30 '
    '(1994)',
    null=Parameters(0.0),
    strengths=('asymmetry',),
    probes=tuple(product((-0.2, 0.2), (-1.0, 0.0, 1.0))),
    stage=2,
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return no change of F_c, and what is added to F_smax [N], a share of its excess over F_c.

    Both directions together have twice the asymmetry, see ``direction_dependent_friction``.
    """
    seal, direction = signals.seal, friction_direction(signals, model.friction)
    share = parameters.asymmetry * (direction + parameters.one_sidedness)
    return 0.0, share * max(seal.static_force - seal.coulomb_force, 0.0)
