"""Leakage of the chambers to atmosphere through porous walls: a power of the gauge pressure."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity

REFERENCE = 1e5
"""Gauge pressure at which the flow is as stated [Pa]."""
SMALLEST = 1e-3
"""Gauge pressure below which the flow is linear [-]: a power below 1 has an infinite slope."""


class Parameters(NamedTuple):
    """
    Flows at 1 bar above atmosphere, and the power of the pressure with which they grow.

    The power is 1/2 where all is lost by inertia, 1 where viscosity resists a gas of constant
    density, and 2, as of p^2 - p_atm^2, where it resists a gas that expands far on its way out.
    """

    flow_1: Annotated[float, Quantity('kg/s', 0.0, 0.01, 'leak of chamber 1 at 1 bar gauge')]
    flow_2: Annotated[float, Quantity('kg/s', 0.0, 0.01, 'leak of chamber 2 at 1 bar gauge')]
    exponent: Annotated[float, Quantity('-', 0.5, 2.0, 'power of the gauge pressure')]


@compiled
def leak(pressure: float, flow: float, exponent: float, outside: float) -> float:
    """
    Return the mass flow [kg/s] out of a chamber; air is drawn in below atmosphere.

    :param pressure: of the chamber, absolute [Pa]
    :param flow: at 1 bar gauge [kg/s]
    :param outside: pressure of the atmosphere [Pa]
    """
    gauge = (pressure - outside) / REFERENCE
    size = max(abs(gauge), SMALLEST)
    return flow * gauge * math.pow(size, exponent - 1.0)


@Effect(
    title='chambers leak through porous walls',
    balance=Balance.MASS,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='P. Forchheimer, Wasserbewegung durch Boden, Z. VDI 45 (1901); G. S. Beavers, '
    'E. M. Sparrow, Non-Darcy Flow Through Fibrous Porous Media, J. Appl. Mech. 36 (1969); as a '
    'power law in ISO 9972:2015',
    null=Parameters(0.0, 0.0, 1.0),
    probes=((3e-6, 0.0, 1.2), (0.0, 2e-5, 1.0), (3e-6, 3e-6, 1.0), (2e-5, 2e-5, 1.5)),
    drivers=('position',),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the mass flows [kg/s] into chamber 1 and 2."""
    outside, power = model.gas.atmospheric_pressure, parameters.exponent
    leak_1 = leak(signals.gas.pressure_1, parameters.flow_1, power, outside)
    leak_2 = leak(signals.gas.pressure_2, parameters.flow_2, power, outside)
    return -leak_1, -leak_2
