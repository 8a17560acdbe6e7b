"""
The workflow: where does the model disagree, what is missing, and how far does it shrink the gap.

The chambers are looked at first, under the measured motion; once they are explained, the whole
rig from rest to rest, so that what remains is a matter of forces.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from pneu_rig_ros.executor import Executor, Here
from pneu_rig_ros.gap.bags import parted, read_experiment
from pneu_rig_ros.gap.candidates import calibration, candidates
from pneu_rig_ros.gap.discriminate import NextExperiment, next_experiment
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import FINE_STEP, Explanation, Fit, first_of_each, fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.selection import LEAST_GAIN, Search
from pneu_rig_ros.gap.shrink import above_floor
from pneu_rig_ros.gap.uncertainty import with_spread
from pneu_rig_ros.gap.unknown import Description, describe
from pneu_rig_ros.gap.where import Disagreement, disagreements
from pneu_rig_ros.rig import RigConfiguration, load_configuration

Tell = Callable[[str, float], None]
STAGES = ((Mode.CHAMBERS, 'gas and valves'), (Mode.CYCLES, 'forces'))
FINAL_ROUNDS = 6
FITS_AGAIN = 4
"""How often at most what is known is fitted again."""
RECONCILED = 2
"""Explanations of one part that are fitted together with what is known."""
MOST_LEFT = 0.2
"""An explanation that leaves more of the gap on the runs left out does not explain it [-]."""
RIVALS = 3
"""Explanations that the next experiment is to tell apart."""


@dataclass
class Diagnosis:
    """
    What a diagnosis found.

    :param configuration: the model given
    :param fitted, held: experiments of the fits, and those left out
    :param explanation: what closes the gap, with intervals in ``final``
    :param unexplained: prediction whose gap nothing in the library closes, None if there is none
    :param searches: one for each prediction that had a gap
    """

    configuration: RigConfiguration
    fitted: Evidence
    held: Evidence
    seed: int = 0
    seconds: float = 0.0
    where: list[Disagreement] = field(default_factory=list)
    unknown: Description | None = None
    next_experiment: NextExperiment | None = None
    explanation: Explanation = field(default_factory=Explanation)
    final: Fit | None = None
    unexplained: Mode | None = None
    searches: dict[Mode, Search] = field(default_factory=dict)
    costs: dict[Mode, float] = field(default_factory=dict)

    @property
    def given(self) -> Hypothesis:
        """The hypothesis to begin with."""
        return Hypothesis(self.configuration.model, dict(self.configuration.effects))

    @property
    def improved(self) -> Hypothesis:
        """The hypothesis in the end."""
        return self.explanation.apply(self.given)

    @property
    def best(self) -> Hypothesis:
        """The hypothesis in the end, with the description of what is not known."""
        return self.unknown.hypothesis if self.unknown else self.improved

    def uncalibrated(self) -> Explanation:
        """Return the gains of the sensors as long as they have not been fitted."""
        gains = calibration(self.configuration.sensors)
        names = [part.name for part in self.explanation.parts]
        if gains is None or gains.name in names:
            return Explanation()
        return Explanation().plus(gains, gains.starts[0])

    @property
    def rivals(self) -> dict[str, Hypothesis]:
        """The explanation that was chosen last and those of the same size next to it."""
        if not self.searches:
            return {}
        search = list(self.searches.values())[-1]
        own = len(search.base.parts)
        size = len(search.best.fit.explanation.parts) if search.best else own + 1
        alike = [one.fit.explanation for one in search.ranking
                 if len(one.fit.explanation.parts) == size]  # fmt: skip
        return {' + '.join(one.causes): one.apply(search.given) for one in alike[:RIVALS]}

    @property
    def verdict(self) -> str:
        """One of consistent, parameter, effect, unknown."""
        if self.unexplained is not None:
            return 'unknown'
        if not self.explanation.causes:
            return 'consistent'
        effects = any(part.is_effect for part in self.explanation.parts)
        return 'effect' if effects else 'parameter'


def diagnose(
    bags: Sequence[Path], model: str | Path, verify: Sequence[Path] = (), seed: int = 0,
    without: Sequence[str] = (), executor: Executor | None = None,
    tell: Tell = lambda text, share: None, mapping: Path | None = None,
) -> Diagnosis:  # fmt: skip
    """
    Diagnose a model with measured bags.

    :param bags: measured runs, in bags or text tables
    :param model: name of a cylinder or a configuration file
    :param verify: runs that are left out of the fits
    :param seed: of the propagated errors
    :param without: effects that the library shall lack
    :param executor: where candidates are screened and fitted; this process if it is not said
    :param tell: told what is done now, and the share of the work done [-]
    :param mapping: which column of a text table is what, and its unit
    :raises RigError: when a bag or the model cannot be used
    """
    begin = time.perf_counter()
    configuration = load_configuration(model)
    rng = np.random.default_rng(seed)
    groups = []
    for group in parted(bags, verify):
        tell('reading', 0.02)
        runs = [read_experiment(bag, configuration, mapping) for bag in group]
        groups.append(Evidence(runs, rng))
    diagnosis = Diagnosis(configuration, groups[0], groups[1], seed)
    tell('where the model disagrees', 0.04)
    diagnosis.where = disagreements(diagnosis.given, diagnosis.fitted)
    for index, (mode, title) in enumerate(STAGES):
        stage = partial(_tell_stage, tell, title, 0.06 + 0.42 * index)
        explain(diagnosis, mode, without, stage, executor or Here())
        if diagnosis.unexplained is not None:
            break
    finish(diagnosis, partial(_tell_stage, tell, 'in the end', 0.9), executor or Here())
    tell('what to measure next', 0.95)
    diagnosis.next_experiment = next_experiment(diagnosis.rivals, diagnosis.fitted.experiments[0])
    diagnosis.seconds = time.perf_counter() - begin
    return diagnosis


def _tell_stage(tell: Tell, title: str, share: float, text: str) -> None:
    tell(f'{title}: {text}', share)


def explain(
    diagnosis: Diagnosis, mode: Mode, without: Sequence[str], tell: Callable[[str], None],
    executor: Executor,
) -> None:  # fmt: skip
    """Find out what closes the gap of one prediction; changes the diagnosis."""
    tell('comparing')
    known = diagnosis.improved
    search = Search(
        known, diagnosis.fitted, diagnosis.held, (mode,), tell, diagnosis.uncalibrated(), executor
    )
    search.settle(known)
    diagnosis.costs[mode] = search.cost(known)
    if diagnosis.costs[mode] < search.limit:
        return
    if diagnosis.explanation.parts:
        tell('fitting what is known')
        if (better := fitted_again(diagnosis, search, diagnosis.explanation)) is not None:
            diagnosis.explanation = better
            return
        search.settle(known)
    diagnosis.searches[mode] = search
    pool = [one for one in candidates(known, without) if mode in one.modes]
    found = search.run(pool)
    if found is not None:
        diagnosis.explanation = diagnosis.explanation.joined(found.fit.explanation)
    elif (better := reconciled(diagnosis, search, tell)) is not None:
        diagnosis.explanation = better
    else:
        diagnosis.unexplained = mode


def reconciled(
    diagnosis: Diagnosis, search: Search, tell: Callable[[str], None]
) -> Explanation | None:
    """
    Return what is known with the most promising of what is not, fitted together.

    A known value that is a little off moves the slips, so that nothing on top of it closes the
    gap. None if they leave something, or nothing is known.
    """
    if not diagnosis.explanation.parts:
        return None
    ranked = [one.fit.explanation for one in search.ranking]
    alone = [one for one in ranked if len(one.parts) == len(search.base.parts) + 1]
    for one in first_of_each([*alone[:RECONCILED], *ranked[:1]], lambda one: one):
        start = diagnosis.explanation.joined(one)
        tell('fitting ' + start.name)
        if (better := fitted_again(diagnosis, search, start)) is not None:
            return better
    return None


def fitted_again(
    diagnosis: Diagnosis, search: Search, explanation: Explanation
) -> Explanation | None:
    """
    Return what is known, fitted under what it closed and under what is searched now.

    An error that one prediction hardly shows moves the slips of the other; the fit then goes
    along a narrow valley, so it goes on for as long as it gains. None if it leaves something.

    :param explanation: what is known, or more
    """
    modes, left = tuple(dict.fromkeys((*diagnosis.searches, *search.modes))), np.inf
    for _ in range(FITS_AGAIN):
        result = fit(
            diagnosis.given, explanation, diagnosis.fitted, modes, FINAL_ROUNDS, FINE_STEP
        )
        explanation = result.explanation
        better = explanation.apply(diagnosis.given)
        for evidence in (diagnosis.fitted, diagnosis.held):
            evidence.settle_floors(better, diagnosis.searches)
        search.settle(better)
        before, left = left, search.cost(better)
        if left < search.limit:
            return explanation
        if left > LEAST_GAIN * before:
            break
    return None


def finish(diagnosis: Diagnosis, tell: Callable[[str], None], executor: Executor) -> None:
    """Fit all together, keep what shrinks the gap, describe the rest; changes the diagnosis."""
    if diagnosis.explanation.parts:
        tell('fitting all together')
        refit(diagnosis)
        judge(diagnosis)
    if (final := diagnosis.final) is not None:
        tell('how far the values may be off')
        modes = final.explanation.modes
        diagnosis.final = with_spread(final, diagnosis.given, diagnosis.fitted, modes, executor)
    if (mode := diagnosis.unexplained) is not None:
        tell('describing what is not known')
        search = diagnosis.searches[mode]
        everything = diagnosis.improved, search.fitted, search.held, mode
        diagnosis.unknown = describe(*everything, search.limit, executor)


def refit(diagnosis: Diagnosis) -> None:
    """Fit all parts of the explanation together; changes the diagnosis."""
    modes = diagnosis.explanation.modes
    for evidence in (diagnosis.fitted, diagnosis.held):
        evidence.settle_floors(diagnosis.improved, modes)
    diagnosis.final = together(diagnosis, modes)
    diagnosis.explanation = diagnosis.final.explanation


def judge(diagnosis: Diagnosis) -> None:
    """
    Judge the explanation on the runs left out; changes the diagnosis.

    One that makes the gap no smaller is taken out again; one that leaves much of it does not
    explain it.
    """
    before, after = above_floor(diagnosis.given, diagnosis.improved, diagnosis.held)
    if after >= before > 0.0:
        diagnosis.explanation, diagnosis.final = Explanation(), None
        diagnosis.unexplained = next(iter(diagnosis.searches))
    elif after > MOST_LEFT * before and diagnosis.unexplained is None:
        left = []
        for mode, search in diagnosis.searches.items():
            search.settle(diagnosis.improved)  # a cost and its limit go by the same floors
            if search.cost(diagnosis.improved) > search.limit:
                left.append(mode)
        diagnosis.unexplained = left[-1] if left else None


def together(diagnosis: Diagnosis, modes: Sequence[Mode]) -> Fit:
    """Return all parts of the explanation fitted to some predictions at once."""
    return fit(
        diagnosis.given, diagnosis.explanation, diagnosis.fitted, modes, FINAL_ROUNDS, FINE_STEP
    )
