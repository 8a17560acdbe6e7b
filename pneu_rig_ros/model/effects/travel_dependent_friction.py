"""Seal friction that drifts as the piston travels: run-in, or lubricant that is wiped off."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity

LEAST_LEVEL = 0.1
"""Share of the friction level that always remains [-]."""


class Parameters(NamedTuple):
    """How fast the friction level changes at the start, and how far it changes at most."""

    rate: Annotated[float, Quantity('1/m', -10.0, 10.0, 'share added for each metre at first')]
    limit: Annotated[float, Quantity('-', 0.05, 2.0, 'share by which the level changes at most')]


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """
    Return what is added to F_c and to F_smax [N].

    The state is the way gone so far, s [m]; the level changes by the share::

        +- limit (1 - exp(-|rate| s / limit)), of the sign of the rate
    """
    if parameters.rate == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    rate[0] = abs(signals.motion.velocity)
    done = -math.expm1(-abs(parameters.rate) * max(state[0], 0.0) / parameters.limit)
    share = math.copysign(parameters.limit, parameters.rate) * done
    share = max(share, LEAST_LEVEL - 1.0)
    return share * model.friction.coulomb_force, share * model.friction.breakaway_force


EFFECT = Effect(
    title='friction drifts with the distance travelled',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='P. J. Blau, On the Nature of Running-In, Tribology Int. 38 (2005); J. F. Archard, '
    'Contact and Rubbing of Flat Surfaces, J. Appl. Phys. 24 (1953)',
    parameters=Parameters,
    null=Parameters(0.0, 0.5),
    contribution=contribution,
    probes=(
        Parameters(-3.0, 0.5),
        Parameters(-1.0, 0.5),
        Parameters(1.0, 0.5),
        Parameters(3.0, 0.5),
    ),
    states=('travel',),
    drivers=('speed',),
)
