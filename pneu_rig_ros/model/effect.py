"""What an optional physical effect declares about itself."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from functools import cached_property
from typing import Any

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import Pair, Signals
from pneu_rig_ros.model.quantity import specifications


class Balance(Enum):
    """
    Where a pair of contributions enters the plant, with the unit of both.

    ====================  =======  ======================================================
    balance               unit     pair
    ====================  =======  ======================================================
    ``SPOOL``             V        added to the control voltages u1, u2 (Eq. 3)
    ``SUPPLY``            Pa       added to the supply pressure at valve 1, valve 2 (Eq. 3)
    ``MASS``              kg/s     added to the mass flows into chamber 1, 2 (Eq. 6)
    ``HEAT``              W        heat flows into the gas of chamber 1, 2 (Eq. 6)
    ``BRISTLE``           N, N/m   added to F(z) and to its stiffness (Eq. 9)
    ``LEVEL``             N        added to the Coulomb force F_c, the static force F_smax
                                   (Eq. 11, 16)
    ``FILM``              -        share by which g(0, h) falls from F_s towards F_c (Eq. 11);
                                   the second is not used
    ``FORCE``             N, kg    added to the driving force, and to the mass (Eq. 8)
    ``MOTION_READING``    m, m/s   added to what the sensors read as x and v
    ``PRESSURE_READING``  Pa       added to what the sensors read as p1, p2
    ====================  =======  ======================================================

    Effects on the same balance are summed, each seeing the signals without the others. Those on
    ``SPOOL`` and ``LEVEL`` are chains: each sees the voltages, or the Coulomb and static force,
    that the earlier stages leave.
    """

    SPOOL = 'V'
    SUPPLY = 'Pa'
    MASS = 'kg/s'
    HEAT = 'W'
    BRISTLE = 'N, N/m'
    LEVEL = 'N'
    FILM = '-'
    FORCE = 'N, kg'
    MOTION_READING = 'm, m/s'
    PRESSURE_READING = 'Pa (read)'

    @property
    def unit(self) -> str:
        """Unit of the pair; two units where the two differ."""
        return self.value.removesuffix(' (read)')


class Regime(IntEnum):
    """Regime of motion of the piston; `analysis.regimes` defines how each is detected."""

    DWELL = 0
    PRESLIDING = 1
    BREAKAWAY = 2
    SLIDING = 3
    END_STOP = 4

    @property
    def label(self) -> str:
        """Display name, such as 'end stop'."""
        return self.name.lower().replace('_', ' ')


class Need(Enum):
    """What must be there for an effect to show, where not all of a rig is."""

    VALVES = 'valves that are connected'
    BOTH_CHAMBERS = 'the pressures of both chambers'
    FREE_MOTION = 'accelerations, which a motion that is imposed does not have'
    MILLISECONDS = 'samples milliseconds apart'


LEAST_TIME = 1e-3
"""Shortest lag that is integrated [s], or steps would have no lower end."""
LEAST_LEVEL = 0.1
"""Share of the level of friction that remains, however far it drifts [-]."""
MOST_ROUNDS = 60
"""
Rounds of false position at most; some five are needed, 25 where a flow is nearly shut off by what
it makes.
"""

GAS_BALANCES = (Balance.SPOOL, Balance.SUPPLY, Balance.MASS, Balance.HEAT)
"""What acts on the gas whatever the forces do."""
READING_BALANCES = (Balance.MOTION_READING, Balance.PRESSURE_READING)
"""What acts on the sensors alone."""


@compiled
def integrated_lag(time_constant: float) -> tuple[float, float]:
    """
    Return the time constant that is integrated [s] and the share of its lag that acts [-].

    A lag T below ``LEAST_TIME`` T' acts as T/T' of that one, the same to first order in T.
    """
    time = max(time_constant, LEAST_TIME)
    return time, time_constant / time


@compiled
def drift(rate: float, limit: float, gone: float) -> float:
    """
    Return the share [-] by which a level of friction has drifted.

    It is ``+- limit (1 - exp(-|rate| gone / limit))``, of the sign of the rate, but leaves at
    least ``LEAST_LEVEL`` of the level.

    :param rate: share that is added at first, for each second or metre [1/s or 1/m]
    :param limit: share at most [-]
    :param gone: time or way so far [s or m]
    """
    done = -math.expm1(-abs(rate) * max(gone, 0.0) / limit)
    return max(math.copysign(limit, rate) * done, LEAST_LEVEL - 1.0)


def falling_fixed_point(function: Callable[..., float]) -> Callable[..., float]:
    """
    Return the compiled solution x of ``x = function(x, ...)``, where the function falls.

    ``solution(most, accuracy, ...)`` is between 0 and ``most``, which is the function at 0, or
    less where more is not possible; by false position (M. Dowell, P. Jarratt, BIT 11 (1971):
    Illinois).
    """

    @compiled
    def solution(most: float, accuracy: float, *given: Any) -> float:
        low, at_low, high, at_high = 0.0, -most, most, most - function(most, *given)
        moved = 0  # the bound that moved last: -1 the lower, 1 the upper
        for _ in range(MOST_ROUNDS):
            if high - low <= accuracy or at_high <= 0.0:
                break
            middle = (low * at_high - high * at_low) / (at_high - at_low)
            excess = middle - function(middle, *given)
            if abs(excess) <= accuracy:
                return middle
            if excess < 0.0:  # a bound that is kept twice weighs less
                low, at_low, at_high = middle, excess, at_high * (0.5 if moved < 0 else 1.0)
                moved = -1
            else:
                high, at_high, at_low = middle, excess, at_low * (0.5 if moved > 0 else 1.0)
                moved = 1
        return high

    return solution


@compiled
def _nothing(signals: Signals, model: Any, parameters: Any) -> Pair:
    return 0.0, 0.0


@dataclass(frozen=True)
class Effect:
    """
    One optional physical effect; everything else follows from this record.

    As a decorator it compiles a function and takes it for its contribution.

    :param title: a short sentence
    :param balance: where the contribution enters
    :param regimes: where it must show
    :param source: literature
    :param null: the parameters with which the effect vanishes exactly, a ``NamedTuple`` of
        numbers, each field ``Annotated`` with its ``Quantity``
    :param probes: a few plausible strengths, weak to strong, from which a fit starts; each a tuple
        of the numbers in ``null``, of which those with a default may be omitted
    :param laws: names of the friction laws that lack it; none named: it adds to any law
    :param clock: names of parameters that replace those of the dwell clock of the law
    :param readings: names of the choices of the friction law that matter with it alone: a law
        that lacks it does not define them, and a diagnosis tries them all
    :param stage: place in the chain of its balance, where the balance is one
    :param states: names of the effect's own states, each starting at zero
    :param strengths: names of the parameters to which the contribution is proportional as a whole;
        none named: those in the unit of the first one
    :param describes: whether it only describes what has no name yet: no candidate for a name; a
        parameter that is no strength is then a constant of the terms, and a state has the name of
        its coefficient
    :param drivers: variables over which its form may differ, see ``shape``, first the likeliest
    :param needs: without any of which it does not show in a part of a rig
    :param fastest: ``f(parameters, model)``, the shortest time in which its states change [s];
        without it the least of the parameters in seconds, or ``LEAST_TIME``
    :param as_array: whether the contribution takes the parameters as an array, as suits many, and
        always the states
    :param contribution: ``f(signals, model, parameters) -> (first, second)``, compiled; with
        states ``f(signals, model, parameters, state, rate)``, which writes d(state)/dt into
        ``rate``, both of shape ``(len(states),)``
    :raises RigError: when the regimes are not some of :class:`Regime`, each once
    """

    title: str
    balance: Balance
    regimes: tuple[Regime, ...]
    source: str
    null: Any
    probes: tuple[Any, ...]
    laws: tuple[str, ...] = ()
    clock: tuple[str, ...] = ()
    readings: tuple[str, ...] = ()
    stage: int = 0
    states: tuple[str, ...] = ()
    strengths: tuple[str, ...] = ()
    describes: bool = False
    drivers: tuple[str, ...] = ()
    needs: tuple[Need, ...] = ()
    fastest: Callable[[Any, Any], float] | None = None
    as_array: bool = False
    contribution: Callable[..., Pair] = _nothing

    def __call__(self, contribution: Callable[..., Pair]) -> 'Effect':
        """Return the effect with a contribution, which this compiles."""
        return replace(self, contribution=compiled(contribution))

    def __post_init__(self) -> None:
        """Make parameters of the probes; check the regimes, which a fit and its report rely on."""
        probes = tuple(self.parameters(*probe) for probe in self.probes)
        object.__setattr__(self, 'probes', probes)
        known = all(isinstance(regime, Regime) for regime in self.regimes)
        if not self.regimes or not known or len(set(self.regimes)) < len(self.regimes):
            allowed = ', '.join(f'Regime.{regime.name}' for regime in Regime)
            wrong = f'regimes {self.regimes!r}, must be some of {allowed}, each once'
            raise RigError(f'effect "{self.title}": {wrong}')

    @property
    def parameters(self) -> type[Any]:
        """The class of the parameters."""
        return type(self.null)

    @property
    def takes_states(self) -> bool:
        """Whether the contribution takes the states and their rates."""
        return self.as_array or bool(self.states)

    @property
    def proportional(self) -> tuple[str, ...]:
        """Names of the parameters to which the contribution is proportional as a whole."""
        first = next(iter(self._units.values()))
        return self.strengths or tuple(n for n, unit in self._units.items() if unit == first)

    def shortest_time(self, parameters: Any, model: Any) -> float:
        """Return the shortest time in which the states change in a model [s]."""
        if self.fastest is not None:
            return max(self.fastest(parameters, model), LEAST_TIME)
        times = [getattr(parameters, name) for name, unit in self._units.items() if unit == 's']
        return max(min(times, default=0.0), LEAST_TIME)

    @cached_property
    def _units(self) -> dict[str, str]:
        """Name of each parameter -> unit, '' where it has none."""
        given = specifications(self.parameters)
        return {name: getattr(each, 'unit', '') for name, each in given.items()}
