"""
Growth of explanations by one cause: candidates are screened, the most promising fitted and scored.

What the residuals hardly show - bristles, compliance, inertia - shows in simulation from rest to
rest, which joins the data where they cannot decide.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidates import FORCE, GAS, SENSOR, Candidate, Explanation
from pneu_rig_ros.diagnosis.causes.shaped_effects import ShapedEffect, shaped_effects
from pneu_rig_ros.diagnosis.residuals.dataset import by_balance, loss, rms
from pneu_rig_ros.diagnosis.residuals.localisation import localise
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.diagnosis.search import chance, fitting, screening
from pneu_rig_ros.diagnosis.search.fitting import FIRST_ROUNDS, ROUNDS, Fit
from pneu_rig_ros.diagnosis.search.scoring import (
    DECISIVE,
    LARGEST_CHANCE,
    Grown,
    ScoredFit,
    ambiguous,
    best_of_each,
    improves,
    preferred,
    score,
)
from pneu_rig_ros.diagnosis.search.screening import Screened
from pneu_rig_ros.diagnosis.search.state import SearchState
from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks
from pneu_rig_ros.model import effects as library

MOST_FITTED = 6
"""Candidates that are fitted at each size."""
FINALISTS = 3
"""Explanations that are fitted further."""
DISCREPANT = 3.0
"""RMS residual of the best explanation from which on it is taken for noise of any model [-]."""


@dataclass(kw_only=True)
class Growth(SearchState):
    """
    Explanations with one more cause than the best so far.

    :param progress: called with a text at each step
    :param executor: where candidates are screened and fitted
    :ivar only_weak: whether several weak effects may make all that is left
    """

    pool: Sequence[Candidate]
    progress: Callable[[str], None] = lambda text: None
    executor: Executor = field(default_factory=SerialExecutor)
    only_weak: bool = False

    def grown(self, beam: Sequence[Explanation], size: int, first: int = 0) -> Grown:
        """
        Return explanations with one more cause: screened, fitted, compared.

        :param first: of the candidates in their order that is fitted
        """
        end = first + MOST_FITTED // len(beam)  # what is likely with one base crowds out no other
        starts = [
            start
            for base in beam
            for start in screening.starts_of(base, self._screened(base, size), first, end)
        ]
        if not starts:  # no candidate acts on what disagrees
            return Grown([], score(self.so_far, self.data))
        fits = best_of_each(self.fits(starts))
        # among causes that explain nothing further there is nothing to decide by simulation
        found = self.best is None or improves(preferred(fits), self.best)
        if found and self.can_simulate() and ambiguous(fits):
            self.add_cycles()
            fits = self.fits([each.explanation for each in fits])
        return self._with_discrepancy(fits)

    def grown_by_all_windows(self) -> Grown:
        """
        Return explanations with a first cause that no cell shows, but all windows together may.

        Of an uncalibrated system several weak effects are as likely as a faint one. What differs
        from recording to recording, as on a bench, does not sum up.
        """
        starts: list[Explanation] = []
        if self.is_exactly_known and self.can_simulate():
            residual = self.training.residual(self.given)
            screened = self._screened(self.base, 1)
            worth = screening.worth_a_fit(screened, loss(residual), residual.size)
            starts = screening.starts_of(self.base, worth, 0, MOST_FITTED)
        return Grown(self.fits(starts) if starts else [], score(self.so_far, self.data))

    def with_other_forms(self, grown: Grown) -> Grown:
        """
        Return the same with the other forms of the best effect, if that is beyond doubt.

        Fitted to some recordings, a wrong formula may predict others worse than without it.
        """
        best = min(grown.fits, key=lambda fit: fit.cost, default=grown.before)
        doubtful = grown.before.cost - best.cost < LARGEST_CHANCE
        if doubtful or not best.explanation.parts:
            return grown
        others = self.fits(self.other_forms([best.explanation]))
        return grown._replace(fits=[*grown.fits, *others])

    def beyond_chance(self, grown: Grown) -> bool:
        """Return whether the chosen cause gains decisively more than on replicates without it."""
        chosen, before = grown.chosen, grown.before
        improvement = before.cost - chosen.cost
        if improvement > LARGEST_CHANCE:
            return True
        self.progress('fitting replicates without ' + chosen.explanation.parts[-1].name)
        pair, data = (chosen.explanation, self.so_far.explanation), self.training.without_cycles
        gains = chance.gains_by_chance(*pair, data, self.rng, self.executor)
        price = chosen.penalty - before.penalty
        return improvement - max(*gains, price) + price > DECISIVE

    def without_or_in_place_of(self, part: Candidate, whole: Explanation) -> list[ScoredFit]:
        """Return fits of an explanation, without a part, and with other causes in its place."""
        smaller = whole.without(part)
        kept = {each.name for each in smaller.parts}
        others = [c for c in self.pool if c.group == part.group and c.name not in kept]
        starts = screening.starts_of(smaller, self._screen(smaller, others), 0, FINALISTS)
        return best_of_each(self.fits([whole, smaller, *starts]))

    def can_simulate(self) -> bool:
        """Return whether simulated cycles may join the data, and may show more than these."""
        return self.moves_freely and self.training.cycles is None and not self.only_weak

    def add_cycles(self, free: bool = False) -> None:
        """Add simulated cycles, or free runs, to the data; fit the best explanation to them."""
        self.data = self.data.with_cycles(self.hypothesis, self.rng, free)
        if self.best is not None and self.best.explanation.parts:
            self.best = self.fit_thoroughly(self.best.explanation)

    def _screened(self, base: Explanation, size: int) -> list[Screened]:
        """Return the candidates for one more cause of an explanation, the best first."""
        screened = self._screen(base, self._candidates(base))
        if size == 1 and not self.screened:
            self.screened = screened
        return screened

    def _screen(self, base: Explanation, candidates: Sequence[Candidate]) -> list[Screened]:
        """Return some candidates for one more cause of an explanation, the best first."""
        self.progress(f'screening {len(candidates)} candidates')
        hypothesis, runs = base.hypothesis, self.training.free_runs
        residual = self.training.residual(hypothesis) if runs is None else runs.gaps(hypothesis)
        free = np.zeros((residual.size, base.theta.size))
        if self.training.cycles is None:
            free = screening.changes(base, self.training)
        room = tuple(bound - base.theta for bound in base.bounds)
        arguments = hypothesis, self.training, residual, free, room
        screened = map_tasks(self.executor, screening.screen, candidates, *arguments)
        screened.sort(key=lambda result: result.loss)
        return screened

    def _candidates(self, base: Explanation) -> list[Candidate]:
        """Return what may join an explanation, other forms of its effects among them."""
        shaped = {part.effect for part in base.parts if isinstance(part, ShapedEffect)}
        forms = [
            form for part in base.parts if part.name not in shaped for form in self._forms_of(part)
        ]
        # what residuals hardly see, and simulated cycles do, are causes of the force
        balances = {residual.balance for residual in self.significant()}
        groups = {SENSOR, *(FORCE if name == 'force' else GAS for name in balances)}
        if self.training.cycles is not None:
            groups.add(FORCE)
        if self.training.runs_freely or not (balances or self.training.cycles):
            groups |= {FORCE, GAS}  # what no cell shows may be in any
        names = {part.name for part in base.parts}
        return [
            candidate
            for candidate in (*self.pool, *forms)
            if candidate.name not in names and candidate.group in groups
        ]

    def _forms_of(self, cause: Candidate) -> list[ShapedEffect]:
        """Return the other forms of an effect, over each variable that drives it."""
        if not cause.is_effect:
            return []
        runs = [comparison.run for comparison in self.training.comparisons]
        return list(shaped_effects(cause, runs, self.given.model.gas.supply_temperature))

    def other_forms(self, explanations: Sequence[Explanation]) -> list[Explanation]:
        """Return explanations with each other form of their last causes, at its best start."""
        starts = [
            explanation.with_part(form, values)
            for explanation in explanations
            for form in self._forms_of(explanation.parts[-1])
            for values in form.starts
        ]
        ordered = fitting.best_starts(starts, self.training, self.executor)
        best = {start.forms: start for start in reversed(ordered)}  # the last of each form stays
        return list(best.values())

    def fits(self, starts: Sequence[Explanation]) -> list[ScoredFit]:
        """Return explanations fitted from several starts; thoroughly only the finalists."""
        first = best_of_each(self.fit_all(starts, FIRST_ROUNDS, fitting.fit_from_valley))
        names = list(dict.fromkeys(each.explanation.name for each in first))[:FINALISTS]
        finalists = [each.explanation for each in first if each.explanation.name in names]
        others = [each for each in first if each.explanation.name not in names]
        fits = [*self.fit_all(finalists, ROUNDS), *others]
        return chance.beyond_noise(fits, self.hypothesis, self.data, self.rng)

    def fit_all(
        self, starts: Sequence[Explanation], rounds: int, fit: Callable[..., Fit] = fitting.fit
    ) -> list[ScoredFit]:
        """Return each of some explanations fitted and scored."""
        self.progress('fitting ' + ', '.join(start.name for start in starts))
        fits = map_tasks(self.executor, fit, starts, self.training, rounds)
        return map_tasks(self.executor, score, fits, self.data)

    def fit_thoroughly(self, explanation: Explanation) -> ScoredFit:
        """
        Return the best fit of an explanation from several starts.

        Where simulated cycles are not like those of replicates, slips at the wrong time make hills
        in the loss. Else several values may still compensate each other a little better; a single
        one, which is fitted from both sides, may not. Of residuals alone, states of the last cause
        may be out of phase with what is left.
        """
        self.progress('fitting ' + explanation.name)
        training, executor = self.training, self.executor
        best = fitting.multi_start(explanation, training, executor)
        if training.cycles is None:
            last = explanation.parts[-1]
            swings = last.is_effect and len(library.load(last.name).states) > 1
            if swings and localise(windows_of(training, best.hypothesis)):
                best = fitting.over_ridges(best, training, executor)
        elif not training.runs_freely:
            if self.cycle_test(best.hypothesis).significant:
                best = fitting.over_hills(best, training, executor)
            elif explanation.calibrates.count(False) > 1:
                best = fitting.simplex_search(best, training)
        return score(best, self.data)

    def _with_discrepancy(self, fits: list[ScoredFit]) -> Grown:
        """
        Return fits and the best one so far, where all are far off with that as part of the noise.

        The noise of the sensors is then no measure of which model is nearer. Where the forces of a
        free piston alone are far off, before it is simulated, each fit is compared under its own
        noise first: where a cause makes friction steep in the speed, that of its slips is many
        times that under another model.
        """
        best = min(fits, key=lambda fit: fit.cost).hypothesis
        data, so_far = self.data, self.so_far
        grown = Grown(fits, score(so_far, data))
        if rms(data.training.whitened(best)) < DISCREPANT:
            return grown
        rows = by_balance(data.training.residuals_by_run(best))
        gas = max(rms(rows[name]) for name in ('gas_1', 'gas_2'))
        if self.can_simulate() and gas < DISCREPANT:
            seed = int(self.rng.integers(2**32))
            pairs = map_tasks(self.executor, chance.under_own_noise, fits, data, seed)
            pairs.sort(key=lambda pair: pair[0].cost)
            if pairs[0][1] < DISCREPANT:
                return grown._replace(fits=[fit for fit, _ in pairs])
        self.data = data.each(lambda dataset: dataset.with_discrepancy(data.training, best))
        refitted = best_of_each(self.fits([each.explanation for each in fits]))
        grown = Grown(refitted, score(so_far, self.data))
        self.data = data
        return grown
