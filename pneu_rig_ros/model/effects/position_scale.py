"""A position sensor whose gain is wrong, or whose characteristic is bowed."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Error of the gain, and of the linearity."""

    error: Annotated[
        float, Quantity('-', -0.05, 0.05, 'share by which the position sensor reads too much')
    ]
    bow: Annotated[
        float, Quantity('-', -0.05, 0.05, 'share of L that it reads too much in the middle')
    ] = 0.0


@Effect(
    title='the position sensor has a wrong scale',
    balance=Balance.MOTION_READING,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='JCGM 200:2012 (VIM), sensitivity of a measuring system; IEC 61298-2, terminal-based '
    'linearity: a parabola that is right at both ends of the stroke',
    null=Parameters(0.0),
    probes=((-0.03,), (-0.01,), (0.01,), (0.03,), (0.0, -0.01), (0.0, 0.01)),
    drivers=('position',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to the readings of position [m] and velocity [m/s]."""
    share = signals.motion.position / model.cylinder.stroke
    gain = parameters.error + 4.0 * parameters.bow * (1.0 - share)
    slope = parameters.error + 4.0 * parameters.bow * (1.0 - 2.0 * share)
    return gain * signals.motion.position, slope * signals.motion.velocity
