"""The state of a search: what its best explanation leaves, and whether that counts."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.diagnosis.causes.candidates import FORCE, Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.cycles import (
    CycleTest,
    compare_cycles,
    compare_free_runs,
)
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, by_balance, rms
from pneu_rig_ros.diagnosis.residuals.localisation import (
    NOISE_ERROR,
    SignificantResidual,
    localise,
)
from pneu_rig_ros.diagnosis.residuals.windows import BREAKAWAY, windows_of
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.scoring import (
    BALANCES_OF,
    DECISIVE,
    LITTLE_LEFT,
    MOST_LEFT,
    NEGLIGIBLE,
    Data,
    ScoredFit,
    excess,
    remaining_share,
    residual_excess,
)
from pneu_rig_ros.diagnosis.search.screening import Screened

# the reasons are in docs/diagnose.md: "The numbers that decide", "Weak nuisances and ..."
CYCLES_EXPLAINED = 0.1
"""Share of the excess of the cycles below which no further cause is searched [-]."""
WEAK, WEAK_CYCLES = 1.5, 2.0
"""
Where sensors and supply are known to their class only: RMS of what weak effects that no model has
may leave in a balance, relative to its noise [-], and the ratio by which they may increase the
loss of the simulated cycles [-].
"""
FREE_RUN = 'free run'
"""Regime of what only simulation without restarts shows."""


@dataclass(kw_only=True)
class SearchState:
    """
    What the best explanation so far leaves of the data.

    :param base: what is fitted with every explanation of the given hypothesis
    :param data: training and held-out data, with the noise under the best explanation so far
    :ivar initial: the same with the noise under the given hypothesis
    :ivar best: the accepted explanation
    :ivar calibrated: the base alone, fitted
    :ivar ranking: fitted explanations of accepted sizes
    :ivar screened: candidates for the first cause, the best first
    :ivar first_cycle_test: of the given hypothesis, if it was made
    :ivar held_out_test: the last one on the held-out data, with its hypothesis
    """

    base: Explanation
    data: Data
    rng: Generator
    initial: Data = field(init=False)
    best: ScoredFit | None = None
    calibrated: ScoredFit | None = None
    ranking: list[ScoredFit] = field(default_factory=list)
    screened: list[Screened] = field(default_factory=list)
    first_cycle_test: CycleTest | None = None
    held_out_test: tuple[Hypothesis, CycleTest] | None = None

    def __post_init__(self) -> None:
        """Keep the data as they are given."""
        self.initial = self.data

    @property
    def training(self) -> Dataset:
        """The data to which explanations are fitted."""
        return self.data.training

    @property
    def held_out(self) -> Dataset:
        """The data that judge them."""
        return self.data.held_out

    @property
    def given(self) -> Hypothesis:
        """The hypothesis that is to be explained."""
        return self.base.given

    @property
    def hypothesis(self) -> Hypothesis:
        """The given hypothesis with the best explanation so far."""
        return self.given if self.best is None else self.best.hypothesis

    @property
    def so_far(self) -> Fit:
        """The best explanation so far, the base where none was accepted."""
        return self.best or Fit(self.base)

    @property
    def has_cause(self) -> bool:
        """Whether a cause was accepted, and not the base alone."""
        return self.best is not None and self.best is not self.calibrated

    @property
    def uncalibrated(self) -> bool:
        """Whether sensors and supply are known to their class only, and were calibrated."""
        return self.calibrated is not None and all(self.calibrated.explanation.calibrates)

    @property
    def is_exactly_known(self) -> bool:
        """Whether pistons are free, sensors and supply exact, and all recordings alike."""
        runs = [comparison.run for comparison in self.training.comparisons]
        differ = any(run.repeatability or run.level_sd > 0.0 for run in runs)
        return self.moves_freely and not self.base.parts and not differ

    @property
    def moves_freely(self) -> bool:
        """Whether all pistons are free, so that their cycles can be simulated."""
        return all(comparison.free for comparison in self.training.comparisons)

    def significant(self) -> list[SignificantResidual]:
        """
        Return the significant residuals of the best explanation so far.

        What an accepted cause leaves in the training data alone, and little, is no evidence of
        another one.
        """
        found = localise(windows_of(self.training, self.hypothesis))
        return [] if found and self._by_chance(found) else found

    def _by_chance(self, found: Sequence[SignificantResidual]) -> bool:
        """
        Return whether what an accepted cause leaves is little, and not in the held-out data.

        What it leaves as it was, in a balance on which it does not act, is not little.
        """
        training = self.training.without_cycles
        if not self.has_cause or self.left_of(training) > LITTLE_LEFT:
            return False
        for name in {each.balance for each in found if each.p_value < np.exp(-DECISIVE)}:
            before, after = (
                residual_excess(training, each, [name]) for each in (self.given, self.hypothesis)
            )
            if before == 0.0 or after / before > LITTLE_LEFT:
                return False
        return not {each.balance for each in found} & self._disagreeing(self.held_out)

    def strong_residuals(self) -> list[SignificantResidual]:
        """
        Return the significant residuals that are more than several weak effects explain.

        Only of an uncalibrated system such effects are as likely as a single cause.
        """
        found = self.significant()
        if not (found and self.uncalibrated):
            return found
        left = by_balance(self.training.residuals_by_run(self.hypothesis))
        least = float(np.hypot(NOISE_ERROR, WEAK))
        return [residual for residual in found if rms(left[residual.balance]) > least]

    def only_weak_remains(self) -> bool:
        """Return whether several weak effects may make all that is left."""
        if not self.uncalibrated or self.training.cycles is not None:
            return False
        return not (self.strong_residuals() or self.cycles_differ())

    def residuals_are_reproduced(self) -> bool:
        """Return whether the held-out residuals are significant in the same balances."""
        return bool(self._disagreeing(self.training) & self._disagreeing(self.held_out))

    def _disagreeing(self, dataset: Dataset) -> set[str]:
        """Return the balances with significant residuals in a dataset."""
        return {each.balance for each in localise(windows_of(dataset, self.hypothesis))}

    def cycles_differ(self) -> bool:
        """
        Return whether simulated cycles are farther off than those of replicates.

        Those of an uncalibrated system have to be so by more than weak effects explain.
        """
        if not self.training.comparisons[0].free:
            return False
        test = self.cycle_test(self.hypothesis)
        if self.best is None:
            self.first_cycle_test = test
        strong = not self.uncalibrated or test.loss > WEAK_CYCLES * test.expected
        return test.significant and strong

    def cycles_remain(self) -> bool:
        """Return whether simulated cycles differ, and more than a little of it is unexplained."""
        if self.best is not None and self.remaining() < CYCLES_EXPLAINED:
            return False
        return self.cycles_differ()

    def cycle_test(self, hypothesis: Hypothesis) -> CycleTest:
        """Return the test of the cycles of the training data, or of the free runs of all."""
        if self.training.runs_freely:
            return self.free_run_test(hypothesis)
        return compare_cycles(hypothesis, self.training.comparisons, self.rng)

    def free_run_test(self, hypothesis: Hypothesis) -> CycleTest:
        """Return the test of the free runs of all recordings against those of replicates."""
        recordings = [*self.training.comparisons, *self.held_out.comparisons]
        return compare_free_runs(hypothesis, recordings, self.rng)

    def cycle_residuals(self) -> list[SignificantResidual]:
        """
        Return the difference of the given model's cycles from replicates', if significant.

        Simulation from rest to rest shows forces. A free run shows anything: it counts for the
        balances on which the best cause acts, or the best candidate where none was found.
        """
        test, group, regime = self.first_cycle_test, FORCE, BREAKAWAY
        if test is None or not test.significant:
            return []
        if self.training.runs_freely:
            found = [] if self.best is None else list(self.best.explanation.parts)
            first = [*found, *(screened.candidate for screened in self.screened)]
            group, regime = first[0].group, FREE_RUN
        names = tuple(comparison.run.name for comparison in self.training.comparisons)
        values = test.loss, test.expected, test.p_value
        return [
            SignificantResidual(balance, regime, '', '-', *values, '', None, None, names, ())
            for balance in BALANCES_OF[group]
        ]

    def left_of(self, dataset: Dataset) -> float:
        """Return the share of the excess on a dataset that the best explanation leaves [-]."""
        return remaining_share(dataset, self.given, self.hypothesis)

    def remaining(self) -> float:
        """Return the same of the held-out data."""
        return self.left_of(self.held_out)

    def left_by(self, fit: Fit) -> float:
        """Return the share of the excess on the held-out data that another explanation leaves."""
        return remaining_share(self.held_out, self.hypothesis, fit.hypothesis)

    def remaining_beyond_noise(self) -> float:
        """Return the share of the held-out excess that remains, 0 where what remains is noise."""
        before = excess(self.held_out, self.given)
        return self.excess_beyond_noise(self.hypothesis) / before if before > 0.0 else 0.0

    def excess_beyond_noise(self, hypothesis: Hypothesis) -> float:
        """
        Return the excess that a hypothesis leaves in the held-out data, 0 where that is noise.

        Of residuals only significant cells count in it; simulated cycles are noise if they are no
        farther off than those of replicates.
        """
        left = excess(self.held_out, hypothesis)
        if left <= 0.0 or self.held_out.cycles is None:
            return left
        if self.held_out_test is None or self.held_out_test[0] != hypothesis:
            compare = compare_free_runs if self.held_out.runs_freely else compare_cycles
            test = compare(hypothesis, self.held_out.comparisons, self.rng)
            self.held_out_test = hypothesis, test
        return left if self.held_out_test[1].significant else 0.0

    def reproduced(self) -> bool:
        """Return whether a cause was found, or the held-out data disagree as those fitted do."""
        if self.has_cause or (self.training.cycles is not None and self.cycles_differ()):
            return True
        return self.residuals_are_reproduced()

    def leaves_something(self, residuals: Sequence[SignificantResidual]) -> bool:
        """Return whether something remains, so that the best explanation may be wrong."""
        simulated = self.training.cycles is not None
        if not self.has_cause:
            return bool(residuals) or simulated
        if residuals or self.remaining_beyond_noise() > MOST_LEFT:
            return True
        if self.training.runs_freely:  # of which no residual has a trace to be described
            return False
        return simulated and self.cycles_differ() and self.remaining() > NEGLIGIBLE
