"""Seal friction that falls as the seals are run in and warm after a rest."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.quantity import Quantity

FASTEST_SLIDE = 1.0
"""Seals of pneumatic cylinders are made for this speed [m/s]."""


class Parameters(NamedTuple):
    """How far the friction level falls, and after how much work."""

    drop: Annotated[float, Quantity('-', 0.0, 0.9, 'share by which F_c and F_smax fall')]
    work: Annotated[
        float, Quantity('J', 1e-3, 1e3, 'work of friction after which 63 % of the fall is done')
    ]


def warming_time(parameters: Parameters, model: Model) -> float:
    """Return the time of 63 % of the fall at ``FASTEST_SLIDE`` [s]."""
    law = model.friction
    force = law.coulomb_force + law.viscous_coefficient * FASTEST_SLIDE
    return parameters.work / (force * FASTEST_SLIDE)


@Effect(
    title='friction falls as the seals warm up',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='A. C. Bittencourt, E. Wernholt, S. Sander-Tavallaey, T. Brogårdh, An Extended '
    'Friction Model to capture Load and Temperature effects in Robot Joints, IROS 2010; here '
    'exponential in the work',
    null=Parameters(0.0, 1.0),
    probes=((0.1, 1.0), (0.2, 0.3), (0.3, 3.0), (0.5, 1.0)),
    states=('warmth',),
    drivers=('time', 'dwell', 'position', 'speed'),
    fastest=warming_time,
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what is added to F_c and to F_smax [N].

    The state is the warmth w, from 0 to 1, that the power of friction P drives::

        dw/dt = (1 - w) P / E,  level = (1 - drop w) level at the start
    """
    if parameters.drop <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    law, v = model.friction, signals.motion.velocity
    power = abs(signals.seal.bristle_force * v) + law.viscous_coefficient * v * v
    rate[0] = (1.0 - state[0]) * power / parameters.work
    share = -parameters.drop * state[0]
    return share * law.coulomb_force, share * law.breakaway_force
