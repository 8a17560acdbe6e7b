"""Leakage of the chambers to atmosphere, past the rod seal and the fittings."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import port_flow


class Parameters(NamedTuple):
    """Effective areas of the leaks."""

    area_1: Annotated[float, Quantity('m^2', 0.0, 1e-4, 'effective leak area of chamber 1')]
    area_2: Annotated[float, Quantity('m^2', 0.0, 1e-4, 'effective leak area of chamber 2')]


@Effect(
    title='chambers leak to atmosphere',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='ISO 6358-1:2013 with the effective area as the parameter',
    null=Parameters(0.0, 0.0),
    probes=((1e-9, 0.0), (0.0, 1e-9), (3e-9, 3e-9), (2e-8, 2e-8)),
    drivers=('pressure', 'position'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the mass flows [kg/s] into chamber 1 and 2: Eq. 3 with a fixed opening."""
    outside = model.gas.atmospheric_pressure
    leak_1 = port_flow(signals.gas.pressure_1, outside, parameters.area_1, model.valve, model.gas)
    leak_2 = port_flow(signals.gas.pressure_2, outside, parameters.area_2, model.valve, model.gas)
    return -leak_1, -leak_2
