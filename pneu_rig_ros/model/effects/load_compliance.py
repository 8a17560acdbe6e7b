"""A load that is not rigidly fixed to the rod: a second mass on a spring and a damper."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import LEAST_TIME, Balance, Effect, Need, Regime
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.quantity import Quantity

STRETCH_UNIT = 1e-3
"""Unit of the state `stretch` [m], so that the integrator's tolerance is a small way."""

FASTEST = 0.7 / LEAST_TIME
"""
Frequency and rate of decay of the load's swing at most [1/s]: stiffer joints act alike. With the
least damping it is stable along a measured motion, where the explicit midpoint rule drives a swing
by (omega h)^3/4 of critical damping.
"""

LEAST_DAMPING_RATIO = 0.01
"""Of the swing [-]: what the metal and the bolts of any joint take."""


class Parameters(NamedTuple):
    """Joint between rod and load."""

    compliance: Annotated[float, Quantity('m/N', 0.0, 1e-3, 'compliance of the joint')]
    damping: Annotated[
        float, Quantity('N*s/m', 0.0, 1e4, 'damping of the joint, at least 1 % of critical')
    ]


def swing_time(parameters: Parameters, model: Model) -> float:
    """Return the smaller of 1/omega of the load and the time constant of its damping [s]."""
    mass = model.operation.load_mass
    decay = mass / parameters.damping if parameters.damping > 0.0 else math.inf
    return min(math.sqrt(mass * parameters.compliance), decay)


@Effect(
    title='the load hangs on the rod by a spring and a damper',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='Newton, two masses joined by a linear spring and damper',
    null=Parameters(0.0, 0.0),
    # a load that rings at another frequency is no start at all, unless it is well damped
    probes=(
        *((6e-5 * 1.33**step, 20.0) for step in range(10)),
        *((2e-4, damping) for damping in (150.0, 1000.0)),
    ),
    states=('stretch', 'load_velocity'),
    needs=(Need.FREE_MOTION,),
    fastest=swing_time,
    drivers=(),  # a factor on the force and the mass of the load would make energy
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return the force of the joint on the rod [N], and the mass [kg] that it no longer moves.

    The states are the stretch of the joint and the velocity of the load [m/s].
    """
    mass, load_velocity = model.operation.load_mass, state[1]
    if parameters.compliance <= 0.0 or mass <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    stretching = load_velocity - signals.motion.velocity
    compliance = max(parameters.compliance, 1.0 / (mass * FASTEST * FASTEST))
    least = 2.0 * LEAST_DAMPING_RATIO * math.sqrt(mass / compliance)
    damping = min(max(parameters.damping, least), mass * FASTEST)
    force = STRETCH_UNIT * state[0] / compliance + damping * stretching
    rate[0] = stretching / STRETCH_UNIT
    rate[1] = -force / mass
    return force, -mass
