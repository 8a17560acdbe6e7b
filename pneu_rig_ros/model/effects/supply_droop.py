"""Regulator and supply line: the supply pressure falls with the flow that is drawn."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime, falling_fixed_point
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import mass_flow_of_both

ACCURACY = 1e-10
"""Of the droop, as a share of the supply pressure [-]."""
TYPICAL_FLOW = 1e-4
"""Mass flow at which the resistance is stated [kg/s]."""


class Parameters(NamedTuple):
    """Regulator and supply line together: a power law of the mass flow."""

    resistance: Annotated[
        float,
        Quantity('Pa*s/kg', 0.0, 1e10, 'fall of the supply pressure by the mass flow, at 0.1 g/s'),
    ]
    exponent: Annotated[
        float,
        Quantity(
            '-', 0.2, 3.0, 'of the flow: 1 laminar, 2 turbulent, less for a valve that cracks open'
        ),
    ] = 1.0


@compiled
def fall(droop: float, signals: Signals, model: CompiledModel, line: Parameters) -> float:
    """Return the fall of the supply [Pa] by the flow that is drawn at a droop of it [Pa]."""
    share = mass_flow_of_both(signals, model, signals.ports.supply_1 - droop) / TYPICAL_FLOW
    return line.resistance * TYPICAL_FLOW * math.pow(share, line.exponent)


solve_droop = falling_fixed_point(fall)


@Effect(
    title='supply pressure falls with the flow drawn',
    balance=Balance.SUPPLY,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='ISO 6953-2:2015 (forward flow characteristics of regulators), taken as a power law; '
    'I. E. Idelchik, Handbook of Hydraulic Resistance (laminar and turbulent flow)',
    null=Parameters(0.0),
    probes=(
        *((resistance, 0.3) for resistance in (5e7, 5e8)),
        *((resistance,) for resistance in (1e8, 5e8, 2e9)),
        *((resistance, 2.0) for resistance in (1e8, 1e9)),
    ),
    drivers=('pressure_1', 'pressure_2', 'time'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return what both valves lack of the supply pressure [Pa].

    It is the droop d that solves d = R m_0 (m'/m_0)^n with m'(p_s - d). The flow falls with the
    droop, so there is one solution, between none and that of m'(p_s).
    """
    supply = signals.ports.supply_1
    most = min(fall(0.0, signals, model, parameters), supply)
    droop = solve_droop(most, ACCURACY * supply, signals, model, parameters)
    return -droop, -droop
