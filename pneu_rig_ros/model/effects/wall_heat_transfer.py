"""Heat exchange between the gas and the cylinder wall."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Conductance between gas and wall, the wall being at supply temperature."""

    conductance_1: Annotated[float, Quantity('W/K', 0.0, 100.0, 'conductance of chamber 1')]
    conductance_2: Annotated[float, Quantity('W/K', 0.0, 100.0, 'conductance of chamber 2')]


@Effect(
    title='gas exchanges heat with the chamber walls',
    balance=Balance.HEAT,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='P. Beater, Pneumatic Drives, Springer 2007; Newton cooling, ideal gas',
    null=Parameters(0.0, 0.0),
    probes=((0.05, 0.05), (0.2, 0.0), (0.0, 0.2), (0.6, 0.6)),
    drivers=('pressure', 'temperature', 'position', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the heat flows [W] into the gas of chamber 1 and 2: Newton's law of cooling."""
    gas, wall = signals.gas, model.gas.supply_temperature
    gas_1 = chambers.temperature(gas.pressure_1, gas.volume_1, gas.gas_mass_1, model.gas)
    gas_2 = chambers.temperature(gas.pressure_2, gas.volume_2, gas.gas_mass_2, model.gas)
    return parameters.conductance_1 * (wall - gas_1), parameters.conductance_2 * (wall - gas_2)
