"""Leakage past the piston seal, from one chamber into the other."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import port_flow


class Parameters(NamedTuple):
    """Effective area of the leak."""

    area: Annotated[float, Quantity('m^2', 0.0, 1e-4, 'effective leak area past the piston')]


@Effect(
    title='the piston seal leaks',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='E. Richer, Y. Hurmuzlu, A High Performance Pneumatic Force Actuator System: Part I, '
    'J. Dyn. Sys., Meas., Control 122 (2000)',
    null=Parameters(0.0),
    probes=((5e-10,), (2e-9,), (1e-8,), (2e-8,)),
    needs=(Need.BOTH_CHAMBERS,),
    drivers=('difference', 'position', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the mass flows [kg/s] into chamber 1 and 2, equal and opposite: Eq. 3."""
    p1, p2 = signals.gas.pressure_1, signals.gas.pressure_2
    leak = port_flow(p1, p2, parameters.area, model.valve, model.gas)
    return -leak, leak
