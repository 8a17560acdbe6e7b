"""Sum of the contributions of the chosen effects, balance by balance."""

from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import Any

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Signals, behind_levels, behind_spools
from pneu_rig_ros.model.shape import COUNT, factors

CHAINS = {Balance.SPOOL: behind_spools, Balance.LEVEL: behind_levels}
"""Balance -> what the later stages see of the earlier ones."""
Contribution = Callable[[Signals, CompiledModel, Any, Floats, Floats], tuple[float, float]]


Contributions = dict[Balance, Contribution]
"""One compiled function a balance; units as in :class:`Balance`."""


def collect(effects: Sequence[Effect], first_state: int, shaped: bool = False) -> Contributions:
    """
    Return the sums over the effects.

    :param effects: in the order of their parameters in the plant's tuple, after which that tuple
        has which of them act, shape (len(effects),)
    :param first_state: index of the first effect state in the state array
    :param shaped: whether the plant's tuple ends with the shapes of the effects
    """
    sums: Contributions = dict.fromkeys(Balance, _nothing)
    ends = list(accumulate((len(effect.states) for effect in effects), initial=first_state))
    for index in sorted(range(len(effects)), key=lambda i: effects[i].stage):
        effect, place = effects[index], (index, ends[index], ends[index + 1], len(effects))
        sums[effect.balance] = _sum(sums[effect.balance], effect, place, shaped)
    return sums


@compiled
def _nothing(
    signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
) -> tuple[float, float]:
    return 0.0, 0.0


@compiled
def _as_without_them(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals that an effect sees where those before it add so much: the same."""
    return signals


def _sum(
    others: Contribution, effect: Effect, place: tuple[int, int, int, int], shaped: bool
) -> Contribution:
    """
    Return both contributions of an effect and of the others; it sees what is behind them.

    While the effect does not act, it costs next to nothing. It is one function of all that
    belongs to an effect, as each function of its own takes time to compile.

    :param place: index of its parameters, first and end index of its states, index of which
        effects act; the shapes, if there are any, come after it
    """
    contribution, behind = effect.contribution, CHAINS.get(effect.balance, _as_without_them)
    index, start, end, acting = place
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
