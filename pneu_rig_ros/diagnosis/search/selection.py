"""
Selection of an explanation: forward selection of causes until no significant residual is left.

:meth:`Search.run` has the steps in their order:

1. Residuals or simulated cycles are off: explanations grow by one cause at a time, up to three,
   and earlier causes are reconsidered with each (:meth:`Search.grow`; ``growth`` screens and fits
   one cause, ``state`` tests what is left).
2. Neither is: all windows together may show a cause that no cell does.
3. A cause was found: if it leaves no residual, but its free runs are off, they may prefer other
   values or another one, or show a further one (``free_runs``).
4. None was found: free runs may be off all the same; then they join the data, see 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Explanation
from pneu_rig_ros.diagnosis.causes.shaped_effects import ShapedEffect
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.search.fitting import FINAL_ROUNDS, fit
from pneu_rig_ros.diagnosis.search.free_runs import (
    agreeing_with_free_runs,
    free_runs_are_off,
    preferred_by_free_runs,
)
from pneu_rig_ros.diagnosis.search.growth import MOST_FITTED, Growth
from pneu_rig_ros.diagnosis.search.scoring import (
    DECISIVE,
    MOST_LEFT,
    NEGLIGIBLE,
    Grown,
    ScoredFit,
    closes_the_gap,
    explains_alone,
    preferred,
    residual_excess,
    score,
    stands_out,
)

MOST_CAUSES = 3
"""Causes of an explanation at most."""
BEAM = 2
"""Explanations of one size that grow further."""
RENEWALS = 3
"""Fits at most, each under the noise of the one before."""


@dataclass(kw_only=True)
class Search(Growth):
    """
    The search for an explanation.

    :ivar residuals_significant: whether residuals of the given hypothesis are
    :ivar indistinct: explanations hardly worse than the accepted one by residuals alone
    """

    residuals_significant: bool = False
    indistinct: Sequence[Explanation] = ()

    def run(self) -> ScoredFit | None:
        """Return the smallest explanation that leaves no significant residual, or the best."""
        self.residuals_significant = bool(self.significant())
        if self.residuals_significant or self.cycles_differ():
            if self.base.parts:  # what is fitted with any cause
                self.best = self.calibrated = self.fit_thoroughly(self.base)
                self.base = self.best.explanation
            self.grow([self.base], 1)
        else:
            self._take_a_faint_cause()
        if self.best is not None and self.has_cause:
            if free_runs_are_off(self):
                self._explain_free_runs(self.best)
        elif self._free_runs_differ():
            self.grow([self.base], 1)
        return self.best

    def grow(self, beam: Sequence[Explanation], first: int) -> None:
        """
        Find causes one by one until nothing is left, none improves, or there are enough.

        :param beam: explanations that grow
        :param first: number of causes of the explanations that are fitted first
        """
        for size in range(first, MOST_CAUSES + 1):
            if not self._needs_a_cause():
                return
            if self.exchanged_by_cycles():
                beam = [self.so_far.explanation]
                if not self._needs_a_cause():
                    return
            self.only_weak = self.only_weak_remains()
            grown = self._grown_with_cycles(beam, size)
            if not (grown.is_better and self.beyond_chance(grown)):
                return
            chosen, accepted = grown.chosen, self._accept(grown, size)
            if accepted is None:
                return
            self.ranking += [chosen, *grown.fits]
            both = len(accepted.explanation.parts) > len(chosen.explanation.parts)
            accepted = self.reconsidered(accepted)
            if both:
                return  # with a second cause at once, which the first needed
            if not (chosen.simulated or self.only_weak):
                near = [each for each in grown.fits if each.difference(chosen)[0] <= DECISIVE]
                self.indistinct = [each.explanation for each in near]
            beam = self._beam(accepted, grown.fits)

    def _take_a_faint_cause(self) -> None:
        """Accept a first cause that no cell shows if all windows together do."""
        grown = self.grown_by_all_windows()
        if grown.is_better and self.beyond_chance(grown) and self._accept(grown, 1):
            self.ranking += grown.fits
        else:
            self.screened = []  # none of them is a candidate where nothing is missing

    def _free_runs_differ(self) -> bool:
        """
        Return whether free runs of the given model are off where nothing else was found.

        Then they join the initial data. Cycles that are off, and by no force, do not prevent it.
        """
        if not self.is_exactly_known or self.residuals_are_reproduced():
            return False
        self.progress('comparing free runs')
        test = self.free_run_test(self.given)
        if test.significant:
            self.data, self.first_cycle_test, self.screened = self.initial, test, []
            self.add_cycles(free=True)
        return test.significant

    def _explain_free_runs(self, best: ScoredFit) -> None:
        """Take other values, another explanation or a further cause, as free runs show it."""
        agreeing = agreeing_with_free_runs(self)
        if agreeing is None:
            self._grow_by_free_runs(self._exchanged_by_free_runs(best))
        elif self.training.cycles is not None:  # else the residuals determine the values
            self.best = score(agreeing, self.data)

    def _exchanged_by_free_runs(self, best: ScoredFit) -> ScoredFit:
        """Return what free runs prefer: another explanation or form, fitted, or the best one."""
        chosen = preferred_by_free_runs(self, best)
        same = chosen.explanation.forms == best.explanation.forms
        return best if same else self._renewed(chosen)

    def _grow_by_free_runs(self, found: ScoredFit) -> None:
        """Find what free runs show beside causes that leave no residual; else keep these."""
        before, size = self.data, len(found.explanation.parts)
        self.add_cycles(free=True)
        self.grow([self.so_far.explanation], size + 1)
        if len(self.so_far.explanation.parts) == size:
            self.best, self.data = found, before

    def _needs_a_cause(self) -> bool:
        """Return whether significant residuals or cycles are left; adds cycles where needed."""
        self.progress('testing the residuals that are left')
        if self.strong_residuals() if self.has_cause else self.significant():
            return True
        if self.training.runs_freely and self.best is None:  # or they had not joined the data
            return True
        if self.training.cycles is None:
            if not self.cycles_differ():
                return False
            self.add_cycles()
            return self.best is None or self._needs_a_cause()
        return self.cycles_remain()

    def exchanged_by_cycles(self) -> bool:
        """
        Return whether another explanation took the place of the best one, as cycles prefer it.

        Where residuals do not distinguish them, what cycles show beside the chosen one may be that
        it is the wrong one, and no further cause.
        """
        own = self.so_far.explanation
        others = [each for each in self.indistinct if each.name != own.name]
        self.indistinct = ()
        if self.best is None or self.training.cycles is None or not others:
            return False
        fits = self.fits([own, *others])
        chosen = preferred(fits)
        if chosen.explanation.name == own.name:
            return False
        self._renewed(chosen)
        self.ranking = [*fits, *self.ranking]  # of each name the first counts
        return True

    def _grown_with_cycles(self, beam: Sequence[Explanation], size: int) -> Grown:
        """
        Return explanations with one more cause.

        Where none improves, other forms of the best effect are tried, then simulated cycles join
        the data, and then the next candidates.
        """
        grown = self.grown(beam, size)
        if not grown.is_better:
            grown = self.with_other_forms(grown)
        may_simulate = not grown.is_better and self.can_simulate()
        # for a further cause only where cycles show something of which residuals have no trace
        if may_simulate and (size == 1 or self.cycles_differ()):
            self.add_cycles()
            grown = self.grown(beam, size)
        if size == 1 and len(self.screened) > MOST_FITTED and not grown.is_better:
            grown = self.grown(beam, size, MOST_FITTED)
        return grown

    def _accept(self, grown: Grown, size: int) -> ScoredFit | None:
        """
        Accept the chosen explanation and return it; None if its last cause explains too little.

        Another form of a cause is not a further one: the likelihood decides on it. Where all that
        is left is weak, one cause has to explain it alone. Of two that are left, the first may
        close little: then both together have to close the gap.
        It is fitted again with the noise that the data have if it is true: under it the piston
        moves otherwise than the given model predicts. The noise under values that are far off
        would hide the right ones: they are looked for before.
        """
        smaller, best, data = self.hypothesis, self.best, self.data
        accepted = self._renewed(grown.chosen)
        another_form = size == 2 and isinstance(accepted.explanation.parts[-1], ShapedEffect)
        enough = (size == 1 or another_form) and not self.training.runs_freely
        enough = enough or closes_the_gap(self.held_out, smaller, accepted)
        if enough and (not self.only_weak or self._is_strong(grown, accepted, data.training)):
            return accepted
        further = None
        if size < MOST_CAUSES and not (enough or self.only_weak):
            further = self._with_one_more(self._beam(accepted, grown.fits), smaller, size + 1)
        if further is None:
            self.best, self.data = best, data
        return further

    def reconsidered(self, accepted: ScoredFit) -> ScoredFit:
        """
        Return an explanation with earlier causes dropped or exchanged where that is preferred.

        Each was chosen while the later ones were missing: stepwise regression (M. A. Efroymson, in
        Mathematical Methods for Digital Computers, Wiley, 1960). Simulated cycles take too long.
        """
        shaped = any(isinstance(part, ShapedEffect) for part in accepted.explanation.parts)
        if shaped or self.only_weak or self.training.cycles is not None:
            return accepted
        for part in accepted.explanation.parts[:-1]:
            if part in self.base.parts:
                continue
            fits = self.without_or_in_place_of(part, accepted.explanation)
            chosen = preferred(fits)
            if {*chosen.explanation.causes} != {*accepted.explanation.causes}:
                accepted = self._renewed(chosen)
                self.ranking = [accepted, *fits, *self.ranking]  # of each name the first counts
        return accepted

    def _is_strong(self, grown: Grown, accepted: ScoredFit, searched: Dataset) -> bool:
        """
        Return whether a cause is stronger than the weak effects that may make all that is left.

        :param searched: the training data in which it was found, with the noise without it
        """
        if self.remaining() >= MOST_LEFT:
            return False
        smaller = grown.before.hypothesis
        return stands_out(grown) or explains_alone(accepted, smaller, searched, self.data)

    def _with_one_more(
        self, beam: Sequence[Explanation], smaller: Hypothesis, size: int
    ) -> ScoredFit | None:
        """Return an explanation with a further cause if its last two close the gap, else None."""
        grown = self.grown(beam, size)
        if not grown.is_better:
            return None
        both = self._renewed(grown.chosen)
        if not closes_the_gap(self.held_out, smaller, both, causes=2):
            return None
        self.ranking += [grown.chosen, *grown.fits]
        return both

    def _renewed(self, chosen: ScoredFit) -> ScoredFit:
        """
        Return an explanation fitted with the noise that the data have if it is true.

        Where more mass is accelerated the noise is larger: a fit that moves under it is repeated.
        """
        explanation = self.fit_thoroughly(chosen.explanation).explanation
        for _ in range(RENEWALS):
            self.data = self.data.with_noise_of(explanation.hypothesis, self.rng)
            before, again = explanation, fit(explanation, self.training, FINAL_ROUNDS)
            explanation = again.explanation
            step = np.abs(explanation.theta - before.theta)
            if np.all(step < np.sqrt(np.diag(again.covariance))):
                break
        self.best = score(again, self.data)
        return self.best

    def _beam(self, accepted: ScoredFit, fits: Sequence[ScoredFit]) -> list[Explanation]:
        """
        Return the explanations that grow further: the accepted one, and the best others.

        Beside one that leaves next to nothing no other is likely to be part of the right one. Nor
        is one that free runs do not prefer.
        """
        own = accepted.explanation
        before, after = (
            residual_excess(self.training, each) for each in (self.given, self.hypothesis)
        )
        if after < NEGLIGIBLE * before or self.training.runs_freely:
            return [own]
        others = [each.explanation for each in sorted(fits, key=lambda fit: fit.cost)]
        return [own, *(each for each in others if each.name != own.name)][:BEAM]

    @property
    def candidates(self) -> list[Candidate]:
        """What may differ from the given model, what is fitted anyway among it."""
        return [*self.base.parts, *self.pool]

    def causes(self, explanation: Explanation) -> list[str]:
        """Return the names of the causes, without the base; a shaped effect implies its effect."""
        implied = {part.name for part in self.base.parts}
        implied |= {part.effect for part in explanation.parts if isinstance(part, ShapedEffect)}
        return [name for name in explanation.causes if name not in implied] or explanation.causes

    def clear(self) -> None:
        """Return to the given model: what it lacks is not a cause."""
        self.data = self.initial
        self.best, self.ranking, self.screened = None, [], []

    def restart(self) -> None:
        """Return to the base and to the initial data."""
        simulated = self.training.cycles is not None and not self.residuals_significant
        free = self.training.runs_freely
        self.data, self.best = self.initial, self.calibrated
        if simulated:
            self.add_cycles(free)
