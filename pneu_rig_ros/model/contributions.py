"""Sum of the contributions of the chosen effects, balance by balance."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
        effect = effects[index]
        own = _own(effect, index, ends[index], ends[index + 1])
        if shaped:
            own = _shaped(own, index, len(effects) + 1)
        own = _acting(own, index, len(effects))
        behind = CHAINS.get(effect.balance, _as_without_them)
        sums[effect.balance] = _sum(sums[effect.balance], own, behind)
    return Contributions(**{balance.name.lower(): sums[balance] for balance in Balance})


@compiled
def _nothing(
    signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
) -> tuple[float, float]:
    return 0.0, 0.0


def _own(effect: Effect, index: int, start: int, end: int) -> Contribution:
    contribution = effect.contribution

    @inner
    def own(
        signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
    ) -> tuple[float, float]:
        return contribution(signals, model, effects[index], state[start:end], rate[start:end])

    return own


def _acting(always: Contribution, index: int, acting: int) -> Contribution:
    """Return the contributions of an effect, none while it does not act: that costs least."""

    @inner
    def own(
        signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
    ) -> tuple[float, float]:
        if effects[acting][index]:
            return always(signals, model, effects, state, rate)
        return 0.0, 0.0

    return own


def _shaped(unshaped: Contribution, index: int, shapes: int) -> Contribution:
    """Return the contributions of an effect times its shape, if it has one."""

    @inner
    def own(
        signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
    ) -> tuple[float, float]:
        a, b = unshaped(signals, model, effects, state, rate)
        row = effects[shapes][index]
        if row[COUNT] == 0.0:
            return a, b
        first, second = factors(row, signals, model)
        return first * a, second * b

    return own


@compiled
def _as_without_them(signals: Signals, first: float, second: float) -> Signals:
    """Return the signals that an effect sees where those before it add so much: the same."""
    return signals


def _sum(others: Contribution, own: Contribution, behind: Callable[..., Signals]) -> Contribution:
    """Return both contributions together; ``own`` sees what is behind the others."""

    @inner
    def total(
        signals: Signals, model: CompiledModel, effects: Any, state: Floats, rate: Floats
    ) -> tuple[float, float]:
        a, b = others(signals, model, effects, state, rate)
        seen = behind(signals, a, b)
        c, d = own(seen, model, effects, state, rate)
        return a + c, b + d

    return total
