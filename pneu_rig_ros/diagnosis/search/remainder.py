"""What a hypothesis leaves of the data, and whether it is significant, reproduced and large."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.diagnosis.causes.candidates import FORCE, GAS, SENSOR
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, Residuals
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
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.scoring import (
    DECISIVE,
    MOST_LEFT,
    MOST_LEFT_ALONE,
    ScoredFit,
    excess,
    remaining_share,
    residual_excess,
)

NEGLIGIBLE = 0.03
"""Share of the excess so small that its significance is no measure of a cause [-]."""

CYCLES_EXPLAINED = 0.1
"""Share of the excess of the cycles below which no further cause is searched [-]."""

WEAK = 1.5
"""
RMS of what weak effects that no model has may leave in a balance, relative to its noise [-].

It counts where even sensors and supply are known to their class only: there several such effects
are as likely as a single cause. Nuisances are defined to be that weak in the blind trials.
"""

LEAST_EFFECT = 0.5
"""
RMS of the change of a residual, relative to its noise, by the weakest cause that is named where
sensors and supply are known to their class only [-]. In trials for building it was up to 0.43 of
what several weak effects looked like, and 0.73 or more of single causes.
"""

WEAK_CYCLES = 2.0
"""
Ratio by which they may increase the loss of the simulated cycles [-], a robust one. In 29 trials
for building with weak effects alone it was 1.5 at most, in one more 2.3.
"""

BALANCES_OF = {GAS: ('gas_1', 'gas_2'), FORCE: ('force',), SENSOR: BALANCES}
"""Group of a cause -> balances on which it acts."""

ANOTHER_CAUSE_LEAVES = 0.7
"""Largest share of the excess that one more cause may leave [-]."""


@dataclass(kw_only=True)
class Remainder:
    """
    What the best explanation so far leaves of the data.

    :ivar best: the accepted explanation
    :ivar calibrated: the base alone
    :ivar first_cycle_test: of the given hypothesis, if it was made
    :ivar held_out_test: the last one on the held-out data, with its hypothesis
    """

    given: Hypothesis
    training: Dataset
    held_out: Dataset
    rng: Generator
    best: ScoredFit | None = None
    calibrated: ScoredFit | None = None
    first_cycle_test: CycleTest | None = None
    held_out_test: tuple[Hypothesis, CycleTest] | None = None

    @property
    def hypothesis(self) -> Hypothesis:
        """The given hypothesis with the best explanation so far."""
        return self.given if self.best is None else self.best.explanation.apply(self.given)

    @property
    def has_cause(self) -> bool:
        """Whether a cause was accepted, and not the base alone."""
        return self.best is not None and self.best is not self.calibrated

    @property
    def uncalibrated(self) -> bool:
        """Whether sensors and supply are known to their class only, and were calibrated."""
        return self.calibrated is not None and all(self.calibrated.explanation.calibrates)

    def significant(self) -> list[SignificantResidual]:
        """
        Return the significant residuals of the best explanation so far.

        What an accepted cause leaves in the training data alone, and little, is no evidence of
        another one.
        """
        found = localise(windows_of(self.training, self.hypothesis))
        return [] if found and self._by_chance(found) else found

    def strong(self) -> list[SignificantResidual]:
        """
        Return the significant residuals that are more than several weak effects explain.

        Only of an uncalibrated system such effects are as likely as a single cause.
        """
        found = self.significant()
        if not (found and self.uncalibrated):
            return found
        left = self._left_by_balance(self.training)
        least = float(np.hypot(NOISE_ERROR, WEAK))
        return [residual for residual in found if left[residual.balance] > least]

    def is_weak(self) -> bool:
        """Return whether several weak effects may make all that is left."""
        if not self.uncalibrated or self.training.cycles is not None:
            return False
        return not (self.strong() or self.cycles_differ())

    def explains_alone(self, smaller: Hypothesis, searched: Dataset) -> bool:
        """
        Return whether the last cause leaves nothing but noise where it acts, and more was left.

        Several weak effects would leave what the others make.

        :param smaller: the hypothesis without it
        :param searched: the training data in which it was found, with the noise under that
        """
        before, after = (searched.residuals_by_run(each) for each in (smaller, self.hypothesis))
        differences = [
            Residuals(*(a - b for a, b in zip(*pair, strict=True)))
            for pair in zip(before, after, strict=True)
        ]
        changes = rms_by_balance(differences)
        wide = {name for name, left in rms_by_balance(before).items() if left > NOISE_ERROR}
        acts = {name for name in wide if changes[name] > LEAST_EFFECT}
        left = [self._left_by_balance(dataset) for dataset in (self.training, self.held_out)]
        alone = bool(acts) and all(each[name] < NOISE_ERROR for each in left for name in acts)
        return alone and self.remaining() < MOST_LEFT_ALONE

    def _by_chance(self, found: Sequence[SignificantResidual]) -> bool:
        """
        Return whether what an accepted cause leaves is little, and not in the held-out data.

        What it leaves as it was, in a balance on which it does not act, is not little.
        """
        training = self.training.without_cycles
        if not self.has_cause or self.left_of(training) > MOST_LEFT:
            return False
        balances = {each.balance for each in found}
        clear = {each.balance for each in found if each.p_value < np.exp(-DECISIVE)}
        if any(self._left_in(name, training) > MOST_LEFT for name in clear):
            return False
        return not balances & self._disagreeing(self.held_out)

    def _left_in(self, balance: str, dataset: Dataset) -> float:
        """Return the share of the excess in a balance that the best explanation leaves [-]."""
        before, after = (
            residual_excess(dataset, each, (balance,)) for each in (self.given, self.hypothesis)
        )
        return after / before if before > 0.0 else 1.0

    def _disagreeing(self, dataset: Dataset) -> set[str]:
        """Return the balances with significant residuals in a dataset."""
        return {each.balance for each in localise(windows_of(dataset, self.hypothesis))}

    def _left_by_balance(self, dataset: Dataset) -> dict[str, float]:
        return rms_by_balance(dataset.residuals_by_run(self.hypothesis))

    def left_of(self, dataset: Dataset) -> float:
        """Return the share of the excess on a dataset that the best explanation leaves [-]."""
        return remaining_share(dataset, self.given, self.hypothesis)

    def left_by(self, fit: Fit) -> float:
        """Return the share of the excess on the held-out data that another explanation leaves."""
        return remaining_share(self.held_out, self.hypothesis, fit.explanation.apply(self.given))

    def remaining(self) -> float:
        """Return the same of the held-out data."""
        return self.left_of(self.held_out)

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

    def reproduced(self) -> bool:
        """Return whether a cause was found, or the held-out data disagree as those fitted do."""
        if self.has_cause or (self.training.cycles is not None and self.cycles_differ()):
            return True
        return self.residuals_are_reproduced()

    def residuals_are_reproduced(self) -> bool:
        """Return whether the held-out residuals are significant in the same balances."""
        return bool(self._disagreeing(self.training) & self._disagreeing(self.held_out))

    def leaves_something(self, residuals: Sequence[SignificantResidual]) -> bool:
        """Return whether something remains, so that the best explanation may be wrong."""
        simulated = self.training.cycles is not None
        if not self.has_cause:
            return bool(residuals) or simulated
        if residuals or self.remaining_beyond_noise() > MOST_LEFT_ALONE:
            return True
        if self.training.runs_freely:  # of which no residual has a trace to be described
            return False
        return simulated and self.cycles_differ() and self.remaining() > NEGLIGIBLE

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
        return left if left > 0.0 and self._held_out_differ(hypothesis) else 0.0

    def _held_out_differ(self, hypothesis: Hypothesis) -> bool:
        """Return whether held-out cycles, if simulated, are farther off than replicates'."""
        if self.held_out.cycles is None:
            return True
        if self.held_out_test is None or self.held_out_test[0] != hypothesis:
            compare = compare_free_runs if self.held_out.runs_freely else compare_cycles
            test = compare(hypothesis, self.held_out.comparisons, self.rng)
            self.held_out_test = hypothesis, test
        return self.held_out_test[1].significant

    def closes_the_gap(self, smaller: Hypothesis, accepted: ScoredFit, causes: int = 1) -> bool:
        """
        Return whether more causes leave much less on the held-out data.

        Where hardly anything is significant there, that is no measure of a cause: the likelihood,
        by which it was chosen, has to do. Nor is a gap in balances on which a cause does not act,
        unless cycles are simulated, in which a cause of the forces moves everything, as any does
        in free runs. These are so sharp that they show the formula of the first cause to be off,
        and many a further one closes a part of that: it has to close most.

        :param causes: that the accepted explanation has more than the smaller one
        """
        better = accepted.explanation.apply(self.given)
        if self.held_out.runs_freely:
            before, after = (excess(self.held_out, each) for each in (smaller, better))
            first = len(accepted.explanation.parts) == causes
            most = ANOTHER_CAUSE_LEAVES if first else MOST_LEFT_ALONE
            return after < most**causes * before
        groups = {part.group for part in accepted.explanation.parts[-causes:]}
        if self.held_out.cycles is None or groups == {GAS}:
            acts_on = [name for group in groups for name in BALANCES_OF[group]]
            before, after = (
                residual_excess(self.held_out, each, acts_on) for each in (smaller, better)
            )
            if after <= ANOTHER_CAUSE_LEAVES**causes * before:
                return True
        for dataset in (self.held_out.without_cycles, self.held_out):
            left = excess(dataset, smaller)
            if left < NEGLIGIBLE * excess(dataset, self.given):
                return True
            if excess(dataset, better) < ANOTHER_CAUSE_LEAVES**causes * left:
                return True
        return False


def rms_by_balance(rows: Sequence[Residuals]) -> dict[str, float]:
    """Return balance -> root mean square of the residuals of runs, breakaways among the forces."""
    return {name: rms(values) for name, values in by_balance(rows).items()}
