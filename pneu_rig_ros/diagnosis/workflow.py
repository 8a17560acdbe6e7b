"""
The workflow: where does the model disagree, what is missing, and how far does that close the gap.

Nothing is simulated to find where: residuals of every open balance along the measured runs tell,
and rank the causes. Simulation from rest to rest confirms, where a piston moves freely.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.candidates import CALIBRATION, calibration
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.empirical import Description, describe
from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.localisation import SignificantResidual, Windows, localise, windows_of
from pneu_rig_ros.diagnosis.next_experiment import NextExperiment, next_experiment
from pneu_rig_ros.diagnosis.pool import pool
from pneu_rig_ros.diagnosis.read_runs import read_groups, split_paths
from pneu_rig_ros.diagnosis.scoring import ScoredFit
from pneu_rig_ros.diagnosis.selection import Search
from pneu_rig_ros.diagnosis.system import System, load_system
from pneu_rig_ros.executor import Executor, Here

Tell = Callable[[str, float], None]

CONSISTENT, UNCALIBRATED, CONDITIONS, PARAMETER, EFFECT, UNKNOWN = (
    'consistent', 'uncalibrated', 'conditions', 'parameter', 'effect', 'unknown'
)  # fmt: skip
RIVALS = 3
"""Explanations that the next experiment is to tell apart."""
MOST_LEFT, BETTER = 0.9, 0.7
"""
Share of what exceeds the noise that a named cause may leave, and share of that which a description
has to leave less than to be preferred [-].
"""
STEPS = 25.0
"""Steps that a search takes at most, for its progress [-]."""


@dataclass(frozen=True)
class Diagnosis:
    """
    What a diagnosis found.

    :param system: that was given
    :param model: its file or name
    :param fitted, held: dataset of the runs of the fits, and of those left out
    :param search: for the explanation
    :param windows: of the fitted runs under the given hypothesis
    :param where: what of them disagrees
    :param best: the explanation with what it leaves, None where nothing is missing
    :param unknown: description of what no cause explains
    """

    system: System
    model: str
    fitted: Dataset
    held: Dataset
    search: Search
    windows: Sequence[Windows]
    where: Sequence[SignificantResidual]
    best: ScoredFit | None
    unknown: Description | None
    next_experiment: NextExperiment | None
    seed: int
    seconds: float
    missing: Mapping[str, str]

    @property
    def given(self) -> Hypothesis:
        """The hypothesis to begin with."""
        return self.system.hypothesis

    @property
    def simulated(self) -> list[SignificantResidual]:
        """Where simulation from rest to rest alone disagrees: in the cycles, from breakaway on."""
        return self.search.cycles_off()

    @property
    def explanation(self) -> Explanation:
        """What was fitted, empty where nothing is missing."""
        return Explanation() if self.best is None else self.best.explanation

    @property
    def improved(self) -> Hypothesis:
        """The hypothesis in the end, with the description of what is not known."""
        known = self.explanation.apply(self.given)
        return known if self.unknown is None else self.unknown.explanation.apply(known)

    @property
    def verdict(self) -> str:
        """One of consistent, uncalibrated, conditions, parameter, effect, unknown."""
        if self.unknown is not None:
            return UNKNOWN
        causes = [part for part in self.explanation.parts if part.name != CALIBRATION]
        if not causes:
            return UNCALIBRATED if self.where and self.explanation.parts else CONSISTENT
        if any(part.is_effect for part in causes):
            return EFFECT
        return PARAMETER if any(part.is_parameter for part in causes) else CONDITIONS


def diagnose(
    bags: Sequence[Path], model: str | Path, verify: Sequence[Path] = (), seed: int = 0,
    without: Sequence[str] = (), executor: Executor | None = None,
    tell: Tell = lambda text, share: None, mapping: Path | None = None,
) -> Diagnosis:  # fmt: skip
    """
    Diagnose a model of a system with measured recordings.

    :param bags: recordings, bags or text tables
    :param model: name of a cylinder, or file of a rig or of what else is known
    :param verify: recordings that are left out of the fits; every third where none is named
    :param seed: of the noise that is added to find how far residuals spread
    :param without: effects that the library shall lack
    :param executor: where candidates are screened and fitted; this process if it is not said
    :param tell: told what is done now, and the share of the work done [-]
    :param mapping: which column of a text table is what, and its unit
    :raises RigError: when a recording or the model cannot be used
    """
    begin = time.perf_counter()
    system, rng = load_system(model), np.random.default_rng(seed)
    tell('reading', 0.02)
    groups = [[Comparison(run) for run in group]
              for group in read_groups(split_paths(bags, verify), system, mapping)]  # fmt: skip
    tell('where the model disagrees', 0.06)
    fitted, held = (Dataset.of(system.hypothesis, group, rng) for group in groups)
    windows = windows_of(fitted, system.hypothesis)
    where = localise(windows)
    search = _search(system, fitted, held, without, rng, tell, executor or Here())
    best = search.run()
    tell('what is left', 0.85)
    remains = search.significant()
    confirmed = search.confirmed()
    where = where if confirmed else []
    described = confirmed and search.leaves_much(remains)
    unknown = _described(search, where, tell) if described else None
    if unknown is not None:
        best = search.calibrated
    tell('what to measure next', 0.95)
    following = next_experiment(rivals(search), fitted, system)
    return Diagnosis(
        system, str(model), fitted, held, search, windows, where, best, unknown,
        following, seed, time.perf_counter() - begin,
        groups[0][0].run.missing,
    )  # fmt: skip


def _search(
    system: System, fitted: Dataset, held: Dataset, without: Sequence[str],
    rng: np.random.Generator, tell: Tell, executor: Executor,
) -> Search:  # fmt: skip
    runs = [one.run for one in (*fitted.comparisons, *held.comparisons)]
    steps = [0.0]

    def progress(text: str) -> None:
        steps[0] += 1.0
        tell(text, 0.1 + 0.75 * min(steps[0] / STEPS, 1.0))

    gains = None if system.sensors is None else calibration(system.sensors)
    base = Explanation() if gains is None else Explanation().with_part(gains, gains.starts[0])
    candidates = pool(system, runs, without)
    if system.refit:  # what the file says may be wrong is fitted together with every cause
        for one in candidates:
            base = base if one.is_effect else base.with_part(one, (one.was,))
        candidates = [one for one in candidates if one.is_effect]
    return Search(system.hypothesis, fitted, held, candidates, rng, progress, executor, base)


def _described(
    search: Search, where: Sequence[SignificantResidual], tell: Tell
) -> Description | None:
    """
    Return a description in place of the explanation; None where that explains as well.

    A name has to close about as much of the gap as a formula without one.
    """
    tell('describing what is not known', 0.88)
    named, left = search.best, search.left(simulated=not search.significant_given)
    settled = search.fitted, search.held
    search.given_up()
    description = describe(search, (where or search.cycles_off())[0])
    if named is None or named is search.calibrated:
        return description
    if left > MOST_LEFT or description.gap_left < BETTER * left:
        return description
    search.best, (search.fitted, search.held) = named, settled
    return None


def rivals(search: Search) -> dict[str, Hypothesis]:
    """Return the explanation that was chosen and those of the same size next to it."""
    if search.best is None:
        return {}
    size = len(search.best.explanation.parts)
    alike: dict[str, Hypothesis] = {}
    for one in sorted(search.ranking, key=lambda one: one.total):
        causes = search.causes(one.explanation)
        if len(one.explanation.parts) == size and causes:
            name = ' + '.join(causes)
            alike.setdefault(name, one.explanation.apply(search.given))
    return dict(list(alike.items())[:RIVALS])
