"""Seal friction that drifts with time, whether the piston moves or not: warming up, ageing."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime, drift
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """How fast the friction level changes at the start, and how far it changes at most."""

    rate: Annotated[float, Quantity('1/s', -1.0, 1.0, 'share added in each second at first')]
    limit: Annotated[float, Quantity('-', 0.05, 2.0, 'share by which the level changes at most')]


@Effect(
    title='friction drifts with time',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='L. Simoni, M. Beschi, G. Legnani, A. Visioli, Friction Modeling with Temperature '
    'Effects for Industrial Robot Manipulators, IROS 2015; here exponential in time',
    null=Parameters(0.0, 0.5),
    probes=tuple((rate, 0.5) for rate in (-0.1, -0.02, 0.02, 0.1)),
    drivers=('speed',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to F_c and to F_smax [N]: a drift with the time since the start."""
    share = drift(parameters.rate, parameters.limit, signals.time)
    return share * model.friction.coulomb_force, share * model.friction.breakaway_force
