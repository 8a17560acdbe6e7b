"""Port areas that are not proportional to the way of the spool."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import FULL_VOLTAGE


class Parameters(NamedTuple):
    """Shape of the opening: how the edges of the spool are cut."""

    intake_exponent: Annotated[
        float, Quantity('-', 0.5, 3.0, 'the intake opens with this power of the way of the spool')
    ]
    exhaust_exponent: Annotated[
        float, Quantity('-', 0.5, 3.0, 'the exhaust opens with this power of the way of the spool')
    ]
    curvature: Annotated[
        float, Quantity('-', -0.5, 4.0, 'share by which both are wider, or saturate, at full way')
    ] = 0.0


@compiled
def bend(voltage: float, parameters: Parameters, model: CompiledModel) -> float:
    """
    Return the voltage [V] that a linear opening would need in addition.

    Share s of the full way W of the spool from the edge gives the opening K_V W (s^n + c s^2) on
    top of what the exhaust has at its edge: there, and fully open with c = 0, the port is that of
    Eq. 3. With c alone it is so where the opening is small, as K_V may have been found there. No
    opening is negative.
    """
    valve, curvature = model.valve, parameters.curvature
    if voltage > valve.intake_voltage:
        way = voltage - valve.intake_voltage
        share = way / (FULL_VOLTAGE - valve.intake_voltage)
        power = math.pow(share, parameters.intake_exponent - 1.0)
        return way * (max(power + curvature * share, 0.0) - 1.0)
    if voltage < valve.exhaust_voltage:
        way = valve.exhaust_voltage - voltage
        share = way / valve.exhaust_voltage
        power = math.pow(share, parameters.exhaust_exponent - 1.0)
        return -way * (max(power + curvature * share, 0.0) - 1.0)
    return 0.0


@Effect(
    title='valve ports open nonlinearly',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP),
    source='E. Richer, Y. Hurmuzlu, A High Performance Pneumatic Force Actuator System: Part I, '
    'J. Dyn. Sys., Meas., Control 122 (2000) (round ports), here as a power law and a parabola',
    null=Parameters(1.0, 1.0),
    probes=(
        *((exponent, exponent) for exponent in (0.85, 0.95, 1.05, 1.2)),
        *((1.0, exponent) for exponent in (0.9, 1.1)),
        *((exponent, 1.0) for exponent in (0.9, 1.1)),
        *((1.0, 1.0, curvature) for curvature in (-0.2, -0.05, 0.05, 0.2)),
    ),
    stage=2,
    drivers=('opening', 'pressure'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the voltages [V] to add to u1 and u2, so that Eq. 3 gives the bent opening."""
    bend_1 = bend(signals.ports.voltage_1, parameters, model)
    bend_2 = bend(signals.ports.voltage_2, parameters, model)
    return bend_1, bend_2
