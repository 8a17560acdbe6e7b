"""
Causes too faint for any cell, where sensors and supply are exact.

They add up: in the residuals over all windows, and in a free run from cycle to cycle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from pneu_rig_ros.diagnosis.causes.candidates import FORCE, Explanation
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.residuals.localisation import SignificantResidual
from pneu_rig_ros.diagnosis.residuals.windows import BREAKAWAY
from pneu_rig_ros.diagnosis.search.fitting import FIRST_ROUNDS, ROUNDS, fit
from pneu_rig_ros.diagnosis.search.growth import (
    FINALISTS,
    MOST_FITTED,
    Growth,
    of_names,
    starts_of,
)
from pneu_rig_ros.diagnosis.search.pooled_evidence import worth_a_fit
from pneu_rig_ros.diagnosis.search.remainder import BALANCES_OF, NEGLIGIBLE
from pneu_rig_ros.diagnosis.search.scoring import (
    ScoredFit,
    any_improves,
    best_of_each,
    preferred,
    residual_excess,
    score,
)
from pneu_rig_ros.executor import map_tasks

FREE_RUN = 'free run'
"""Regime of what only simulation without restarts shows."""
UNFINISHED = 2.0
"""Factor by which a first fit may leave more than it would after more evaluations [-]."""


@dataclass(kw_only=True)
class FaintCauses(Growth):
    """
    The search for what no cell shows.

    :ivar ranking: fitted explanations of accepted sizes
    :ivar initial: the data with the noise under the given hypothesis
    :ivar free_runs_are_off: whether those of causes that leave no residual are
    """

    ranking: list[ScoredFit] = field(default_factory=list)
    initial: tuple[Dataset, Dataset] | None = None
    free_runs_are_off: bool = False

    def pooled(self) -> list[ScoredFit]:
        """
        Return the fits of single causes if all windows together show one that no cell shows.

        Of an uncalibrated system several weak effects are as likely as a faint one. What differs
        from recording to recording, as on a bench, does not sum up.
        """
        if not (self.is_exact() and self.can_simulate()):
            return []
        residual = self.training.residual(self.given)
        screened = worth_a_fit(self._screened(self.base, 1), loss(residual), residual.size)
        starts = starts_of(self.base, of_names(screened, 0, MOST_FITTED))
        if not starts:
            return []
        fits, before = self._fits(starts), self._scored_so_far()
        found = any_improves(fits, before) and self.beyond_chance(preferred(fits), before)
        return fits if found else []

    def is_exact(self) -> bool:
        """Return whether pistons are free, sensors and supply exact, and all recordings alike."""
        comparisons = self.training.comparisons
        free = all(comparison.free for comparison in comparisons)
        runs = [comparison.run for comparison in comparisons]
        differ = any(run.repeatability or run.level_error > 0.0 for run in runs)
        return free and not self.base.parts and not differ

    def free_runs_differ(self) -> bool:
        """
        Return whether free runs of the given model are off where nothing else was found.

        Then they join the initial data. Cycles that are off, and by no force, do not prevent it.
        """
        if not self.is_exact() or self.residuals_are_reproduced():
            return False
        assert self.initial is not None
        self.progress('comparing free runs')
        test = self.free_run_test(self.given)
        if test.significant:
            self.training, self.held_out = self.initial
            self.first_cycle_test, self.screened = test, []
            self.add_cycles(free=True)
        return test.significant

    def by_free_runs(self, best: ScoredFit) -> ScoredFit | None:
        """
        Return another explanation than the best one if free runs prefer it.

        They distinguish causes, and forms of one, that leave the same residuals. Where something
        is significant beside the best one, its free runs are off whether it is right or not.
        """
        if not self.is_exact() or self.training.runs_freely or self.strong():
            return None
        if self.training.cycles is not None and self.cycles_remain():
            return None
        self.progress('comparing free runs')
        self.free_runs_are_off = self._off_in_free_runs(best)
        if not self.free_runs_are_off:
            return None
        before = self.training, self.held_out
        self.training, self.held_out = (each.without_cycles for each in before)
        first = best_of_each(self._fit_all(self._alternatives(best), FIRST_ROUNDS))
        near = self._leaving_as_little(first, best, UNFINISHED)
        fits = self._fit_all([fit.explanation for fit in near], ROUNDS)
        fits = [best, *self._leaving_as_little(fits, best)]
        self.training, self.held_out = (
            each.with_cycles(self.hypothesis, self.rng, free=True)
            for each in (self.training, self.held_out)
        )
        fits = map_tasks(self.executor, score, fits, self.given, self.training, self.held_out)
        self.ranking = self._fits([fit.explanation for fit in best_of_each(fits)][:MOST_FITTED])
        self.training, self.held_out = before
        chosen = preferred(self.ranking)
        return chosen if chosen.explanation.forms != best.explanation.forms else None

    def _off_in_free_runs(self, best: ScoredFit) -> bool:
        """
        Return whether free runs of an explanation are off, also with values fitted to them.

        Those of the residuals alone are not sharp enough.
        """
        if not self.free_run_test(self.hypothesis).significant:
            return False
        training = self.training.with_cycles(self.hypothesis, self.rng, free=True)
        sharper = fit(best.explanation, self.given, training, ROUNDS).explanation
        return self.free_run_test(sharper.apply(self.given)).significant

    def _leaving_as_little(
        self, fits: Sequence[ScoredFit], best: ScoredFit, slack: float = 1.0
    ) -> list[ScoredFit]:
        """Return the fits that leave next to no more residual than the best one, or some more."""
        left = list(fits)
        for data in (self.training, self.held_out):
            least = residual_excess(data, best.explanation.apply(self.given))
            most = slack * max(NEGLIGIBLE * residual_excess(data, self.given), least)
            left = [
                fit
                for fit in left
                if residual_excess(data, fit.explanation.apply(self.given)) <= most
            ]
        return left

    def _alternatives(self, best: ScoredFit) -> list[Explanation]:
        """Return the fitted explanations of the same size, and other forms of their effects."""
        size = len(best.explanation.parts)
        fits = [fit for fit in self.ranking if len(fit.explanation.parts) == size]
        first = [fit.explanation for fit in best_of_each([best, *fits])][:MOST_FITTED]
        return [*first, *self._with_other_forms(first[:FINALISTS])]

    def cycle_residuals(self) -> list[SignificantResidual]:
        """
        Return the difference of the given model's cycles from replicates', if significant.

        Simulation from rest to rest shows forces. A free run shows anything: it counts for the
        balances on which the best cause acts, or the best candidate where none was found.
        """
        test, balances, regime = self.first_cycle_test, BALANCES_OF[FORCE], BREAKAWAY
        if test is None or not test.significant:
            return []
        if self.training.runs_freely:
            found = [] if self.best is None else list(self.best.explanation.parts)
            first = [*found, *(screened.candidate for screened in self.screened)]
            balances, regime = BALANCES_OF[first[0].group], FREE_RUN
        names = tuple(comparison.run.name for comparison in self.training.comparisons)
        values = test.loss, test.expected, test.p_value
        return [
            SignificantResidual(balance, regime, '', '-', *values, '', None, None, names, ())
            for balance in balances
        ]
