"""Static friction that recovers at rest from what a slip has left of it."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.friction import grown_static_friction
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Share that a slip takes, and how fast it comes back."""

    lost_share: Annotated[
        float, Quantity('-', 0.0, 1.0, 'share of F_smax - F_c that is not there at first')
    ]
    dwell_coefficient: Annotated[float, Quantity('s^-alpha', 0.0, 1e3, 'gamma of Eq. 16')]
    dwell_exponent: Annotated[float, Quantity('-', 0.01, 2.0, 'alpha of Eq. 16')]


@Effect(
    title='static friction recovers at rest from what a slip has left',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='S. Kato, N. Sato, T. Matsubayashi, Some Considerations on Characteristics of Static '
    'Friction of Machine Tool Slideway, J. Lubr. Technol. 94 (1972)',
    null=Parameters(0.0, 1.0, 0.5),
    probes=((0.2, 0.5, 0.5), (0.5, 0.5, 0.5), (0.5, 0.2, 0.3), (0.9, 0.5, 0.3)),
    laws=('lugre', 'revised_lugre'),
    clock=('dwell_coefficient', 'dwell_exponent'),
    readings=('static_friction_reading',),
    stage=1,
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return no change of F_c, and what F_smax lacks [N].

    With a lost share of 1 it is Eq. 16, in which nothing but F_c is there at first.
    """
    if parameters.lost_share <= 0.0:
        return 0.0, 0.0
    seal = signals.seal
    excess = max(seal.static_force - seal.coulomb_force, 0.0)
    static = grown_static_friction(
        max(seal.dwell_time, 0.0),
        seal.static_force,
        seal.static_force - parameters.lost_share * excess,
        parameters.dwell_coefficient,
        parameters.dwell_exponent,
    )
    return 0.0, static - seal.static_force
