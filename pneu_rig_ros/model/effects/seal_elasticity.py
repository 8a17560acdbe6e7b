"""Elastic seals: after a reversal their force rises over a way before they slide."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Need, Regime
from pneu_rig_ros.model.quantity import Quantity

DEFLECTION_UNIT = 1e-4
"""Unit of the state [m], so that the integrator's tolerance is a small deflection."""
DRAG_TIME = 1e-3
"""Time in which the element slips back to its limit [s]; below a sampling interval."""


class Parameters(NamedTuple):
    """One element of elasticity and slip on the travel of the piston."""

    limit: Annotated[float, Quantity('N', 0.0, 1e3, 'force at which the element slips')]
    reach: Annotated[float, Quantity('m', 1e-6, 1e-2, 'way over which the force rises to it')]


@Effect(
    title='seals deform elastically before they slide',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='W. D. Iwan, A Distributed-Element Model for Hysteresis and Its Steady-State Dynamic '
    'Response, J. Appl. Mech. 33 (1966), one element',
    null=Parameters(0.0, 3e-4),
    probes=((0.5, 1e-4), (0.5, 5e-4), (3.0, 1e-4), (3.0, 5e-4)),
    states=('seal_deflection',),
    needs=(Need.FREE_MOTION,),
    drivers=(),  # a factor on an elastic force would make energy
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return the force of the element along the outstroke [N], and no added mass.

    The state is its deflection. It does not depend on the bristles of Eq. 9, but follows the
    travel of the piston itself: a lip that turns over, or a ring that rolls.
    """
    if parameters.limit <= 0.0:
        rate[0] = 0.0
        return 0.0, 0.0
    bent = DEFLECTION_UNIT * state[0]
    inside = min(max(bent, -parameters.reach), parameters.reach)
    rate[0] = (signals.motion.velocity - (bent - inside) / DRAG_TIME) / DEFLECTION_UNIT
    return -parameters.limit * inside / parameters.reach, 0.0
