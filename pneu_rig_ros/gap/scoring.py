"""Fits with their cost on runs that they were not fitted to, and which of them is preferred."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import STEP, Explanation, Fit, fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode

AS_LITTLE = 1.15
"""What leaves up to so many times what the best leaves counts as leaving as little [-]."""


@dataclass(frozen=True)
class Scored:
    """
    A fitted explanation and its cost where it was not fitted.

    :param fit: the fit
    :param held_out: cost on the experiments left out [-]
    """

    fit: Fit
    held_out: float

    @property
    def worst(self) -> float:
        """The larger of both costs."""
        return max(self.fit.cost, self.held_out)

    @property
    def effects(self) -> int:
        """Number of effects in the explanation."""
        return sum(part.is_effect for part in self.fit.explanation.parts)


class Setting(NamedTuple):
    """What the fits of a search share; see :class:`Search`."""

    given: Hypothesis
    fitted: Evidence
    held: Evidence
    modes: tuple[Mode, ...]


def fit_from(start: Explanation, setting: Setting, rounds: int, step: float = STEP) -> Scored:
    """
    Return an explanation fitted from a start.

    :param rounds: of the least-squares solver at most
    :param step: of the finite differences [-]
    """
    return score(fit(setting.given, start, setting.fitted, setting.modes, rounds, step), setting)


def score(result: Fit, setting: Setting) -> Scored:
    """Return a fit with its cost on the experiments left out."""
    hypothesis = result.explanation.apply(setting.given)
    return Scored(result, setting.held.cost(hypothesis, setting.modes))


def cost_again(one: Scored, setting: Setting) -> Scored:
    """Return a fit with its costs under other noise floors."""
    hypothesis = one.fit.explanation.apply(setting.given)
    cost = setting.fitted.cost(hypothesis, setting.modes)
    return score(Fit(one.fit.explanation, cost, one.fit.deviations), setting)


def preferred(closing: Sequence[Scored]) -> Scored:
    """Return the one with the fewest effects among those that leave about as little as any."""
    least = min(one.worst for one in closing)
    good = [one for one in closing if one.worst <= AS_LITTLE * least]
    return min(good, key=lambda one: (one.effects, one.worst))


def cost_of(one: Scored) -> float:
    """Return the cost of a fit where it was fitted [-]."""
    return one.fit.cost
