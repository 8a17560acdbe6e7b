"""
Selection of an explanation: forward selection of causes until no significant residual is left.

Explanations grow by one cause at a time, up to three. Of each size the most promising are fitted
and compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.causes.families import Family
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.search.faint_causes import FaintCauses
from pneu_rig_ros.diagnosis.search.fitting import FINAL_ROUNDS, fit
from pneu_rig_ros.diagnosis.search.growth import MOST_FITTED
from pneu_rig_ros.diagnosis.search.remainder import NEGLIGIBLE
from pneu_rig_ros.diagnosis.search.scoring import (
    DECISIVE,
    ScoredFit,
    any_improves,
    preferred,
    residual_excess,
    score,
)

MOST_CAUSES = 3
"""Causes of an explanation at most."""
BEAM = 2
"""Explanations of one size that grow further."""
RENEWALS = 3
"""Fits at most, each under the noise of the one before."""


@dataclass(kw_only=True)
class Search(FaintCauses):
    """
    The search for an explanation.

    :ivar residuals_significant: whether residuals of the given hypothesis are
    :ivar indistinct: explanations hardly worse than the accepted one by residuals alone
    """

    residuals_significant: bool = False
    indistinct: Sequence[Explanation] = ()

    def run(self) -> ScoredFit | None:
        """Return the smallest explanation that leaves no significant residual, or the best."""
        self.initial = self.training, self.held_out
        self.residuals_significant = bool(self.significant())
        if self.residuals_significant or self.cycles_differ():
            self._grow()
        else:
            fits = self.pooled()
            if fits and self._accept(preferred(fits), fits, 1):
                self.ranking += fits
            else:
                self.screened = []  # none of them is a candidate where nothing is missing
        if self.best is not None and self.has_cause:
            if (chosen := self.by_free_runs(self.best)) is not None:
                self._renewed(chosen)
            if self.free_runs_are_off:
                self._grow_by_free_runs(self.best)
        elif self.free_runs_differ():
            self._grow()
        return self.best

    def _grow(self) -> None:
        """Find causes one by one until nothing is left, none improves, or there are enough."""
        if self.base.parts:
            self.best = self.calibrated = self.fit_thoroughly(self.base)
            self.base = self.best.explanation
        self._grow_further([self.base], 1)

    def _grow_by_free_runs(self, found: ScoredFit) -> None:
        """Find what free runs show beside causes that leave no residual; else keep these."""
        before = self.training, self.held_out
        self.add_cycles(free=True)
        assert self.best is not None
        size = len(found.explanation.parts)
        self._grow_further([self.best.explanation], size + 1)
        if len(self.best.explanation.parts) == size:
            self.best, (self.training, self.held_out) = found, before

    def _grow_further(self, beam: Sequence[Explanation], first: int) -> None:
        """Find one cause after the other, the next of which makes a size of explanation."""
        for size in range(first, MOST_CAUSES + 1):
            if not self._needs_a_cause():
                break
            if self.exchanged_by_cycles():
                assert self.best is not None
                beam = [self.best.explanation]
                if not self._needs_a_cause():
                    break
            self.weak = self.is_weak()
            fits, before = self._grown_with_cycles(beam, size)
            if not any_improves(fits, before):
                break
            chosen = preferred(fits)
            if not self.beyond_chance(chosen, before):
                break
            accepted = self._accept(chosen, fits, size)
            if accepted is None:
                break
            self.ranking += [chosen, *fits]
            if len(accepted.explanation.parts) > len(chosen.explanation.parts):
                break
            if not (chosen.simulated or self.weak):
                near = [fit for fit in fits if fit.difference(chosen)[0] <= DECISIVE]
                self.indistinct = [fit.explanation for fit in near]
            beam = self._beam(accepted, fits)

    def exchanged_by_cycles(self) -> bool:
        """
        Return whether another explanation took the place of the best one, as cycles prefer it.

        Where residuals do not distinguish them, what cycles show beside the chosen one may be that
        it is the wrong one, and no further cause.
        """
        others, self.indistinct = self.indistinct, ()
        if self.best is None or self.training.cycles is None:
            return False
        name = self.best.explanation.name
        others = [each for each in others if each.name != name]
        if not others:
            return False
        fits = self._fits([self.best.explanation, *others])
        chosen = preferred(fits)
        if chosen.explanation.name == name:
            return False
        self._renewed(chosen)
        self.ranking = [*fits, *self.ranking]  # of each name the first counts
        return True

    def _grown_with_cycles(
        self, beam: Sequence[Explanation], size: int
    ) -> tuple[list[ScoredFit], ScoredFit]:
        """
        Return the fits of explanations with one more cause, and the best one without it.

        Where none improves on that, simulated cycles join the data, and then the next candidates.
        """
        fits, before = self.grown(beam, size)
        if not any_improves(fits, before):
            fits, before = self.with_other_forms(fits, before)
        may_simulate = not any_improves(fits, before) and self.can_simulate()
        # for a further cause only where cycles show something of which residuals have no trace
        if may_simulate and (size == 1 or self.cycles_differ()):
            self.add_cycles()
            fits, before = self.grown(beam, size)
        more = size == 1 and len(self.screened) > MOST_FITTED
        if more and not any_improves(fits, before):
            fits, before = self.grown(beam, size, MOST_FITTED)
        return fits, before

    def causes(self, explanation: Explanation) -> list[str]:
        """Return the names of the causes, without the base and with a family for its effect."""
        implied = {part.name for part in self.base.parts}
        implied |= {part.effect for part in explanation.parts if isinstance(part, Family)}
        return [name for name in explanation.causes if name not in implied] or explanation.causes

    def clear(self) -> None:
        """Return to the given model: what it lacks is not a cause."""
        assert self.initial is not None
        self.training, self.held_out = self.initial
        self.best, self.ranking, self.screened = None, [], []

    def restart(self) -> None:
        """Return to the base and to the initial data."""
        simulated = self.training.cycles is not None and not self.residuals_significant
        free = self.training.runs_freely
        assert self.initial is not None
        self.training, self.held_out = self.initial
        self.best = self.calibrated
        if simulated:
            self.add_cycles(free)

    def _needs_a_cause(self) -> bool:
        """Return whether significant residuals or cycles are left; adds cycles where needed."""
        self.progress('testing the residuals that are left')
        if self.strong() if self.has_cause else self.significant():
            return True
        if self.training.runs_freely and self.best is None:  # or they had not joined the data
            return True
        if self.training.cycles is None:
            if not self.cycles_differ():
                return False
            self.add_cycles()
            return self.best is None or self._needs_a_cause()
        return self.cycles_remain()

    def _accept(self, chosen: ScoredFit, fits: Sequence[ScoredFit], size: int) -> ScoredFit | None:
        """
        Accept an explanation and return it; None if its last cause explains too little.

        Another form of a cause is not a further one: the likelihood decides on it. Where all that
        is left is weak, one cause has to explain it alone. Of two that are left, the first may
        close little: then both together have to close the gap.
        It is fitted again with the noise that the data have if it is true: under it the piston
        moves otherwise than the given model predicts. The noise under values that are far off
        would hide the right ones: they are looked for before.
        """
        smaller, before = self.hypothesis, (self.best, self.training, self.held_out)
        accepted = self._renewed(chosen)
        another_form = size == 2 and isinstance(chosen.explanation.parts[-1], Family)
        enough = (size == 1 or another_form) and not self.training.runs_freely
        enough = enough or self.closes_the_gap(smaller, accepted)
        if enough and (not self.weak or self.explains_alone(smaller, before[1])):
            return accepted
        further = None
        if size < MOST_CAUSES and not (enough or self.weak):
            further = self._with_one_more(self._beam(accepted, fits), smaller, size + 1)
        if further is None:
            self.best, self.training, self.held_out = before
        return further

    def _with_one_more(
        self, beam: Sequence[Explanation], smaller: Hypothesis, size: int
    ) -> ScoredFit | None:
        """Return an explanation with a further cause if its last two close the gap, else None."""
        fits, before = self.grown(beam, size)
        if not any_improves(fits, before):
            return None
        chosen = preferred(fits)
        both = self._renewed(chosen)
        if not self.closes_the_gap(smaller, both, causes=2):
            return None
        self.ranking += [chosen, *fits]
        return both

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

    def _renewed(self, chosen: ScoredFit) -> ScoredFit:
        """
        Return an explanation fitted with the noise that the data have if it is true.

        Where more mass is accelerated the noise is larger: a fit that moves under it is repeated.
        """
        explanation = self.fit_thoroughly(chosen.explanation).explanation
        for _ in range(RENEWALS):
            self.training, self.held_out = (
                self._with_noise_of(explanation, each) for each in (self.training, self.held_out)
            )
            before, again = explanation, fit(explanation, self.given, self.training, FINAL_ROUNDS)
            explanation = again.explanation
            step = np.abs(explanation.theta - before.theta)
            if np.all(step < np.sqrt(np.diag(again.covariance))):
                break
        self.best = score(again, self.given, self.training, self.held_out)
        return self.best

    def _with_noise_of(self, explanation: Explanation, before: Dataset) -> Dataset:
        """Return a dataset with the noise that it has if an explanation is true."""
        hypothesis = explanation.apply(self.given)
        data = Dataset.of(hypothesis, before.comparisons, self.rng)
        if before.cycles is None:
            return data
        return data.with_cycles(hypothesis, self.rng, before.runs_freely)
