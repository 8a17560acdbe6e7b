"""Seal friction that grows with the pressure that presses the lips on."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Growth of the friction level with gauge pressure."""

    slope: Annotated[float, Quantity('N/Pa', 0.0, 1e-3, 'growth of F_c and F_smax with p1 + p2')]


@Effect(
    title='seal friction grows with pressure',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='G. Belforte, T. Raparelli, M. Velardocchia, Study of the Behavior of Lip Seals in '
    'Pneumatic Actuators, Lubrication Engineering 49 (1993)',
    null=Parameters(0.0),
    probes=((3e-6,), (1e-5,), (3e-5,)),
    drivers=('pressure_1', 'pressure_2', 'difference', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return what is added to F_c and to F_smax [N], from the gauge pressures of both sides."""
    gauge = signals.gas.pressure_1 + signals.gas.pressure_2 - 2.0 * model.gas.atmospheric_pressure
    added = parameters.slope * max(gauge, 0.0)
    return added, added
