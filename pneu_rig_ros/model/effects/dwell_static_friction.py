"""Static friction that grows with the time at rest (Eq. 16)."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.friction import grown_static_friction
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Eq. 16; its F_smax takes the place of the constant static friction of the law."""

    breakaway_force: Annotated[
        float, Quantity('N', 0.0, 1e3, 'static friction after a long rest, F_smax; at least F_c')
    ]
    dwell_coefficient: Annotated[float, Quantity('s^-alpha', 0.0, 1e3, 'gamma of Eq. 16')]
    dwell_exponent: Annotated[float, Quantity('-', 0.01, 2.0, 'alpha of Eq. 16')]


@Effect(
    title='static friction grows with the time at rest',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='Eq. 16 of the paper; S. Kato, N. Sato, T. Matsubayashi, Some Considerations on '
    'Characteristics of Static Friction of Machine Tool Slideway, J. Lubr. Technol. 94 (1972)',
    null=Parameters(0.0, 1.0, 0.5),
    probes=((10.0, 0.5, 0.5), (16.0, 0.2, 0.5), (25.0, 0.2, 0.5), (35.0, 0.5, 0.3)),
    laws=('lugre', 'revised_lugre'),
    clock=('dwell_coefficient', 'dwell_exponent'),
    readings=('static_friction_reading',),
    stage=1,
    drivers=('dwell', 'pressure_1', 'pressure_2', 'position'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return no change of F_c, and what is added to F_smax [N] so that F_s becomes Eq. 16.

    Both levels are those that the other effects leave. The law's reading of Eq. 16 says what F_s
    does during the slip.
    """
    if parameters.breakaway_force <= 0.0:
        return 0.0, 0.0
    seal = signals.seal
    coulomb, added = seal.coulomb_force, seal.static_force - model.friction.breakaway_force
    static = grown_static_friction(
        max(seal.dwell_time, 0.0),
        max(parameters.breakaway_force + added, coulomb),
        coulomb,
        parameters.dwell_coefficient,
        parameters.dwell_exponent,
    )
    return 0.0, static - seal.static_force
