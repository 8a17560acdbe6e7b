"""
Which explanation the dataset asks for: as few causes as leave nothing significant.

Explanations grow by one cause at a time, up to three. Of each size the most promising are fitted
and compared. What the residuals hardly see - bristles, compliance, inertia - shows in simulation
from rest to rest, which becomes part of the dataset where they cannot decide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.stats import mannwhitneyu

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.candidates import FORCE, GAS, SENSOR, Candidate
from pneu_rig_ros.diagnosis.cycles import Cycles
from pneu_rig_ros.diagnosis.dataset import Dataset, rms
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.families import Family, families
from pneu_rig_ros.diagnosis.fitting import (
    Fit,
    Screened,
    far_starts,
    farther_along,
    fit,
    polished,
    screen,
)
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.localisation import SignificantResidual, localise, windows_of
from pneu_rig_ros.diagnosis.parallel import map_runs
from pneu_rig_ros.diagnosis.replicates import simulate_replicate
from pneu_rig_ros.diagnosis.scoring import (
    ScoredFit,
    ambiguous,
    best_of_each,
    excess,
    gained,
    preferred,
    remaining_share,
    score,
)
from pneu_rig_ros.executor import Executor, Here, map_tasks

Tell = Callable[[str], None]

LARGEST = 3
"""Causes of an explanation at most."""
FITTED = 6
"""Candidates that are fitted at each size."""
BEAM = 2
"""Explanations of one size that grow further."""
FEW, ROUNDS, LONG = 4, 15, 40
"""Rounds of the first fits to simulations, of the fits, and of the one that is kept."""
FINALISTS = 3
"""Explanations that are fitted to simulations to the end: each costs seconds."""
TWINS = 3
"""Twins of the runs that tell how far a true model's simulation is off."""
FALSE_ALARMS = 0.01
"""Share of true models whose simulation is called wrong [-]."""
LEAST_EXCESS = 1.3
"""Loss of cycles in that of twins up to which they are not off, however many there are [-]."""
DISCREPANT = 3.0
"""RMS of residuals that even the best explanation leaves, from which on that is its noise [-]."""
WORTH = 0.7
"""Share of the gap above which one more cause leaves too much to be one [-]."""
CLOSED = 0.1
"""Share of the excess of the cycles that is little enough to look for no further cause [-]."""
LITTLE = 0.03
"""Share of what exceeds the noise that is too little to ask for a description [-]."""


@dataclass(frozen=True)
class CycleTest:
    """Mean loss of simulated cycles, that of twins [-], and the p-value of the difference."""

    loss: float
    expected: float
    p_value: float


@dataclass
class Search:
    """
    The search for an explanation.

    :param given: the hypothesis to be explained
    :param fitted, held: dataset of the runs of the fits, and of those left out
    :param pool: candidates
    :param rng: of the noise
    :param tell: told what is done now
    :param executor: where candidates are screened and fitted
    :param base: what is fitted together with every explanation
    """

    given: Hypothesis
    fitted: Dataset
    held: Dataset
    pool: Sequence[Candidate]
    rng: np.random.Generator
    tell: Tell = lambda text: None
    executor: Executor = field(default_factory=Here)
    base: Explanation = field(default_factory=Explanation)
    screened: list[Screened] = field(default_factory=list)
    ranking: list[ScoredFit] = field(default_factory=list)
    best: ScoredFit | None = None
    calibrated: ScoredFit | None = None
    """Gains of the sensors alone, where they are open."""
    begin: tuple[Dataset, Dataset] | None = None
    """The dataset with the noise that the given hypothesis has."""
    significant_given: bool = False
    """Whether the residuals of the given hypothesis disagree."""
    first_cycles: CycleTest | None = None
    """How far the given model's simulated cycles are off, if they were looked at."""

    def run(self) -> ScoredFit | None:
        """Return the smallest explanation that leaves nothing significant, or the best of all."""
        self.begin = self.fitted, self.held
        self.significant_given = bool(self.significant())
        if not (self.significant_given or self.off_in_simulation()):
            return None
        if self.base.parts:
            self.tell('fitting ' + self.base.name)
            self.best = self.fit_long(self.base)
            self.base, self.calibrated = self.best.explanation, self.best
        nothing = Fit(self.base, 0.0, np.zeros((0, 0)))
        level = [self.base]
        for size in range(1, LARGEST + 1):
            if not self.needed():
                return self.best
            grown = [one for base in level for one in self.grow(base, size)]
            found, before = self.weighed(grown, nothing if self.best is None else self.best.fit)
            chosen = preferred(found)
            if not gained(chosen, before):
                break
            if size > 1 and not self.closes(chosen):
                break
            self.settle(chosen)
            self.ranking += [chosen, *found]
            level = self.level(found)
        return self.best

    def weighed(
        self, found: Sequence[ScoredFit], before: Fit
    ) -> tuple[Sequence[ScoredFit], ScoredFit]:
        """
        Return explanations, and the one before, as if what the best of them leaves were noise.

        Where every model is off by many times the noise of the sensors, that noise is no measure
        of which is nearer.
        """
        best = min(found, key=lambda one: one.total).explanation.apply(self.given)
        if rms(self.fitted.whitened(best)) < DISCREPANT:
            return found, self.scored(before)
        narrow = self.fitted, self.held
        self.fitted, self.held = (one.wider(narrow[0], best) for one in narrow)
        again = best_of_each(self.fits([one.explanation for one in found]))
        scored = self.scored(before)
        self.fitted, self.held = narrow
        return again, scored

    def closes(self, chosen: ScoredFit) -> bool:
        """Return whether one more cause leaves much less on the runs left out."""
        better = chosen.explanation.apply(self.given)
        return any(
            excess(dataset, better) < WORTH * excess(dataset, self.hypothesis)
            for dataset in (replace(self.held, cycles=None), self.held)
        )

    def level(self, found: Sequence[ScoredFit]) -> list[Explanation]:
        """Return the explanations that grow further: the best, and those next to it."""
        assert self.best is not None
        ordered = [one.explanation for one in sorted(found, key=lambda one: one.total)]
        own = self.best.explanation
        return [own, *(one for one in ordered if one.name != own.name)][:BEAM]

    @property
    def hypothesis(self) -> Hypothesis:
        """The hypothesis with the best explanation so far."""
        return self.given if self.best is None else self.best.explanation.apply(self.given)

    def causes(self, explanation: Explanation) -> list[str]:
        """Return the names of what explains, without what is fitted together with everything."""
        along = {part.name for part in self.base.parts}
        along |= {part.effect for part in explanation.parts if isinstance(part, Family)}
        beyond = [name for name in explanation.causes if name not in along]
        return beyond or explanation.causes

    def cycles_off(self) -> list[SignificantResidual]:
        """Return where simulation from rest to rest disagrees: in cycles, from breakaway on."""
        cycles = self.first_cycles
        if cycles is None:
            return []
        names = tuple(one.run.name for one in self.fitted.comparisons)
        return [SignificantResidual('force', 'breakaway', '', '-', cycles.loss, cycles.expected,
                             cycles.p_value, '', None, None, names, ())]  # fmt: skip

    def leaves_much(self, remains: Sequence[SignificantResidual]) -> bool:
        """Return whether so much remains that the explanation may be none."""
        if self.best is None or self.best is self.calibrated:
            return bool(remains) or self.fitted.cycles is not None
        if remains and self.left(simulated=False) > LITTLE:
            return True
        simulated = self.fitted.cycles is not None
        return simulated and self.off_in_simulation() and self.left() > LITTLE

    def confirmed(self) -> bool:
        """Return whether a cause was found, or the runs left out disagree in the same balances."""
        if self.first_cycles is not None or self.best is not None:
            return True
        both = [{one.balance for one in localise(windows_of(dataset, self.given))}
                for dataset in (self.fitted, self.held)]  # fmt: skip
        return bool(both[0] & both[1])

    def given_up(self) -> None:
        """Go back to what was known at first; changes the dataset too."""
        simulated = self.fitted.cycles is not None and not self.significant_given
        assert self.begin is not None
        self.fitted, self.held = self.begin
        self.best = self.calibrated
        if simulated:
            self.simulate()

    def needed(self) -> bool:
        """Return whether something significant is left; adds simulation where it is needed."""
        self.tell('what is left')
        if self.fitted.cycles is None:
            little = self.best is not None and self.left() < LITTLE
            if self.significant() and not little:
                return True
            if not self.off_in_simulation():
                return False
            self.simulate()
            return self.best is None or self.needed()
        if (
            self.best is not None
            and remaining_share(self.held, self.given, self.hypothesis) < CLOSED
        ):
            return False
        return self.off_in_simulation()

    def groups(self) -> set[str]:
        """Return what may be the cause of what is left: sensors, gas, forces."""
        if self.fitted.cycles is not None:
            return {FORCE, SENSOR}
        balances = {one.balance for one in self.significant()}
        return {SENSOR, *(FORCE if one == 'force' else GAS for one in balances)}

    def significant(self) -> list[SignificantResidual]:
        """Return where the best explanation disagrees."""
        return localise(windows_of(self.fitted, self.hypothesis))

    def left(self, simulated: bool = True) -> float:
        """
        Return the share of what exceeds the noise that the best explanation leaves [-].

        :param simulated: whether cycles count where simulation is part of the dataset
        """
        dataset = self.held if simulated else replace(self.held, cycles=None)
        return remaining_share(dataset, self.given, self.hypothesis)

    def off_in_simulation(self) -> bool:
        """Return whether cycles are farther off than those of twins."""
        if not self.fitted.comparisons[0].free:
            return False
        here, comparisons = self.hypothesis, self.fitted.comparisons
        losses = Cycles.of(here, comparisons, self.rng).losses(here)
        runs = [one.run for one in comparisons for _ in range(TWINS)]
        twins = map_runs(partial(simulate_replicate, here), runs, self.rng.spawn(len(runs)))
        expected = Cycles.of(here, [*map(Comparison, twins)], self.rng).losses(here)
        p = float(mannwhitneyu(losses, expected, alternative='greater').pvalue)
        cycles = CycleTest(float(losses.mean()), float(expected.mean()), p)
        if self.best is None:
            self.first_cycles = cycles
        return p < FALSE_ALARMS and cycles.loss > LEAST_EXCESS * cycles.expected

    def simulate(self) -> None:
        """Make simulation part of the dataset, and fit the best explanation under it."""
        here = self.hypothesis
        self.fitted = self.fitted.simulated(here, self.rng)
        self.held = self.held.simulated(here, self.rng)
        if self.best is not None and self.best.explanation.parts:
            self.best = self.fit_long(self.best.explanation)

    def grow(self, base: Explanation, size: int) -> list[ScoredFit]:
        """Return the fits of an explanation with one more cause."""
        names = {part.name for part in base.parts}
        shown = self.groups()
        rest = [one for one in (*self.pool, *self.forms(base))
                if one.name not in names and one.group in shown]  # fmt: skip
        self.tell(f'screening {len(rest)} candidates')
        known = base.apply(self.given)
        here = self.fitted.residual(known)
        ranked = sorted(
            map_tasks(self.executor, screen, rest, known, self.fitted, here),
            key=lambda one: one.loss,
        )
        if size == 1 and not self.screened:
            self.screened = ranked
        starts = [base.with_part(one.candidate, values) for one in ranked[:FITTED]
                  for values in (one.values, *one.others)]  # fmt: skip
        found = best_of_each(self.fits(starts))
        free = all(one.free for one in self.fitted.comparisons)
        if free and self.fitted.cycles is None and ambiguous(found):
            self.simulate()
            found = self.fits([one.explanation for one in found])
        return found

    def forms(self, base: Explanation) -> list[Family]:
        """Return the other forms of the effects in an explanation that have none yet."""
        shaped = {one.effect for one in base.parts if isinstance(one, Family)}
        runs = [one.run for one in self.fitted.comparisons]
        temperature = self.given.model.gas.supply_temperature
        return [form for one in base.parts if one.is_effect and one.name not in shaped
                for form in families(one, runs, temperature)]  # fmt: skip

    def fits(self, starts: Sequence[Explanation]) -> list[ScoredFit]:
        """Return explanations fitted from several starts; to simulations only the nearest."""
        if self.fitted.cycles is not None:
            ahead = sorted(best_of_each(self._fits(starts, FEW)), key=lambda one: one.total)
            starts = [one.explanation for one in ahead[:FINALISTS]]
        return self._fits(starts, ROUNDS)

    def _fits(self, starts: Sequence[Explanation], rounds: int) -> list[ScoredFit]:
        self.tell('fitting ' + ', '.join(one.name for one in starts))
        fits = map_tasks(self.executor, fit, starts, self.given, self.fitted, rounds)
        return map_tasks(self.executor, score, fits, self.given, self.fitted, self.held)

    def scored(self, one: Fit) -> ScoredFit:
        """Return a fit with its losses."""
        return score(one, self.given, self.fitted, self.held)

    def settle(self, chosen: ScoredFit) -> None:
        """
        Take an explanation for the best; find the noise if it is true, and fit it on under that.

        What moves, moves otherwise than the given model says, and its noise is another one.
        """
        self.tell('fitting ' + chosen.explanation.name)
        here = chosen.explanation.apply(self.given)
        self.fitted, self.held = (self.dataset(here, one) for one in (self.fitted, self.held))
        self.best = self.fit_long(chosen.explanation)

    def fit_long(self, explanation: Explanation) -> ScoredFit:
        """Return an explanation with the best values, of several starts where there are hills."""
        if self.fitted.cycles is None:
            return self.scored(fit(explanation, self.given, self.fitted, LONG))
        starts = [explanation, *far_starts(explanation, self.given, self.fitted)]
        found = map_tasks(self.executor, fit, starts, self.given, self.fitted, LONG)
        best = min(found, key=lambda one: one.loss)
        starts = farther_along(best)
        found = map_tasks(self.executor, fit, starts, self.given, self.fitted, ROUNDS)
        best = min((best, *found), key=lambda one: one.loss)
        return self.scored(polished(best, self.given, self.fitted))

    def dataset(self, hypothesis: Hypothesis, before: Dataset) -> Dataset:
        """Return the runs with their noise if a hypothesis is true."""
        dataset = Dataset.of(hypothesis, before.comparisons, self.rng)
        if before.cycles is None:
            return dataset
        return dataset.simulated(hypothesis, self.rng)
