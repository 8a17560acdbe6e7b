"""A spring that acts on the rod, as in a single-acting cylinder or a clamped load."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Linear spring that pushes towards the cap end."""

    stiffness: Annotated[float, Quantity('N/m', 0.0, 1e4, 'stiffness of the spring')]
    compression: Annotated[
        float, Quantity('m', -0.2, 0.2, 'compression at x = 0; negative: the way until it is met')
    ]


@Effect(
    title='a spring loads the rod',
    balance=Balance.FORCE,
    regimes=tuple(Regime),
    source='R. Hooke, De Potentia Restitutiva 1678 (linear spring)',
    null=Parameters(0.0, 0.0),
    probes=(
        (20.0, 0.0),
        (60.0, 0.02),
        (150.0, 0.05),
        *((stiffness, -way) for stiffness in (10.0, 100.0) for way in (0.04, 0.08)),
    ),
    drivers=('position',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the force of the spring along the outstroke [N] and no added mass."""
    compression = max(signals.motion.position + parameters.compression, 0.0)
    return -parameters.stiffness * compression, 0.0
