"""A lubricant film that grows with the speed and takes a part of the static friction."""

from typing import Annotated, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.friction import film_rests
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Eq. 12-15, with the film as a share of its largest thickness."""

    growth: Annotated[
        float, Quantity('s/m', 0.0, 1e4, 'the film is full from the speed 1/growth on, 1/v_b')
    ]
    time_acceleration: Annotated[float, Quantity('s', 1e-3, 1e2, 'time to grow, tau_hp')]
    time_deceleration: Annotated[float, Quantity('s', 1e-3, 1e2, 'time to thin, tau_hm')]
    time_dwell: Annotated[float, Quantity('s', 1e-3, 1e4, 'time to thin at rest, tau_h0')]


@Effect(
    title='a lubricant film builds up in motion and thins at rest',
    balance=Balance.FILM,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='Eq. 12-15 of the paper; H. Yanada, Y. Sekikawa, Modeling of Dynamic Behaviors of '
    'Friction, Mechatronics 18 (2008)',
    null=Parameters(0.0, 0.1, 0.1, 10.0),
    probes=(
        (5.0, 0.05, 0.5, 30.0),
        (20.0, 0.01, 0.3, 30.0),
        (20.0, 0.2, 0.3, 3.0),
        (100.0, 0.02, 1.0, 30.0),
    ),
    laws=('lugre',),
    states=('film_share',),
    drivers=('speed', 'dwell'),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return the share [-] of F_s - F_c that the film takes off g(0, h).

    The state is the film as a share of its largest thickness, 1 - F_c / F_s.
    """
    film, ratio = state[0], min(abs(signals.motion.velocity) * parameters.growth, 1.0)
    steady = np.cbrt(ratio * ratio)
    if film_rests(signals.motion.velocity, signals.seal.sticking, model.friction):
        time = parameters.time_dwell
    elif film <= steady:
        time = parameters.time_acceleration
    else:
        time = parameters.time_deceleration
    rate[0] = (steady - film) / time
    return min(max(film, 0.0), 1.0), 0.0
