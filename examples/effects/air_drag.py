"""Drag of the air on what the rod carries."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Drag area and density in one."""

    coefficient: Annotated[
        float, Quantity('N*s^2/m^2', 0.0, 1e4, 'force over speed squared, rho c_d A / 2')
    ]


@Effect(
    title='air drags on the load',
    balance=Balance.FORCE,
    regimes=(Regime.SLIDING,),
    source='F. M. White, Fluid Mechanics, section 7.6',
    null=Parameters(0.0),
    probes=((100.0,), (1000.0,), (5000.0,)),
    drivers=('speed', 'velocity', 'position'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the force against the motion [N], and no mass [kg]."""
    return -parameters.coefficient * signals.motion.velocity * abs(signals.motion.velocity), 0.0
