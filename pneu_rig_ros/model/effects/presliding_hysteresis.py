"""Presliding hysteresis: a part of the bristles slips before the seal does."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.quantity import Quantity

DEFLECTION_UNIT = 1e-4
"""Unit of the state [m], so that the integrator's tolerance is a small deflection."""
DRAG_TIME = 1e-3
"""Time in which the slipping element is dragged along [s]; below a sampling interval."""


class Parameters(NamedTuple):
    """One Maxwell-slip element beside the bristles of the law."""

    stiffness: Annotated[float, Quantity('N/m', 0.0, 1e6, 'stiffness of the element')]
    limit: Annotated[float, Quantity('N', 0.0, 1e3, 'force at which the element slips')]


@Effect(
    title='bristles slip one after another before the piston does',
    balance=Balance.BRISTLE,
    regimes=(Regime.PRESLIDING, Regime.BREAKAWAY),
    source='F. Al-Bender, V. Lampaert, J. Swevers, The Generalized Maxwell-Slip Model: A '
    'Novel Model for Friction Simulation and Compensation, IEEE Trans. Autom. Control 50 (2005)',
    null=Parameters(0.0, 1.0),
    probes=((3e4, 2.0), (1e5, 2.0), (1e5, 8.0), (3e5, 5.0)),
    states=('relaxed_deflection',),
    drivers=('position', 'pressure_1', 'pressure_2'),
)
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> Pair:
    """
    Return what is added to F(z) [N] and to its stiffness [N/m].

    The state is the deflection at which the element is relaxed. The element slips where its
    spring would exceed the limit, and drags that deflection along.
    """
    if parameters.stiffness <= 0.0 or parameters.limit <= 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    reach = parameters.limit / parameters.stiffness
    bent = signals.seal.deflection - DEFLECTION_UNIT * state[0]
    inside = min(max(bent, -reach), reach)
    rate[0] = (bent - inside) / (DEFLECTION_UNIT * DRAG_TIME)
    return parameters.stiffness * inside, parameters.stiffness if bent == inside else 0.0
