"""Friction that falls from a static to the Coulomb level as the piston speeds up."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Stribeck curve of Eq. 11, with F_s - F_c as the excess."""

    excess: Annotated[float, Quantity('N', 0.0, 1e3, 'friction at rest above F_c, F_s - F_c')]
    stribeck_velocity: Annotated[float, Quantity('m/s', 1e-4, 1.0, 'Stribeck velocity, v_s')]
    stribeck_exponent: Annotated[float, Quantity('-', 0.1, 10.0, 'Stribeck exponent, n')]


@Effect(
    title='friction is higher at rest than in motion (Stribeck)',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='Eq. 11 of the paper; C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, '
    'A New Model for Control of Systems with Friction, IEEE Trans. Autom. Control 40 (1995)',
    null=Parameters(0.0, 0.01, 2.0),
    probes=(
        (2.0, 0.01, 2.0),
        (5.0, 0.003, 1.0),
        (5.0, 0.01, 2.0),
        (12.0, 0.03, 1.0),
        (12.0, 0.01, 2.5),
    ),
    laws=('coulomb_viscous',),
    drivers=('speed', 'velocity', 'pressure_1', 'pressure_2', 'position'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """Return the excess at the present speed, added to F_c [N], and nothing for F_smax."""
    ratio = abs(signals.motion.velocity) / parameters.stribeck_velocity
    return parameters.excess * math.exp(-math.pow(ratio, parameters.stribeck_exponent)), 0.0
