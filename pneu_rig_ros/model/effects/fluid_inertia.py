"""The lubricant between seal and wall follows the piston with a time constant."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """T of Eq. 9."""

    time_constant: Annotated[
        float, Quantity('s', 0.0, 1.0, 'time constant of the fluid friction, T of Eq. 9')
    ]


@Effect(
    title='fluid friction depends on the acceleration too',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='Eq. 9 of the paper; X. B. Tran, N. Hafizah, H. Yanada, Modeling of Dynamic '
    'Friction Behaviors of Hydraulic Cylinders, Mechatronics 22 (2012)',
    null=Parameters(0.0),
    probes=((0.003,), (0.01,), (0.05,), (0.2,)),
    needs=(Need.FREE_MOTION,),
    drivers=('speed',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return no force, and the mass sigma_2 T [kg] as which the fluid term of Eq. 9 acts."""
    return 0.0, model.friction.viscous_coefficient * parameters.time_constant
