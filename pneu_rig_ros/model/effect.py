"""What an optional physical effect declares about itself."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

from pneu_rig_ros.model.compiled import compiled


class Balance(Enum):
    """
    Where a pair of contributions enters the plant, with the unit of both.

    ===========  ======  ==========================================================
    balance      unit    pair
    ===========  ======  ==========================================================
    ``SPOOL``    V       added to the control voltages u1, u2 (Eq. 3)
    ``SUPPLY``   Pa      added to the supply pressure seen by valve 1, valve 2 (Eq. 3)
    ``MASS``     kg/s    added to the mass flows into chamber 1, 2 (Eq. 6)
    ``HEAT``     W       heat flows into the gas of chamber 1, 2 (Eq. 6)
    ``LEVEL``    N       added to the Coulomb force F_c, the static force F_smax (Eq. 11, 16)
    ``FORCE``    N       added to the driving force; the second is added mass [kg] (Eq. 8)
    ===========  ======  ==========================================================
    """

    SPOOL = 'V'
    SUPPLY = 'Pa'
    MASS = 'kg/s'
    HEAT = 'W'
    LEVEL = 'N'
    FORCE = 'N, kg'


class Signals(NamedTuple):
    """
    What a contribution may look at besides the parameters; all scalars, SI units.

    The voltages are the commanded ones, but for ``SUPPLY`` and ``MASS`` those at which the spools
    stand: the contributions to ``SPOOL`` are already in them.
    """

    time: float
    position: float
    velocity: float
    pressure_1: float
    pressure_2: float
    volume_1: float
    volume_2: float
    gas_mass_1: float
    gas_mass_2: float
    voltage_1: float
    voltage_2: float
    bristle_force: float
    sticking: bool


@compiled
def with_voltages(signals: Signals, voltage_1: float, voltage_2: float) -> Signals:
    """Return the signals with other voltages u1, u2 [V]."""
    s = signals
    return Signals(
        s.time, s.position, s.velocity, s.pressure_1, s.pressure_2, s.volume_1, s.volume_2,
        s.gas_mass_1, s.gas_mass_2, voltage_1, voltage_2, s.bristle_force, s.sticking,
    )  # fmt: skip


@dataclass(frozen=True)
class Effect:
    """
    One optional physical effect; everything else follows from this record.

    :param title: a short sentence
    :param balance: where the contribution enters
    :param regimes: where it must show: any of dwell, presliding, breakaway, sliding, end stop
    :param source: literature
    :param parameters: ``NamedTuple`` class, each field ``Annotated`` with its ``Quantity``
    :param null: the parameters with which the effect vanishes exactly
    :param states: names of the effect's own states, each starting at zero
    :param contribution: ``f(signals, model, parameters, state, rate) -> (first, second)``,
        compiled. It writes d(state)/dt into ``rate``, both of shape ``(len(states),)``
    """

    title: str
    balance: Balance
    regimes: tuple[str, ...]
    source: str
    parameters: type[Any]
    null: Any
    contribution: Callable[..., tuple[float, float]]
    states: tuple[str, ...] = ()
