"""What an optional physical effect declares about itself."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from functools import cached_property
from typing import Any, NamedTuple

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.quantity import specifications

Pair = tuple[float, float]
"""What an effect contributes, see :class:`Balance`."""


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

GAS_BALANCES = (Balance.SPOOL, Balance.SUPPLY, Balance.MASS, Balance.HEAT)
"""What acts on the gas whatever the forces do."""
READING_BALANCES = (Balance.MOTION_READING, Balance.PRESSURE_READING)
"""What acts on the sensors alone."""


class Motion(NamedTuple):
    """Position [m] and velocity [m/s] of the piston."""

    position: float
    velocity: float


class ChamberGas(NamedTuple):
    """Absolute pressures [Pa], volumes [m^3] and gas masses [kg] of the chambers."""

    pressure_1: float
    pressure_2: float
    volume_1: float
    volume_2: float
    gas_mass_1: float
    gas_mass_2: float


class Ports(NamedTuple):
    """
    Control voltages [V] and supply pressures [Pa, absolute] of the valves.

    The commanded voltages and the supply pressures of the regulator; for ``MASS`` both as they are
    at the ports, the contributions to ``SPOOL`` and ``SUPPLY`` in them (``SUPPLY`` sees the
    voltages at the ports).
    """

    voltage_1: float
    voltage_2: float
    supply_1: float
    supply_2: float


class Seal(NamedTuple):
    """
    Bristle deflection [m] and force F(z) [N], whether the piston rests, dwell [s], levels [N].

    ``bristle_force`` has, for ``LEVEL`` and later ones, the contributions to ``BRISTLE`` in it.
    ``dwell_time`` is the dwell that static friction stands for under the reading of Eq. 16;
    latched at breakaway, it is the time at rest so far while the piston sticks, and the dwell
    before the last breakaway while it slides; fading while sliding, it is the dwell that would
    give what is left of F_s. ``coulomb_force`` and ``static_force`` are F_c and F_smax of the law;
    for ``LEVEL`` with what the earlier stages add.
    """

    deflection: float
    bristle_force: float
    sticking: bool
    dwell_time: float
    coulomb_force: float
    static_force: float


class Signals(NamedTuple):
    """
    What a contribution may use besides the parameters; all scalars, SI units.

    Readings see only time and state: for them voltages, bristle force, dwell and levels are NaN.
    """

    time: float
    motion: Motion
    gas: ChamberGas
    ports: Ports
    seal: Seal


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


@compiled
def behind_spools(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals with the voltages that stages of ``SPOOL`` leave that add so much [V]."""
    s, old = signals, signals.ports
    ports = Ports(old.voltage_1 + first, old.voltage_2 + second, old.supply_1, old.supply_2)
    return Signals(s.time, s.motion, s.gas, ports, s.seal)


@compiled
def behind_supply(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals with the supply pressures to which ``SUPPLY`` adds so much [Pa]."""
    s, old = signals, signals.ports
    ports = Ports(old.voltage_1, old.voltage_2, old.supply_1 + first, old.supply_2 + second)
    return Signals(s.time, s.motion, s.gas, ports, s.seal)


@compiled
def behind_bristles(signals: Signals, force: float) -> Signals:
    """Return the signals with the F(z) to which ``BRISTLE`` adds so much [N]."""
    s, (z, bristles, sticking, dwell, coulomb, static) = signals, signals.seal
    seal = Seal(z, bristles + force, sticking, dwell, coulomb, static)
    return Signals(s.time, s.motion, s.gas, s.ports, seal)


@compiled
def behind_levels(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals with the forces that stages of ``LEVEL`` leave that add so much [N]."""
    s, (z, bristles, sticking, dwell, coulomb, static) = signals, signals.seal
    seal = Seal(z, bristles, sticking, dwell, coulomb + first, static + second)
    return Signals(s.time, s.motion, s.gas, s.ports, seal)


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
        of the numbers in ``null``, of which those with a default may be left out
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
