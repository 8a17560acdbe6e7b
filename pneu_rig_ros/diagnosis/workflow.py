"""
The workflow of a diagnosis: localise the residuals, select a cause, validate it on held-out data.

Localisation and the first ranking of causes need no simulation: the residuals of each open balance
are evaluated along the measured runs. Simulation from rest to rest confirms a cause where a piston
moves freely.
"""

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.answer.alternatives import rivals
from pneu_rig_ros.diagnosis.answer.intervals import replicate_errors
from pneu_rig_ros.diagnosis.answer.next_experiment import NextExperiment, next_experiment
from pneu_rig_ros.diagnosis.answer.repeatability import Variation, repeatability, variation
from pneu_rig_ros.diagnosis.answer.run_differences import (
    RunDifference,
    run_differences,
    sufficient_differences,
)
from pneu_rig_ros.diagnosis.answer.verdict import (
    CONDITIONS,
    CONSISTENT,
    UNCALIBRATED,
    UNKNOWN,
    of_parts,
)
from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.inputs.misstatement import Misstatement, find_misstatement
from pneu_rig_ros.diagnosis.inputs.read_inputs import Inputs, read_inputs
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, rms
from pneu_rig_ros.diagnosis.residuals.localisation import SignificantResidual, localise
from pneu_rig_ros.diagnosis.residuals.windows import Windows, windows_of
from pneu_rig_ros.diagnosis.search.empirical import Description
from pneu_rig_ros.diagnosis.search.growth import DISCREPANT
from pneu_rig_ros.diagnosis.search.name_or_unknown import name_or_description
from pneu_rig_ros.diagnosis.search.scoring import Data, ScoredFit, excess
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.executor import Executor, SerialExecutor

Progress = Callable[[str, float], None]
"""Called with a stage and the fraction of the work done [-]."""

SEARCH_STEPS = 25.0
"""Usual steps of a search, for its progress [-]."""


@dataclass(frozen=True)
class Diagnosis:
    """
    The result of a diagnosis.

    :param system: as given, or as it was found to be
    :param misstatement: the stated condition that is wrong, None where none is
    :param windows: of the training data under the given hypothesis
    :param where: its significant residuals
    :param best: the accepted explanation, None where nothing is missing
    :param unknown: empirical terms for what no cause explains
    :param differing: recordings that differ from the others
    :param errors: of fits of the best explanation to replicates, shape (replicates, coordinates)
    :param single: whether training and held-out data are parts of one recording
    :param seconds: duration of the diagnosis [s]
    """

    system: System
    misstatement: Misstatement | None
    search: Search
    windows: Sequence[Windows]
    where: Sequence[SignificantResidual]
    best: ScoredFit | None
    unknown: Description | None
    differing: Sequence[RunDifference]
    errors: Floats
    next_experiment: NextExperiment | None
    seed: int
    single: bool
    seconds: float

    @property
    def given(self) -> Hypothesis:
        """The hypothesis of the system as given."""
        return self.system.hypothesis

    @property
    def training(self) -> Dataset:
        """Training data with the noise under the given hypothesis."""
        return self.search.initial.training

    @property
    def held_out(self) -> Dataset:
        """Held-out data with the noise under the given hypothesis."""
        return self.search.initial.held_out

    @property
    def explanation(self) -> Explanation:
        """The accepted explanation, empty where nothing is missing."""
        return Explanation(self.given) if self.best is None else self.best.explanation

    @property
    def improved(self) -> Hypothesis:
        """The hypothesis with the explanation and the empirical terms."""
        explained = self.explanation.hypothesis
        if self.unknown is None:
            return explained
        return replace(self.unknown.explanation, given=explained).hypothesis

    @cached_property
    def variation(self) -> Variation:
        """How the recordings differ from each other under the improved hypothesis."""
        return variation(self.improved, self.search.data.single_runs, self.search.candidates)

    @property
    def improved_system(self) -> System:
        """The system with the improved model and what that leaves of these recordings."""
        improved = self.improved
        left = repeatability(self.system, improved, self.search.data, self.variation.spreads)
        if self.system.rig is not None:  # whose supply was warmer or colder in these recordings
            model = improved.model._replace(gas=self.given.model.gas)
            improved = replace(improved, model=model)
        return replace(self.system, hypothesis=improved, repeatability=left)

    @property
    def verdict(self) -> str:
        """
        One of consistent, uncalibrated, conditions, parameter, effect, unknown.

        What is misstated as a whole makes nearly all of a gap: whatever is found beside it comes
        second.
        """
        if self.misstatement is not None:
            return CONDITIONS
        if self.unknown is not None:
            return UNKNOWN
        verdict = of_parts(self.explanation.parts)
        return CONSISTENT if verdict == UNCALIBRATED and not self.where else verdict

    @property
    def significant(self) -> Sequence[SignificantResidual]:
        """Residuals of the given model that are significant, else its significant cycles."""
        if self.where or self.verdict == CONSISTENT:
            return self.where
        return self.search.cycle_residuals()


def diagnose(
    bags: Sequence[Path],
    model: str | Path,
    verify: Sequence[Path] = (),
    seed: int = 0,
    without: Sequence[str] = (),
    executor: Executor | None = None,
    progress: Progress = lambda stage, fraction: None,
    mapping: Path | None = None,
) -> Diagnosis:
    """
    Diagnose a model of a system with recordings.

    :param bags: recordings, bags or text tables
    :param model: name of a cylinder, or file of a rig or of any other system
    :param verify: held-out recordings for validation; every third of the others if omitted, of
        a single one its last third
    :param seed: of the noise of simulated readings and replicates
    :param without: effects that are not candidates
    :param executor: where candidates are screened and fitted; this process if omitted
    :param progress: callback(stage, fraction)
    :param mapping: file that maps the columns of a text table to signals with units
    :raises RigError: when a recording or the model cannot be used
    """
    begin = time.perf_counter()
    rng, workers = np.random.default_rng(seed), executor or SerialExecutor()
    progress('reading', 0.02)
    inputs = read_inputs(bags, verify, load_system(model), mapping, workers)
    progress('localising residuals', 0.06)
    data = _data(inputs, rng)
    windows = windows_of(data.training, inputs.system.hypothesis)
    where: Sequence[SignificantResidual] = localise(windows)
    misstatement = _find_misstatement(inputs, data)
    if misstatement is not None:
        inputs = replace(inputs, system=misstatement.system, runs=misstatement.runs)
        data = _data(inputs, rng)
    search = _search(inputs, data, rng, without, workers, progress)
    found = search.run() is not None or misstatement is not None
    earlier, needs_fit = inputs.system.spreads, misstatement is not None or bool(search.base.parts)
    differing = sufficient_differences(search, earlier) if where and not needs_fit else []
    progress('testing what is left', 0.85)
    unknown = None
    if differing:
        search.clear()
    else:
        where, unknown = _what_counts(search, where, found, progress)
    best, errors = search.best if unknown is None else search.calibrated, np.zeros((1, 0))
    if best is not None:
        progress('finding the errors of the fitted values', 0.93)
        errors = replicate_errors(best.explanation, search.training, rng, workers)
    if not (differing or inputs.single or unknown):
        runs, candidates = search.data.single_runs, search.candidates
        found_in = run_differences(search.hypothesis, runs, candidates, workers, earlier)
        differing = list(found_in.values())
    progress('designing the next experiment', 0.97)
    return Diagnosis(
        system=inputs.system,
        misstatement=misstatement,
        search=search,
        windows=windows,
        where=where,
        best=best,
        unknown=unknown,
        differing=differing,
        errors=errors,
        next_experiment=next_experiment(rivals(search), data.training, inputs.system),
        seed=seed,
        single=inputs.single,
        seconds=time.perf_counter() - begin,
    )


def _data(inputs: Inputs, rng: Generator) -> Data:
    """Return training and held-out data, with the noise under the model as given."""
    parts = inputs.runs[: inputs.count], inputs.runs[inputs.count :]
    training, held_out = (
        Dataset.of(inputs.system.hypothesis, [Comparison(run) for run in part], rng)
        for part in parts
    )
    return Data(training, held_out)


def _find_misstatement(inputs: Inputs, data: Data) -> Misstatement | None:
    """Return the wrong statement, None where the data give no reason to look for one."""
    given = inputs.system.hypothesis
    if rms(data.training.whitened(given)) <= DISCREPANT:
        return None
    found = find_misstatement(inputs.system, inputs.recordings, inputs.runs, inputs.paths)
    return found and replace(found, excess=excess(data.held_out, given))


def _search(
    inputs: Inputs,
    data: Data,
    rng: Generator,
    without: Sequence[str],
    executor: Executor,
    progress: Progress,
) -> Search:
    """Return the search for a cause in the candidates of the system."""
    steps = itertools.count(1)

    def report(stage: str) -> None:
        progress(stage, 0.1 + 0.75 * min(next(steps) / SEARCH_STEPS, 1.0))

    candidates, base = pool(inputs.system, inputs.runs, without)
    return Search(
        base=base, data=data, rng=rng, pool=candidates, progress=report, executor=executor
    )


def _what_counts(
    search: Search, where: Sequence[SignificantResidual], found: bool, progress: Progress
) -> tuple[Sequence[SignificantResidual], Description | None]:
    """Return the residuals that count, and empirical terms for what no cause explains."""
    remaining = search.strong_residuals()
    if not search.reproduced():
        return where if found else [], None
    shown = where or search.cycle_residuals()
    if not (shown and search.leaves_something(remaining)):
        return where, None
    progress('describing the unknown cause', 0.88)
    return where, name_or_description(search, shown)
