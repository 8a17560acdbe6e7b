"""
Which explanation the evidence asks for: as few causes as leave nothing significant.

Explanations grow by one cause at a time, up to three. Of each size the most promising are fitted
and compared by the log predictive density of the runs left out; of those within two standard
errors of the best (A. Vehtari, A. Gelman, J. Gabry, Stat. Comput. 27 (2017) 1413) the simplest is
taken. What the residuals hardly see - bristles, compliance, inertia - shows in simulation from
rest to rest, which becomes part of the evidence where they cannot decide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import mannwhitneyu

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.candidates import FORCE, GAS, SENSOR, Candidate
from pneu_rig_ros.diagnosis.confirmation import Confirmation
from pneu_rig_ros.diagnosis.evidence import Evidence, rms
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.localisation import NOISE_KNOWN, Disagreement, localise, windows_of
from pneu_rig_ros.diagnosis.ranking import Fit, Screened, fit, screen
from pneu_rig_ros.diagnosis.twins import twin_of
from pneu_rig_ros.executor import Executor, Here, map_tasks

Floats = NDArray[np.float64]
Tell = Callable[[str], None]

LARGEST = 3
"""Causes of an explanation at most."""
FITTED = 6
"""Candidates that are fitted at each size."""
BEAM = 2
"""Explanations of one size that grow further."""
ROUNDS, LONG = 15, 40
"""Rounds of the first fits, and of the one that is kept."""
ERRORS = 2.0
"""Standard errors within which two explanations are not told apart."""
DECISIVE = 10.0
"""
Difference of log densities beyond which they are, however few the runs [-]: odds of 20 000 to 1,
of which the errors of the noise model may take some.
"""
TWINS = 3
"""Twins of the runs that tell how far a true model's simulation is off."""
FALSE_ALARMS = 0.01
"""Share of true models whose simulation is called wrong [-]."""
LEAST_EXCESS = 1.3
"""Loss of cycles in that of twins up to which they are not off, however many there are [-]."""
TRUE_LOSS = 3.5
"""Mean loss of the cycles of a true model [-]."""
DISCREPANT = 3.0
"""RMS of residuals that even the best explanation leaves, from which on that is its noise [-]."""
WORTH = 0.7
"""Share of the gap above which one more cause leaves too much to be one [-]."""
LITTLE = 0.03
"""Share of what exceeds the noise that is too little to ask for a description [-]."""


@dataclass(frozen=True)
class Scored:
    """
    A fitted explanation and what it leaves.

    :param fit: the fit
    :param losses: of independent stretches of all runs, those left out last, shape (k,)
    :param penalty: what its coordinates cost (Schwarz) [-]
    """

    fit: Fit
    losses: Floats
    penalty: float

    @property
    def explanation(self) -> Explanation:
        """The explanation with its values."""
        return self.fit.explanation

    @property
    def total(self) -> float:
        """Negative log density of all runs, penalised [-]."""
        return float(self.losses.sum()) + self.penalty

    @property
    def effects(self) -> int:
        """Number of effects in the explanation."""
        return sum(part.is_effect for part in self.explanation.parts)

    def behind(self, other: Scored) -> tuple[float, float]:
        """Return by how much it is worse than another one, and the standard error of that."""
        difference = self.losses - other.losses
        error = float(np.sqrt(difference.size) * difference.std())
        return self.total - other.total, error


def no_worse(one: Scored, best: Scored) -> bool:
    """Return whether one is within two standard errors of the best."""
    worse, error = one.behind(best)
    return worse <= min(ERRORS * error, DECISIVE)


def preferred(scored: Sequence[Scored]) -> Scored:
    """Return the simplest of those that are within two standard errors of the best."""
    best = min(scored, key=lambda one: one.total)
    alike = [one for one in scored if no_worse(one, best)]
    return min(alike, key=lambda one: (len(one.explanation.coordinates), one.total))


@dataclass(frozen=True)
class Cycles:
    """Mean loss of simulated cycles, that of twins [-], and the p-value of the difference."""

    loss: float
    expected: float
    p_value: float


@dataclass
class Search:
    """
    The search for an explanation.

    :param given: the hypothesis to be explained
    :param fitted, held: evidence of the runs of the fits, and of those left out
    :param pool: candidates
    :param rng: of the noise
    :param tell: told what is done now
    :param executor: where candidates are screened and fitted
    :param base: what is fitted together with every explanation
    """

    given: Hypothesis
    fitted: Evidence
    held: Evidence
    pool: Sequence[Candidate]
    rng: np.random.Generator
    tell: Tell = lambda text: None
    executor: Executor = field(default_factory=Here)
    base: Explanation = field(default_factory=Explanation)
    screened: list[Screened] = field(default_factory=list)
    ranking: list[Scored] = field(default_factory=list)
    best: Scored | None = None
    calibrated: Scored | None = None
    """Gains of the sensors alone, where they are open."""
    begin: tuple[Evidence, Evidence] | None = None
    """The evidence with the noise that the given hypothesis has."""
    significant_given: bool = False
    """Whether the residuals of the given hypothesis disagree."""
    first_cycles: Cycles | None = None
    """How far the given model's simulated cycles are off, if they were looked at."""

    @cached_property
    def losses_given(self) -> float:
        """Losses of the given hypothesis on all runs, by residuals alone [-]."""
        pair = (replace(one, confirmation=None) for one in (self.fitted, self.held))
        return float(sum(one.losses(self.given).sum() for one in pair))

    def run(self) -> Scored | None:
        """Return the smallest explanation that leaves nothing significant, or the best of all."""
        self.begin = self.fitted, self.held
        self.significant_given = bool(self.significant())
        if not (self.significant_given or self.off_in_simulation()):
            return None
        if self.base.parts:
            self.tell('fitting ' + self.base.name)
            self.best = self.scored(fit(self.base, self.given, self.fitted, LONG))
            self.base, self.calibrated = self.best.explanation, self.best
        level = [self.base]
        for size in range(1, LARGEST + 1):
            if not self.needed():
                return self.best
            grown = [one for base in level for one in self.grow(base, size)]
            found, before = self.weighed(grown)
            chosen = preferred(found)
            if before is not None and not gained(chosen, before):
                break
            if size > 1 and not self.closes(chosen):
                break
            self.settle(chosen)
            self.ranking += [chosen, *found]
            level = self.level(found)
        return self.best

    def weighed(self, found: Sequence[Scored]) -> tuple[Sequence[Scored], Scored | None]:
        """
        Return explanations, and the best so far, as if what the best of them leaves were noise.

        Where every model is off by many times the noise of the sensors, that noise is no measure
        of which is nearer.
        """
        best = min(found, key=lambda one: one.total).explanation.apply(self.given)
        if rms(self.fitted.whitened(best)) < DISCREPANT:
            return found, self.best
        narrow = self.fitted, self.held
        self.fitted, self.held = (one.wider(narrow[0], best) for one in narrow)
        again = best_of_each(self.fits([one.explanation for one in found], ROUNDS))
        before = None if self.best is None else self.scored(self.best.fit)
        self.fitted, self.held = narrow
        return again, before

    def closes(self, chosen: Scored) -> bool:
        """Return whether one more cause leaves much less on the runs left out."""
        pair = self.hypothesis, chosen.explanation.apply(self.given)
        before, after = (above(self.held.whitened(one)) for one in pair)
        confirmation = self.held.confirmation
        if after < WORTH * before or confirmation is None:
            return after < WORTH * before
        excess = [float((confirmation.losses(one) - TRUE_LOSS).sum()) for one in pair]
        return excess[1] < WORTH * excess[0]

    def level(self, found: Sequence[Scored]) -> list[Explanation]:
        """Return the explanations that grow further: the best, and those next to it."""
        assert self.best is not None
        ordered = [one.explanation for one in sorted(found, key=lambda one: one.total)]
        own = self.best.explanation
        return [own, *(one for one in ordered if one.name != own.name)][:BEAM]

    @property
    def hypothesis(self) -> Hypothesis:
        """The hypothesis with the best explanation so far."""
        return self.given if self.best is None else self.best.explanation.apply(self.given)

    def cycles_off(self) -> list[Disagreement]:
        """Return where simulation from rest to rest disagrees: in cycles, from breakaway on."""
        cycles = self.first_cycles
        if cycles is None:
            return []
        names = tuple(one.run.name for one in self.fitted.comparisons)
        return [Disagreement('force', 'breakaway', '', '-', cycles.loss, cycles.expected,
                             cycles.p_value, '', None, None, names, ())]  # fmt: skip

    def leaves_much(self, remains: Sequence[Disagreement]) -> bool:
        """Return whether so much remains that the explanation may be none."""
        if self.best is None or self.best is self.calibrated:
            return bool(remains) or self.fitted.confirmation is not None
        off = self.fitted.confirmation is not None and self.off_in_simulation()
        return (bool(remains) or off) and self.left_in_all() > LITTLE

    def given_up(self) -> None:
        """Go back to what was known at first; changes the evidence too."""
        simulated = self.fitted.confirmation is not None and not self.significant_given
        assert self.begin is not None
        self.fitted, self.held = self.begin
        self.best = self.calibrated
        if simulated:
            self.simulate()

    def left_in_all(self) -> float:
        """Return the share of what exceeds the noise that the best explanation leaves [-]."""
        confirmation = self.held.confirmation
        if confirmation is None or self.significant_given:
            return self.left()
        before, after = (confirmation.losses(one).sum() for one in (self.given, self.hypothesis))
        least = TRUE_LOSS * confirmation.losses(self.hypothesis).size
        return float(max(after - least, 0.0) / max(before - least, 1e-9))

    def needed(self) -> bool:
        """Return whether something significant is left; adds simulation where it is needed."""
        self.tell('what is left')
        if self.fitted.confirmation is None:
            if self.significant():
                return True
            if not self.off_in_simulation():
                return False
            self.simulate()
            return True
        return self.off_in_simulation()

    def groups(self) -> set[str]:
        """Return what may be the cause of what is left: sensors, gas, forces."""
        if self.fitted.confirmation is not None:
            return {FORCE, SENSOR}
        balances = {one.balance for one in self.significant()}
        return {SENSOR, *(FORCE if one == 'force' else GAS for one in balances)}

    def significant(self) -> list[Disagreement]:
        """Return where the best explanation disagrees."""
        return localise(windows_of(self.fitted, self.hypothesis))

    def left(self) -> float:
        """Return the share of what exceeds the noise that the best explanation leaves [-]."""
        before, after = (above(self.held.whitened(one)) for one in (self.given, self.hypothesis))
        return after / before if before > 0.0 else 0.0

    def off_in_simulation(self) -> bool:
        """Return whether cycles are farther off than those of twins."""
        if not self.fitted.comparisons[0].free:
            return False
        here, comparisons = self.hypothesis, self.fitted.comparisons
        losses = Confirmation.of(here, comparisons, self.rng).losses(here)
        twins = [Comparison(twin_of(here, one.run, self.rng))
                 for one in comparisons for _ in range(TWINS)]  # fmt: skip
        expected = Confirmation.of(here, twins, self.rng).losses(here)
        p = float(mannwhitneyu(losses, expected, alternative='greater').pvalue)
        cycles = Cycles(float(losses.mean()), float(expected.mean()), p)
        if self.best is None:
            self.first_cycles = cycles
        return p < FALSE_ALARMS and cycles.loss > LEAST_EXCESS * cycles.expected

    def simulate(self) -> None:
        """Make simulation part of the evidence."""
        here = self.hypothesis
        self.fitted = self.fitted.simulated(here, self.rng)
        self.held = self.held.simulated(here, self.rng)
        if self.best is not None:
            self.best = self.scored(self.best.fit)

    def grow(self, base: Explanation, size: int) -> list[Scored]:
        """Return the fits of an explanation with one more cause."""
        names = {part.name for part in base.parts}
        shown = self.groups()
        rest = [one for one in self.pool if one.name not in names and one.group in shown]
        self.tell(f'screening {len(rest)} candidates')
        known = base.apply(self.given)
        here = self.fitted.residual(known)
        ranked = sorted(
            map_tasks(self.executor, screen, rest, known, self.fitted, here),
            key=lambda one: one.loss,
        )
        if size == 1 and not self.screened:
            self.screened = ranked
        starts = [base.plus(one.candidate, values) for one in ranked[:FITTED]
                  for values in (one.values, *one.others)]  # fmt: skip
        found = best_of_each(self.fits(starts, ROUNDS))
        free = all(one.free for one in self.fitted.comparisons)
        if free and self.fitted.confirmation is None and ambiguous(found):
            self.simulate()
            found = self.fits([one.explanation for one in found], ROUNDS)
        return found

    def fits(self, starts: Sequence[Explanation], rounds: int) -> list[Scored]:
        """Return explanations fitted from several starts."""
        self.tell('fitting ' + ', '.join(one.name for one in starts))
        fits = map_tasks(self.executor, fit, starts, self.given, self.fitted, rounds)
        return map_tasks(self.executor, score, fits, self.given, self.fitted, self.held)

    def scored(self, one: Fit) -> Scored:
        """Return a fit with its losses."""
        return score(one, self.given, self.fitted, self.held)

    def settle(self, chosen: Scored) -> None:
        """
        Take an explanation for the best; find the noise if it is true, and fit it on under that.

        What moves, moves otherwise than the given model says, and its noise is another one.
        """
        self.tell('fitting ' + chosen.explanation.name)
        here = chosen.explanation.apply(self.given)
        self.fitted, self.held = (self.evidence(here, one) for one in (self.fitted, self.held))
        self.best = self.scored(fit(chosen.explanation, self.given, self.fitted, LONG))

    def evidence(self, hypothesis: Hypothesis, before: Evidence) -> Evidence:
        """Return the runs with their noise if a hypothesis is true."""
        evidence = Evidence.of(hypothesis, before.comparisons, self.rng)
        if before.confirmation is None:
            return evidence
        return evidence.simulated(hypothesis, self.rng)


def best_of_each(scored: Sequence[Scored]) -> list[Scored]:
    """Return the best of those that have the same causes."""
    best: dict[str, Scored] = {}
    for one in sorted(scored, key=lambda one: one.total):
        best.setdefault(one.explanation.name, one)
    return list(best.values())


def score(one: Fit, given: Hypothesis, fitted: Evidence, held: Evidence) -> Scored:
    """Return a fit with its losses on all runs."""
    hypothesis = one.explanation.apply(given)
    parts = [evidence.losses(hypothesis) for evidence in (fitted, held)]
    count = sum(whiten.kept.sum() for noise in fitted.noises for whiten in noise)
    penalty = 0.5 * len(one.explanation.coordinates) * float(np.log(max(count, 1)))
    return Scored(one, np.concatenate(parts), penalty)


def gained(one: Scored, before: Scored) -> bool:
    """Return whether an explanation is better than a smaller one by more than its error."""
    worse, error = one.behind(before)
    return -worse > max(ERRORS * error, DECISIVE)


def ambiguous(found: Sequence[Scored]) -> bool:
    """Return whether a cause of friction is among several that cannot be told apart."""
    best = min(found, key=lambda one: one.total)
    alike = [one for one in found if no_worse(one, best)]
    last = [one.explanation.parts[-1] for one in alike]
    return len(alike) > 1 and any(part.group == FORCE for part in last)


def above(whitened: Floats) -> float:
    """Return what of residuals noise does not explain, in standard deviations [-]."""
    if not whitened.size:
        return 0.0
    excess = float(np.mean(whitened**2)) - NOISE_KNOWN**2
    return float(np.sqrt(max(excess, 0.0)))
