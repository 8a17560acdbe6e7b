"""Seal friction that changes along the stroke: a barrel that is not cylindrical, a bent rod."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Change of the friction level along the stroke."""

    gradient: Annotated[
        float, Quantity('-', -1.0, 1.0, 'share by which F_c and F_smax grow from x = 0 to x = L')
    ]
    bulge: Annotated[
        float,
        Quantity('-', -1.0, 1.0, 'share by which both are larger at x = L/2 than at the ends'),
    ] = 0.0


@Effect(
    title='friction changes along the stroke',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis '
    'tools and compensation methods for the control of machines with friction, Automatica 30 '
    '(1994)',
    null=Parameters(0.0),
    probes=((-0.4,), (-0.1,), (0.1,), (0.4,), (0.0, -0.2), (0.0, 0.2)),
    drivers=('position', 'velocity', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to F_c and to F_smax [N], a parabola of mean 0 along the stroke."""
    law = model.friction
    from_middle = signals.motion.position / model.cylinder.stroke - 0.5
    share = parameters.gradient * from_middle
    share += parameters.bulge * (1.0 / 3.0 - 4.0 * from_middle * from_middle)
    return share * law.coulomb_force, share * law.breakaway_force
