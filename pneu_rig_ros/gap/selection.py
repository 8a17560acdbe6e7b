"""
Which explanation the data ask for: as few parts as close the gap, judged on runs not fitted.

Explanations grow part by part. At each size the most promising candidates are fitted by
simulation and compared on the experiments left out; the first size at which one of them leaves
nothing significant is the answer. A wrong parameter is preferred to a missing effect that leaves
about as much.

Several wrong parameters are looked for at once, before anything of two parts: the first of them
need not look promising, since the slips come at the wrong time as long as the others are wrong.
What is left unexplained then is looked for globally: a fit may have ended in a false minimum, and
two effects may be of no use alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from pneu_rig_ros.executor import Executor, Here, map_tasks
from pneu_rig_ros.gap.candidates import Candidate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import (
    FINE_STEP,
    Explanation,
    first_of_each,
    fit,
    scanned,
    without_weakest,
)
from pneu_rig_ros.gap.global_fit import fit_globally
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Scored, Setting, cost_again, fit_from, preferred, score
from pneu_rig_ros.gap.screening import Screened, screen, screen_pairs
from pneu_rig_ros.gap.twin import expected_cost

CONSISTENT, ALLOWANCE = 1.6, 0.1
"""
Cost in multiples of what it would be under a true hypothesis, and beyond that, up to which nothing
significant is left [-]: the noise of a twin is not that of the rig in all.
"""
SCANNED = 8
"""Candidates of either kind whose strengths are tried before the fits."""
EFFECTS_FITTED, PARAMETERS_FITTED = 4, 5
"""Candidates of either kind that are fitted at each size."""
BEAM = 2
"""Explanations of one size that grow further."""
LARGEST = 3
"""Parts of an explanation at most."""
REFINED, REFINING_ROUNDS = 2, 12
"""Best fits of each size that are fitted on, and the rounds of those that leave a gap."""
CLOSED = 0.1
"""Share of the gap above the floor that an explanation may leave [-]."""
GLOBALLY = 3
"""Explanations that are fitted over their whole range at once, if nothing else helps."""
FEW = 6
"""Of more parameters than these a quarter at a time is taken out, then one."""
LEAST_GAIN = 0.85
"""One more part that leaves more than this share of the cost leads nowhere [-]."""
GOING_ON = 4
"""How often at most fits over the whole range are gone on with."""
ROUNDS = 8
"""Rounds of a fit."""
ALIKE = 0.05
"""Explanations whose costs differ by less cannot be told apart [-]."""


@dataclass
class Search:
    """
    The search for an explanation of one kind of prediction.

    :param given: the hypothesis to be explained
    :param fitted: experiments for the fits
    :param held: experiments for the comparison
    :param modes: predictions that are to be explained
    :param tell: told what is done now
    :param base: what is fitted together with every explanation
    :param executor: where candidates are screened and fitted
    """

    given: Hypothesis
    fitted: Evidence
    held: Evidence
    modes: tuple[Mode, ...]
    tell: Callable[[str], None]
    base: Explanation = field(default_factory=Explanation)
    executor: Executor = field(default_factory=Here)
    screened: list[Screened] = field(default_factory=list)
    scored: list[Scored] = field(default_factory=list)
    best: Scored | None = None
    level: float = 0.0
    """Cost of a true hypothesis, about [-]; see :meth:`settle`."""
    begin: float = 0.0
    """Cost of what is given [-]."""

    @property
    def limit(self) -> float:
        """The cost below which nothing significant is left [-]."""
        return CONSISTENT * self.level + ALLOWANCE

    @property
    def closed(self) -> float:
        """The cost below which an explanation closes the gap [-]."""
        return max(self.limit, self.level + CLOSED * (self.begin - self.level))

    @property
    def ranking(self) -> list[Scored]:
        """The best fit of everything fitted, best first."""
        ordered = sorted(self.scored, key=lambda one: one.worst)
        return first_of_each(ordered, lambda one: one.fit.explanation)

    def cost(self, hypothesis: Hypothesis) -> float:
        """Return the larger cost, of the experiments fitted and left out [-]."""
        costs = [evidence.cost(hypothesis, self.modes) for evidence in (self.fitted, self.held)]
        return max(costs)

    def settle(self, hypothesis: Hypothesis) -> None:
        """Propagate the errors of the readings under a hypothesis, and what they come to."""
        both = self.fitted, self.held
        for evidence in both:
            evidence.settle_floors(hypothesis, self.modes)
        self.level = max(expected_cost(hypothesis, evidence, self.modes) for evidence in both)

    def run(self, pool: Sequence[Candidate]) -> Scored | None:
        """Return the smallest explanation that closes the gap; None if there is none."""
        self.begin = self.cost(self.given)
        if self.base.parts:
            first = self.calibrated()
            if first.worst < self.limit:
                self.best = first
                return first
            self.base = first.fit.explanation
        reached = self.cost(self.base.apply(self.given))
        level = [self.base]
        for size in range(1, LARGEST + 1):
            scored = [one for base in level for one in self.grow(base, pool, size)]
            if not scored:
                break
            scored = self.again(sorted(scored, key=lambda one: one.worst))
            self.scored += scored
            if closing := [one for one in scored if one.worst < self.closed]:
                self.best = self.pruned(preferred(closing), self.closed)
                return self.best
            if size == 1 and self.jointly(pool):
                return self.best
            if scored[0].worst > LEAST_GAIN * reached:
                break
            reached = scored[0].worst
            level = [one.fit.explanation for one in scored[: BEAM if size == 1 else 1]]
        return self.globally([one for one in pool if one.is_effect], size)

    def globally(self, effects: Sequence[Candidate], size: int) -> Scored | None:
        """
        Return the best of the most promising explanations fitted over their whole range.

        They are those that the fits left the least of, of one part and of any number, and, where
        one part alone led nowhere, the pairs of effects that look best together. None if all
        leave something significant.
        """
        tried = sorted(self.scored, key=lambda one: one.fit.cost)
        best = [one.fit.explanation for one in tried if one.effects]
        alone = [one for one in best if len(one.parts) == len(self.base.parts) + 1]
        ranked = first_of_each([*alone[:1], *best], lambda one: one)
        if (found := self.over_the_range(ranked)) or size > 1:
            return found
        self.tell('screening pairs')
        everything = self.given, self.base, effects, self.fitted, self.modes, self.executor
        return self.over_the_range(screen_pairs(*everything))

    def over_the_range(self, ranked: Sequence[Explanation]) -> Scored | None:
        """Return the best of the first explanations fitted so; None if it leaves something."""
        if not (starts := ranked[:GLOBALLY]):
            return None
        self.tell('fitting over the whole range ' + ', '.join(one.name for one in starts))
        own = len(self.base.parts)
        scored = self.fitted_on(fit_globally(starts, self.setting, own, self.executor))
        self.scored += scored
        if closing := [one for one in scored if one.worst < self.limit]:
            self.best = self.pruned(preferred(closing), self.limit)
        return self.best

    def fitted_on(self, scored: Sequence[Scored]) -> list[Scored]:
        """Return the fits gone on with for as long as the best of them gains."""
        left = math.inf
        for _ in range(GOING_ON):
            self.settle(min(scored, key=lambda one: one.worst).fit.explanation.apply(self.given))
            scored = self.fits([one.fit.explanation for one in scored], REFINING_ROUNDS)
            before, left = left, min(one.worst for one in scored)
            if left < self.limit or left > LEAST_GAIN * before:
                break
        return list(scored)

    def calibrated(self) -> Scored:
        """Return what is fitted together with every explanation, fitted alone."""
        self.tell('fitting ' + self.base.name)
        result = fit(self.given, self.base, self.fitted, self.modes, ROUNDS)
        self.settle(result.explanation.apply(self.given))
        result = fit(self.given, result.explanation, self.fitted, self.modes, ROUNDS)
        return score(result, self.setting)

    def jointly(self, pool: Sequence[Candidate]) -> Scored | None:
        """Return the fewest parameters that close the gap together; None if there are none."""
        everything, own = self.base, len(self.base.parts)
        for one in pool:
            if not one.is_effect:
                everything = everything.plus(one, (one.was,))
        if everything is self.base:
            return None
        self.tell('fitting all parameters together')
        rough = fit(self.given, everything, self.fitted, self.modes, REFINING_ROUNDS)
        self.settle(rough.explanation.apply(self.given))
        left = rough.explanation
        while (size := len(left.parts) - own) > 0:
            self.tell(f'fitting {size} parameters together')
            scored = fit_from(left, self.setting, ROUNDS, FINE_STEP)
            if size <= LARGEST and scored.worst < self.closed:
                self.best = scored
                self.scored.append(scored)
            elif self.best is not None:
                break
            left = without_weakest(scored.fit, own, size // 4 if size > FEW else 1)
        return self.best

    @property
    def setting(self) -> Setting:
        """What the fits share."""
        return Setting(self.given, self.fitted, self.held, self.modes)

    def fits(self, starts: Sequence[Explanation], rounds: int) -> list[Scored]:
        """Return the explanations fitted from several starts."""
        names = dict.fromkeys(start.name for start in starts)

        def told(done: int) -> None:
            self.tell(f'fitting {", ".join(names)}: {done} of {len(starts)}')

        told(0)
        return map_tasks(self.executor, fit_from, starts, self.setting, rounds, progress=told)

    def pruned(self, scored: Scored, closed: float) -> Scored:
        """Return the explanation without the parts that it closes the gap without."""
        parts = scored.fit.explanation.parts
        for index in range(len(self.base.parts), len(parts)):
            if len(parts) == len(self.base.parts) + 1:
                break
            fewer = scored.fit.explanation.without(index)
            self.tell('fitting ' + fewer.name)
            other = fit_from(self.scan([[fewer]])[0], self.setting, ROUNDS)
            if other.worst < max(closed, scored.worst + ALIKE):
                self.scored.append(other)
                return self.pruned(other, closed)
        return scored

    def grow(self, base: Explanation, pool: Sequence[Candidate], size: int) -> list[Scored]:
        """Return the fits of an explanation with one more part."""
        names = {part.name for part in base.parts}
        rest = [candidate for candidate in pool if candidate.name not in names]
        self.tell(f'screening {len(rest)} candidates')
        ranked = screen(base.apply(self.given), rest, self.fitted, self.modes, self.executor)
        if size == 1:
            self.screened = ranked
        effects = [one for one in ranked if one.candidate.is_effect]
        others = [one for one in ranked if not one.candidate.is_effect]
        starts = self.promising(base, effects)[:EFFECTS_FITTED]
        return self.fits(starts + self.promising(base, others)[:PARAMETERS_FITTED], ROUNDS)

    def promising(self, base: Explanation, ranked: Sequence[Screened]) -> list[Explanation]:
        """
        Return an explanation with each of the first of some candidates, the best one first.

        A screened change is scaled as if all were linear; where slip follows slip it is not.
        """
        groups = [
            [base.plus(one.candidate, start) for start in one.worth_trying]
            for one in ranked[:SCANNED]
        ]
        return self.scan(groups)

    def scan(self, groups: Sequence[Sequence[Explanation]]) -> list[Explanation]:
        """Return the best strength of the best start of each group, the best one first."""
        tried = map_tasks(self.executor, scanned, groups, self.given, self.fitted, self.modes)
        return [start for _, start in sorted(tried, key=lambda one: one[0])]

    def again(self, scored: Sequence[Scored]) -> list[Scored]:
        """
        Return fits with the noise floors of the best one, best first.

        The best ones are fitted on, longer where they do not close the gap yet.
        """
        best = scored[0]
        self.settle(best.fit.explanation.apply(self.given))
        chosen = [one.fit.explanation for one in scored[:REFINED]]
        refined = self.fits(chosen, ROUNDS) if best.worst < self.limit else self.refine(chosen)
        others = map_tasks(self.executor, cost_again, scored[REFINED:], self.setting)
        return sorted(refined + others, key=lambda one: one.worst)

    def refine(self, explanations: Sequence[Explanation]) -> list[Scored]:
        """Return the best fits from there and from the other starts of the last part."""
        starts = [start for one in explanations for start in self.restarts(one)]
        fits = sorted(self.fits(starts, ROUNDS), key=lambda one: one.fit.cost)
        best = first_of_each([one.fit.explanation for one in fits], lambda one: one)
        return self.fits(best, REFINING_ROUNDS)

    def restarts(self, explanation: Explanation) -> list[Explanation]:
        """Return an explanation, and it with its last part from each of that part's starts."""
        last = explanation.parts[-1]
        base = explanation.without(len(explanation.parts) - 1)
        return [explanation, *self.scan([[base.plus(last, start)] for start in last.starts])]
