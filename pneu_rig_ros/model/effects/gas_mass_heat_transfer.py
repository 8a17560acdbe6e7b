"""Heat exchange between the gas and the cylinder wall in proportion to the mass of the gas."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Rate of both chambers, the wall being at supply temperature."""

    rate: Annotated[
        float,
        Quantity('1/s', 0.0, 50.0, 'rate at which the gas takes on the temperature of the wall'),
    ]


@compiled
def heat(
    pressure: float, volume: float, mass: float, model: CompiledModel, law: Parameters
) -> float:
    """Return the heat flow [W] into the gas of a chamber, with its capacity at fixed volume."""
    gas = model.gas
    capacity = mass * gas.gas_constant / (gas.heat_capacity_ratio - 1.0)
    return (
        law.rate
        * capacity
        * (gas.supply_temperature - chambers.temperature(pressure, volume, mass, gas))
    )


@Effect(
    title='gas exchanges heat with the chamber walls in proportion to its mass',
    balance=Balance.HEAT,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='T. Kagawa, Heat Transfer Effects on the Frequency Response of a Pneumatic Nozzle '
    'Flapper, J. Dyn. Sys., Meas., Control 107 (1985): a thermal time constant',
    null=Parameters(0.0),
    probes=((0.1,), (0.4,), (1.5,)),
    needs=(Need.VALVES,),  # which change the mass: without them it is `wall_heat_transfer`
    drivers=('pressure', 'temperature', 'position', 'speed'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the heat flows [W] into the gas of chamber 1 and 2."""
    g = signals.gas
    heat_1 = heat(g.pressure_1, g.volume_1, g.gas_mass_1, model, parameters)
    return heat_1, heat(g.pressure_2, g.volume_2, g.gas_mass_2, model, parameters)
