"""
Which explanation of a part's gap the recordings ask for, judged on those that were not fitted.

The part's own parameters are fitted first, within their ranges. An effect is named only when it
leaves markedly less of the gap on the recordings left out than the parameters do by themselves and
than every other effect does, each with the parameters fitted along with it. A measured part seldom
comes down to the noise of its sensors; what is left is told.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pneu_rig_ros.executor import Executor, Here, map_tasks
from pneu_rig_ros.gap.candidates import Candidate
from pneu_rig_ros.gap.fitting import Explanation, Fit
from pneu_rig_ros.gap.parts.candidates import from_start
from pneu_rig_ros.gap.parts.evidence import PartEvidence
from pneu_rig_ros.gap.parts.part import Part
from pneu_rig_ros.gap.parts.screening import PartScreened, screen

CONSISTENT = 1.3
"""Gap in noises below which nothing significant is left [-]."""
LEAST_CUT = 0.1
"""Share of the gap left that one more effect must take away to be named [-]."""
PARAMETER_CUT = 0.5
"""Share of the gap that parameters must close to be an answer by themselves [-]."""
FITTED = 3
"""Effects that are fitted at each size."""
MOST_EFFECTS = 3
"""Effects that are named at most."""
FIRST_ROUNDS, ROUNDS = 4, 12
"""Rounds of a fit from each start, and from the best of them."""
DISPENSABLE = 1.03
"""A parameter is left as given where that leaves no more than this share of the gap [-]."""


@dataclass(frozen=True)
class PartScore:
    """
    A fitted explanation.

    :param fit: the fit
    :param fitted, held: gap in noises on the recordings fitted and left out [-]
    """

    fit: Fit
    fitted: float
    held: float

    @property
    def explanation(self) -> Explanation:
        """The explanation with its values."""
        return self.fit.explanation

    @property
    def worst(self) -> float:
        """The larger gap."""
        return max(self.fitted, self.held)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects in it."""
        return tuple(part.name for part in self.explanation.parts if part.is_effect)


def fit_from(
    start: Explanation, fitted: PartEvidence, held: PartEvidence, rounds: int
) -> PartScore:
    """Return an explanation fitted from a start, with its gap where it was not fitted."""
    given = fitted.part.hypothesis
    fit = fitted.fit(given, start, rounds)
    return PartScore(fit, fit.cost**0.5, held.level(fit.explanation.apply(given)))


def fit_effect(
    one: PartScreened, base: Explanation, fitted: PartEvidence, held: PartEvidence
) -> PartScore:
    """Return an explanation with one more effect, the best from several starts."""
    hypothesis = base.apply(fitted.part.hypothesis)
    alone = [
        fitted.fit(
            hypothesis,
            Explanation((from_start(one.candidate, start),), (start,)),
            FIRST_ROUNDS,
        )
        for start in one.starts
    ]
    best = min(alone, key=lambda fit: fit.cost).explanation
    return fit_from(base.plus(best.parts[0], best.values[0]), fitted, held, ROUNDS)


@dataclass
class PartSearch:
    """
    A search for the explanation of a part's gap.

    :param fitted, held: recordings to fit and to judge by
    :param parameters: of the part that may be wrong
    :param effects: that may be missing
    :param tell: told what is done now
    :param executor: where candidates are screened and fitted
    """

    fitted: PartEvidence
    held: PartEvidence
    parameters: Sequence[Candidate]
    effects: Sequence[Candidate]
    tell: Callable[[str], None] = lambda text: None
    executor: Executor = field(default_factory=Here)
    scored: list[PartScore] = field(default_factory=list)
    screened: list[PartScreened] = field(default_factory=list)

    @property
    def part(self) -> Part:
        """The given part."""
        return self.fitted.part

    @cached_property
    def given(self) -> PartScore:
        """The given part as it is."""
        hypothesis = self.part.hypothesis
        level, held = self.fitted.level(hypothesis), self.held.level(hypothesis)
        return PartScore(Fit(Explanation(), level**2, np.zeros(0)), level, held)

    def run(self) -> PartScore:
        """Return the explanation, which is the given part itself where nothing is gained."""
        if self.given.worst < CONSISTENT:
            return self.given
        base = self.fit_parameters()
        if base.worst < CONSISTENT:
            return self.pruned(base)
        best = base
        while len(best.effects) < MOST_EFFECTS and best.worst >= CONSISTENT:
            grown = self.grow(best)
            if grown is None or grown.held > (1.0 - LEAST_CUT) * best.held:
                break
            best = grown
        if not best.effects and best.held > (1.0 - PARAMETER_CUT) * self.given.held:
            return self.given
        return self.pruned(best)

    def fit_parameters(self) -> PartScore:
        """Return all parameters fitted together, having tried each alone."""
        self.tell('fitting parameters')
        alone = [Explanation((one,), one.starts[:1]) for one in self.parameters]
        singles = map_tasks(self.executor, fit_from, alone, self.fitted, self.held, ROUNDS)
        self.scored += singles
        closing = [one for one in singles if one.worst < CONSISTENT]
        if closing:
            return min(closing, key=lambda one: one.worst)
        if len(singles) < 2:
            return min(singles, key=lambda one: one.worst, default=self.given)
        self.tell('fitting all parameters')
        together = Explanation(
            tuple(self.parameters), tuple(one.starts[0] for one in self.parameters)
        )
        score = self.score(together, ROUNDS)
        self.scored.append(score)
        return score

    def grow(self, base: PartScore) -> PartScore | None:
        """Return the best explanation with one more effect, None where there is no effect."""
        rest = [one for one in self.effects if one.name not in base.effects]
        ranked = screen(self.fitted, base.explanation, rest, self.tell, self.executor)
        if not self.screened:
            self.screened = ranked
        best = ranked[:FITTED]
        names = ', '.join(one.candidate.name for one in best)
        self.tell('fitting ' + ' + '.join([*base.effects, names]))
        scored = map_tasks(
            self.executor, fit_effect, best, base.explanation, self.fitted, self.held
        )
        self.scored += scored
        return min(scored, key=lambda one: one.held, default=None)

    def score(self, start: Explanation, rounds: int) -> PartScore:
        """Return an explanation fitted from a start, with its gap where it was not fitted."""
        return fit_from(start, self.fitted, self.held, rounds)

    def pruned(self, best: PartScore) -> PartScore:
        """Return the explanation with parameters as given wherever that does no harm."""
        index = 0
        while index < len(best.explanation.parts) and len(best.explanation.parts) > 1:
            if best.explanation.parts[index].is_effect:
                index += 1
                continue
            self.tell(f'without {best.explanation.parts[index].name}')
            fewer = self.score(best.explanation.without(index), ROUNDS)
            if _as_good(fewer, best):
                best = fewer
            else:
                index += 1
        return best


def _as_good(fewer: PartScore, best: PartScore) -> bool:
    """Whether an explanation leaves hardly more than a fuller one, at its worst and left out."""
    floor = CONSISTENT if best.worst < CONSISTENT else 0.0
    pairs = (fewer.worst, best.worst), (fewer.held, best.held)
    return all(left <= max(DISPENSABLE * before, floor) for left, before in pairs)
