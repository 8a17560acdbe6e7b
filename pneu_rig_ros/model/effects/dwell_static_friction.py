"""Static friction that grows with the time at rest (Eq. 16), from F_c or from above it."""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.friction import grown_static_friction
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Eq. 16 with the share that a slip takes, all of it in the paper."""

    lost_share: Annotated[
        float, Quantity('-', 0.0, 1.0, 'share of F_smax - F_c that is not there at first')
    ]
    dwell_coefficient: Annotated[float, Quantity('s^-alpha', 0.0, 1e3, 'gamma of Eq. 16')]
    dwell_exponent: Annotated[float, Quantity('-', 0.01, 2.0, 'alpha of Eq. 16')]
    excess_ratio: Annotated[
        float, Quantity('-', 0.0, 10.0, 'F_smax - F_c over the F_s - F_c of the friction law')
    ] = 1.0


@Effect(
    title='static friction grows with the time at rest',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='Eq. 16 of the paper; S. Kato, N. Sato, T. Matsubayashi, Some Considerations on '
    'Characteristics of Static Friction of Machine Tool Slideway, J. Lubr. Technol. 94 (1972)',
    null=Parameters(0.0, 1.0, 0.5),
    probes=(
        *((0.2, 0.5, 0.5), (0.5, 0.5, 0.5), (0.5, 0.2, 0.3), (0.9, 0.5, 0.3), (0.9, 0.2, 0.5)),
        *((0.9, 0.2, 0.5, 1.3), (0.9, 0.5, 0.3, 1.3), (0.9, 0.2, 0.5, 2.0)),
    ),
    laws=('lugre', 'revised_lugre'),
    clock=('dwell_coefficient', 'dwell_exponent'),
    readings=('static_friction_reading',),
    stage=1,
    drivers=('dwell', 'pressure_1', 'pressure_2', 'position'),
)
def contribution(signals: Signals, model: CompiledModel, parameters: Parameters) -> Pair:
    """
    Return no change of F_c, and what F_smax lacks, or has too much [N].

    Both levels are those that the other effects leave. The law's reading of Eq. 16 says what F_s
    does during the slip.
    """
    seal = signals.seal
    excess = max(seal.static_force - seal.coulomb_force, 0.0)
    grown = grown_static_friction(  # in units of the excess, so that nothing lost is exactly 0 N
        max(seal.dwell_time, 0.0),
        parameters.excess_ratio,
        parameters.excess_ratio * (1.0 - parameters.lost_share),
        parameters.dwell_coefficient,
        parameters.dwell_exponent,
    )
    return 0.0, excess * (grown - 1.0)
