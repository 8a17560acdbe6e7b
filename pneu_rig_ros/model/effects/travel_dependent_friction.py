"""Seal friction that drifts as the piston travels: run-in, or lubricant that is wiped off."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime, drift
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """How fast the friction level changes at the start, and how far it changes at most."""

    rate: Annotated[float, Quantity('1/m', -10.0, 10.0, 'share added for each metre at first')]
    limit: Annotated[float, Quantity('-', 0.05, 2.0, 'share by which the level changes at most')]


@Effect(
    title='friction drifts with the distance travelled',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='P. J. Blau, On the Nature of Running-In, Tribology Int. 38 (2005); J. F. Archard, '
    'Contact and Rubbing of Flat Surfaces, J. Appl. Phys. 24 (1953)',
    null=Parameters(0.0, 0.5),
    probes=tuple((rate, 0.5) for rate in (-3.0, -1.0, 1.0, 3.0)),
    states=('travel',),
    drivers=('speed',),
    fastest=lambda parameters, model: math.inf,  # a sum: it answers to nothing
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what is added to F_c and to F_smax [N]: a drift with the way gone so far.

    The state is that way [m].
    """
    if parameters.rate == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    rate[0] = abs(signals.motion.velocity)
    share = drift(parameters.rate, parameters.limit, state[0])
    return share * model.friction.coulomb_force, share * model.friction.breakaway_force
