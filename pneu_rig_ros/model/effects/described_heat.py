"""A description, not a cause: a heat flow into each chamber that is linear in simple terms."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Coefficients, of both chambers or of one; pressures count in supply pressures."""

    constant: Annotated[float, Quantity('W', -100.0, 100.0, 'heat flow into either chamber')]
    gauge: Annotated[float, Quantity('W', -100.0, 100.0, 'times its gauge pressure')]
    cold: Annotated[float, Quantity('W/K', 0.0, 5.0, 'times T_s - T, supply less gas')]
    cold_1: Annotated[float, Quantity('W/K', 0.0, 5.0, 'the same, chamber 1 alone')]
    cold_2: Annotated[float, Quantity('W/K', 0.0, 5.0, 'the same, chamber 2 alone')]


@compiled
def contribution(
    signals: Signals,
    model: CompiledModel,
    parameters: Parameters,
    state: NDArray[np.float64],
    rate: NDArray[np.float64],
) -> tuple[float, float]:
    """Return the heat flows [W] into chamber 1 and 2, less out of cold gas."""
    c, s, gas, supply = parameters, signals, model.gas, model.operation.supply_pressure
    gas_1 = s.pressure_1 * s.volume_1 / (s.gas_mass_1 * gas.gas_constant)
    gas_2 = s.pressure_2 * s.volume_2 / (s.gas_mass_2 * gas.gas_constant)
    gauge_1 = (s.pressure_1 - gas.atmospheric_pressure) / supply
    gauge_2 = (s.pressure_2 - gas.atmospheric_pressure) / supply
    cold_1, cold_2 = gas.supply_temperature - gas_1, gas.supply_temperature - gas_2
    heat_1 = c.constant + c.gauge * gauge_1 + (c.cold + c.cold_1) * cold_1
    heat_2 = c.constant + c.gauge * gauge_2 + (c.cold + c.cold_2) * cold_2
    left_1 = min(gas_1 / gas.supply_temperature, 1.0)
    left_2 = min(gas_2 / gas.supply_temperature, 1.0)
    return max(heat_1, heat_1 * left_1), max(heat_2, heat_2 * left_2)


EFFECT = Effect(
    title='a heat flow nobody has named yet',
    balance=Balance.HEAT,
    regimes=(Regime.DWELL, Regime.SLIDING, Regime.END_STOP),
    source='a fit to data: a description, not a cause',
    parameters=Parameters,
    null=Parameters(0.0, 0.0, 0.0, 0.0, 0.0),
    contribution=contribution,
    probes=(Parameters(0.5, 0.5, 0.1, 0.1, 0.1), Parameters(-0.5, -0.5, 0.3, 0.3, 0.3)),
    describes=True,
)
