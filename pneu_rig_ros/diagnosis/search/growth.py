"""
Growth of explanations by one cause: candidates are screened, the most promising fitted and scored.

What the residuals hardly show - bristles, compliance, inertia - shows in simulation from rest to
rest, which joins the data where they cannot decide.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidates import FORCE, GAS, SENSOR, Candidate, Explanation
from pneu_rig_ros.diagnosis.causes.families import Family, families
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import by_balance, rms
from pneu_rig_ros.diagnosis.residuals.localisation import localise
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.diagnosis.search.fitting import FIRST_ROUNDS, ROUNDS, Fit, fit, fit_from_valley
from pneu_rig_ros.diagnosis.search.multi_start import (
    best_starts,
    multi_start,
    over_hills,
    over_ridges,
    simplex_search,
)
from pneu_rig_ros.diagnosis.search.noise_gain import beyond_noise, under_own_noise
from pneu_rig_ros.diagnosis.search.pooled_evidence import gains_by_chance
from pneu_rig_ros.diagnosis.search.remainder import Remainder
from pneu_rig_ros.diagnosis.search.scoring import (
    DECISIVE,
    LARGEST_CHANCE,
    ScoredFit,
    ambiguous,
    best_of_each,
    improves,
    preferred,
    score,
)
from pneu_rig_ros.diagnosis.search.screening import Screened, changes, screen
from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks
from pneu_rig_ros.model import effects as library

MOST_FITTED = 6
"""Candidates that are fitted at each size."""
FINALISTS = 3
"""Explanations that are fitted further."""
DISCREPANT = 3.0
"""RMS residual of the best explanation from which on it is taken for noise of any model [-]."""


@dataclass(kw_only=True)
class Growth(Remainder):
    """
    Explanations with one more cause than the best so far.

    :param progress: called with a text at each step
    :param executor: where candidates are screened and fitted
    :param base: what is fitted with every explanation
    :ivar screened: candidates for the first cause, the best first
    :ivar weak: whether several weak effects may make all that is left
    """

    pool: Sequence[Candidate]
    progress: Callable[[str], None] = lambda text: None
    executor: Executor = field(default_factory=SerialExecutor)
    base: Explanation = field(default_factory=Explanation)
    screened: list[Screened] = field(default_factory=list)
    weak: bool = False

    def grown(
        self, beam: Sequence[Explanation], size: int, first: int = 0
    ) -> tuple[list[ScoredFit], ScoredFit]:
        """
        Return the fits of explanations with one more cause, and the best one without it.

        :param first: of the candidates in their order that is fitted
        """
        end = first + MOST_FITTED // len(beam)  # what is likely with one base crowds out no other
        starts = [
            start
            for base in beam
            for start in starts_of(base, of_names(self._screened(base, size), first, end))
        ]
        if not starts:  # no candidate acts on what disagrees
            return [], self._scored_so_far()
        fits = best_of_each(self._fits(starts))
        # among causes that explain nothing further there is nothing to decide by simulation
        found = self.best is None or improves(preferred(fits), self.best)
        if found and self.can_simulate() and ambiguous(fits):
            self.add_cycles()
            fits = self._fits([each.explanation for each in fits])
        return self._with_discrepancy(fits, self.best or Fit(self.base))

    def beyond_chance(self, chosen: ScoredFit, before: ScoredFit) -> bool:
        """Return whether a fit gains decisively more than on replicates without its last cause."""
        improvement = before.cost - chosen.cost
        if improvement > LARGEST_CHANCE:
            return True
        self.progress('fitting replicates without ' + chosen.explanation.parts[-1].name)
        explanations = chosen.explanation, (self.best or Fit(self.base)).explanation
        data = self.training.without_cycles
        gains = gains_by_chance(*explanations, self.given, data, self.rng, self.executor)
        price = chosen.penalty - before.penalty
        return improvement - max(*gains, price) + price > DECISIVE

    def can_simulate(self) -> bool:
        """Return whether simulated cycles may join the data, and may show more than these."""
        free = all(comparison.free for comparison in self.training.comparisons)
        return free and self.training.cycles is None and not self.weak

    def add_cycles(self, free: bool = False) -> None:
        """
        Add simulated cycles to the data, and fit the best explanation to them.

        :param free: whether they are those of free runs
        """
        hypothesis = self.hypothesis
        self.training = self.training.with_cycles(hypothesis, self.rng, free)
        self.held_out = self.held_out.with_cycles(hypothesis, self.rng, free)
        if self.best is not None and self.best.explanation.parts:
            self.best = self.fit_thoroughly(self.best.explanation)

    def _scored_so_far(self) -> ScoredFit:
        """Return the best explanation so far with its losses."""
        return score(self.best or Fit(self.base), self.given, self.training, self.held_out)

    def _screened(self, base: Explanation, size: int) -> list[Screened]:
        """Return the candidates for one more cause of an explanation, the best first."""
        candidates = self._candidates(base)
        self.progress(f'screening {len(candidates)} candidates')
        hypothesis = base.apply(self.given)
        runs = self.training.free_runs
        residual = self.training.residual(hypothesis) if runs is None else runs.gaps(hypothesis)
        free = np.zeros((residual.size, base.theta.size))
        if self.training.cycles is None:
            free = changes(base, self.given, self.training)
        screened = map_tasks(
            self.executor, screen, candidates, hypothesis, self.training, residual, free, base.room
        )
        screened.sort(key=lambda result: result.loss)
        if size == 1 and not self.screened:
            self.screened = screened
        return screened

    def _candidates(self, base: Explanation) -> list[Candidate]:
        """Return what may join an explanation, other forms of its effects among them."""
        shaped = {part.effect for part in base.parts if isinstance(part, Family)}
        effects = [part for part in base.parts if part.is_effect and part.name not in shaped]
        forms = [family for part in effects for family in self._forms_of(part)]
        # what residuals hardly see, and simulated cycles do, are causes of the force
        balances = {residual.balance for residual in self.significant()}
        groups = {SENSOR, *(FORCE if name == 'force' else GAS for name in balances)}
        if self.training.cycles is not None:
            groups.add(FORCE)
        if self.training.runs_freely or not (balances or self.training.cycles):
            # what no cell shows may be in any
            groups |= {FORCE, GAS}
        names = {part.name for part in base.parts}
        return [
            candidate
            for candidate in (*self.pool, *forms)
            if candidate.name not in names and candidate.group in groups
        ]

    def _forms_of(self, effect: Candidate) -> list[Family]:
        """Return the other forms of an effect, over each variable that drives it, if it is one."""
        if not effect.is_effect:
            return []
        runs = [comparison.run for comparison in self.training.comparisons]
        return list(families(effect, runs, self.given.model.gas.supply_temperature))

    def with_other_forms(
        self, fits: Sequence[ScoredFit], before: ScoredFit
    ) -> tuple[list[ScoredFit], ScoredFit]:
        """
        Return fits with the other forms of the best effect, if that is beyond doubt.

        Fitted to some recordings, a wrong formula may predict others worse than without it.
        """
        best = min(fits, key=lambda fit: fit.cost, default=before)
        last = best.explanation.parts[-1:]
        doubtful = before.cost - best.cost < LARGEST_CHANCE
        if doubtful or not last:
            return list(fits), before
        return [*fits, *self._fits(self._with_other_forms([best.explanation]))], before

    def _with_other_forms(self, explanations: Sequence[Explanation]) -> list[Explanation]:
        """Return explanations with each other form of their last causes, at its best start."""
        starts = [
            explanation.with_part(form, values)
            for explanation in explanations
            for form in self._forms_of(explanation.parts[-1])
            for values in form.starts
        ]
        ordered = best_starts(starts, self.given, self.training, self.executor)
        best = {start.forms: start for start in reversed(ordered)}  # the last of each form stays
        return list(best.values())

    def _fits(self, starts: Sequence[Explanation]) -> list[ScoredFit]:
        """Return explanations fitted from several starts; thoroughly only the finalists."""
        first = best_of_each(self._fit_all(starts, FIRST_ROUNDS, fit_from_valley))
        names = list(dict.fromkeys(each.explanation.name for each in first))[:FINALISTS]
        finalists = [each.explanation for each in first if each.explanation.name in names]
        others = [each for each in first if each.explanation.name not in names]
        fits = [*self._fit_all(finalists, ROUNDS), *others]
        data = self.training, self.held_out
        return beyond_noise(fits, self.given, self.hypothesis, data, self.rng)

    def _fit_all(
        self, starts: Sequence[Explanation], rounds: int, fit_one: Callable[..., Fit] = fit
    ) -> list[ScoredFit]:
        self.progress('fitting ' + ', '.join(start.name for start in starts))
        fits = map_tasks(self.executor, fit_one, starts, self.given, self.training, rounds)
        return map_tasks(self.executor, score, fits, self.given, self.training, self.held_out)

    def _with_discrepancy(
        self, fits: list[ScoredFit], smaller: Fit
    ) -> tuple[list[ScoredFit], ScoredFit]:
        """
        Return fits and a smaller one, where every model is far off with that as part of the noise.

        The noise of the sensors is then no measure of which model is nearer.
        """
        best = min(fits, key=lambda fit: fit.cost).explanation.apply(self.given)
        data = self.training, self.held_out
        before = score(smaller, self.given, *data)
        if rms(self.training.whitened(best)) < DISCREPANT:
            return fits, before
        if self._slips_alone_are_far_off(best) and (own := self._under_own_noise(fits)):
            return own, before
        self.training, self.held_out = (
            dataset.with_discrepancy(data[0], best) for dataset in data
        )
        refitted = best_of_each(self._fits([each.explanation for each in fits]))
        before = score(smaller, self.given, self.training, self.held_out)
        self.training, self.held_out = data
        return refitted, before

    def _slips_alone_are_far_off(self, hypothesis: Hypothesis) -> bool:
        """
        Return whether only the forces of a free piston are far off, before it is simulated.

        Where a cause makes friction steep in the speed, the noise of its slips is many times that
        under another model.
        """
        rows = by_balance(self.training.residuals_by_run(hypothesis))
        gas = max(rms(rows[name]) for name in ('gas_1', 'gas_2'))
        return self.can_simulate() and gas < DISCREPANT

    def _under_own_noise(self, fits: Sequence[ScoredFit]) -> list[ScoredFit]:
        """
        Return fits under the noise that the data have if they are true, the likeliest first.

        None if even that is far off.
        """
        data, seed = (self.training, self.held_out), int(self.rng.integers(2**32))
        pairs = map_tasks(self.executor, under_own_noise, fits, self.given, data, seed)
        pairs.sort(key=lambda pair: pair[0].cost)
        return [fit for fit, _ in pairs] if pairs[0][1] < DISCREPANT else []

    def fit_thoroughly(self, explanation: Explanation) -> ScoredFit:
        """Return the best fit of an explanation from several starts."""
        self.progress('fitting ' + explanation.name)
        problem = self.given, self.training, self.executor
        best = multi_start(explanation, *problem)
        if self.training.cycles is not None and not self.training.runs_freely:
            best = self._beyond_slips(best)
        elif self.training.cycles is None and self._may_swing(best):
            best = over_ridges(best, *problem)
        return score(best, self.given, self.training, self.held_out)

    def _beyond_slips(self, found: Fit) -> Fit:
        """
        Return the best of a fit to simulations and of others that slips separate from it.

        Where cycles are not like those of replicates, slips at the wrong time make hills in the
        loss. Else several values may still compensate each other a little better; a single one,
        which is fitted from both sides, may not.
        """
        if self.cycle_test(found.explanation.apply(self.given)).significant:
            return over_hills(found, self.given, self.training, self.executor)
        if found.explanation.calibrates.count(False) > 1:
            return simplex_search(found, self.given, self.training)
        return found

    def _may_swing(self, found: Fit) -> bool:
        """Return whether states of the last cause may be out of phase with what is left."""
        last = found.explanation.parts[-1]
        swings = last.is_effect and len(library.load(last.name).states) > 1
        improved = found.explanation.apply(self.given)
        return swings and bool(localise(windows_of(self.training, improved)))


def starts_of(base: Explanation, screened: Sequence[Screened]) -> list[Explanation]:
    """Return an explanation with each candidate, from all its starts."""
    return [
        base.with_theta(base.theta + result.shift).with_part(result.candidate, values)
        for result in screened
        for values in result.starts
    ]


def of_names(screened: Sequence[Screened], first: int, end: int) -> list[Screened]:
    """Return the candidates of some names in their order, under every reading of their law."""
    names = list(dict.fromkeys(result.candidate.name for result in screened))[first:end]
    return [result for result in screened if result.candidate.name in names]
