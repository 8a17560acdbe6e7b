"""Sum of the contributions of the chosen effects, balance by balance."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Signals, behind_levels, behind_spools
from pneu_rig_ros.model.shape import COUNT, factors

CHAINS = {Balance.SPOOL: behind_spools, Balance.LEVEL: behind_levels}
"""Balance -> what the later stages see of the earlier ones."""
Contribution = Callable[[Signals, CompiledModel, Any, Floats, Floats], tuple[float, float]]


@dataclass(frozen=True)
class Contributions:
    """One compiled function a balance; units as in :class:`Balance`."""

    spool: Contribution
    supply: Contribution
    mass: Contribution
    heat: Contribution
    bristle: Contribution
    level: Contribution
    film: Contribution
    force: Contribution
    motion_reading: Contribution
    pressure_reading: Contribution


def collect(effects: Sequence[Effect], first_state: int, shaped: bool = False) -> Contributions:
    """
    Return the sums over the effects.

    :param effects: in the order of their parameters in the plant's tuple, after which that tuple
        has which of them act, shape (len(effects),)
    :param first_state: index of the first effect state in the state array
    :param shaped: whether the plant's tuple ends with the shapes of the effects
    """
    sums: dict[Balance, Contribution] = dict.fromkeys(Balance, _nothing)
    ends = list(accumulate((len(effect.states) for effect in effects), initial=first_state))
    for index in sorted(range(len(effects)), key=lambda i: effects[i].stage):
        place = _Place(index, ends[index], ends[index + 1], len(effects), shaped)
        balance = effects[index].balance
        sums[balance] = _sum(sums[balance], effects[index], place)
    return Contributions(**{balance.name.lower(): sums[balance] for balance in Balance})


@compiled
def _nothing(
    signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
) -> tuple[float, float]:
    return 0.0, 0.0


@compiled
def _as_without_them(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals that an effect sees where those before it add so much: the same."""
    return signals


class _Place(NamedTuple):
    """
    Where the plant's arrays and its tuple hold what belongs to an effect.

    :param own: index of its parameters
    :param start, end: of its states
    :param acting: index of which effects act; the shapes, if there are any, come after it
    :param shaped: whether there are shapes
    """

    own: int
    start: int
    end: int
    acting: int
    shaped: bool


def _sum(others: Contribution, effect: Effect, place: _Place) -> Contribution:
    """
    Return both contributions of an effect and of the others; it sees what is behind them.

    While the effect does not act, it costs next to nothing. It is one function of all that
    belongs to an effect, as each function of its own takes time to compile.
    """
    contribution, behind = effect.contribution, CHAINS.get(effect.balance, _as_without_them)
    index, start, end, acting, shaped = place
    shapes = acting + 1  # Numba takes no other index of a tuple than a constant

    @inner
    def total(
        signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
    ) -> tuple[float, float]:
        a, b = others(signals, model, effects, state, rate)
        if effects[acting][index]:
            seen, own = behind(signals, a, b), effects[index]
            c, d = contribution(seen, model, own, state[start:end], rate[start:end])
            if shaped:
                row = effects[shapes][index]
                if row[COUNT] != 0.0:
                    first, second = factors(row, seen, model)
                    c, d = first * c, second * d
            a, b = a + c, b + d
        return a, b

    return total
