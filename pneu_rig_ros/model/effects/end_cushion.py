"""Elastic cushions before the end stops, that brake the piston."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Cushion of both ends."""

    length: Annotated[float, Quantity('m', 1e-3, 0.05, 'length of each cushion')]
    stiffness: Annotated[float, Quantity('N/m', 0.0, 1e5, 'stiffness of each cushion')]
    damping: Annotated[
        float, Quantity('N*s/m', 0.0, 2e3, 'damping of each cushion when fully pressed in')
    ]


@compiled
def push(depth: float, speed: float, parameters: Parameters) -> float:
    """
    Return the force [N] of one cushion away from its stop, which never pulls.

    The damping grows with the depth, so that the force begins at zero at any speed.

    :param depth: how far the cushion is pressed in [m]
    :param speed: rate of the depth [m/s]
    """
    if depth <= 0.0:
        return 0.0
    damping = parameters.damping * min(depth / parameters.length, 1.0)
    return max(parameters.stiffness * depth + damping * speed, 0.0)


@Effect(
    title='cushions brake the piston before its end stops',
    balance=Balance.FORCE,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='K. H. Hunt, F. R. E. Crossley, Coefficient of Restitution Interpreted as Damping in '
    'Vibroimpact, J. Appl. Mech. 42 (1975), with a linear spring',
    null=Parameters(0.01, 0.0, 0.0),
    strengths=('stiffness', 'damping'),
    probes=((0.01, 500.0, 50.0), (0.02, 500.0, 50.0), (0.03, 200.0, 500.0), (0.02, 5e3, 200.0)),
    drivers=('position', 'velocity', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the force of both cushions along the outstroke [N] and no added mass."""
    x, v, length = signals.motion.position, signals.motion.velocity, parameters.length
    outer = push(x - (model.cylinder.stroke - length), v, parameters)
    return push(length - x, -v, parameters) - outer, 0.0
