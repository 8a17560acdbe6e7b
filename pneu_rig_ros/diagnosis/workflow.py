"""
The workflow of a diagnosis: localise the residuals, select a cause, validate it on held-out data.

Localisation and the first ranking of causes need no simulation: the residuals of each open balance
are evaluated along the measured runs. Simulation from rest to rest confirms a cause where a piston
moves freely.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.answer.alternatives import rivals
from pneu_rig_ros.diagnosis.answer.intervals import replicate_errors
from pneu_rig_ros.diagnosis.answer.next_experiment import NextExperiment, next_experiment
from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import CALIBRATION, Explanation
from pneu_rig_ros.diagnosis.inputs.read_runs import (
    prepare_runs,
    read_recordings,
    split_in_time,
    split_paths,
    with_unknown_temperature,
)
from pneu_rig_ros.diagnosis.inputs.repeatability import repeatability
from pneu_rig_ros.diagnosis.inputs.restated import Restated, otherwise
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, rms
from pneu_rig_ros.diagnosis.residuals.localisation import SignificantResidual, localise
from pneu_rig_ros.diagnosis.residuals.windows import Windows, windows_of
from pneu_rig_ros.diagnosis.runs.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.runs.run import Run
from pneu_rig_ros.diagnosis.search.empirical import Description
from pneu_rig_ros.diagnosis.search.scoring import ScoredFit, excess
from pneu_rig_ros.diagnosis.search.selection import DISCREPANT, Search
from pneu_rig_ros.diagnosis.search.unknown import describe_unknown
from pneu_rig_ros.executor import Executor, SerialExecutor

Progress = Callable[[str, float], None]
"""Called with a stage and the fraction of the work done [-]."""

CONSISTENT, UNCALIBRATED, CONDITIONS = 'consistent', 'uncalibrated', 'conditions'
PARAMETER, EFFECT, UNKNOWN = 'parameter', 'effect', 'unknown'
"""Verdicts."""
SEARCH_STEPS = 25.0
"""Usual steps of a search, for its progress [-]."""


@dataclass(frozen=True)
class Diagnosis:
    """
    The result of a diagnosis.

    :param system: as given, or as it was found to be
    :param restated: what was found to be otherwise than stated, None where nothing was
    :param training, held_out: data with the noise under the given hypothesis
    :param search: for the explanation
    :param windows: of the training data under the given hypothesis
    :param where: its significant residuals
    :param best: the accepted explanation, None where nothing is missing
    :param unknown: empirical terms for what no cause explains
    :param errors: of fits of the best explanation to replicates, shape (replicates, coordinates)
    :param single: whether training and held-out data are parts of one recording
    :param seconds: duration of the diagnosis [s]
    """

    system: System
    restated: Restated | None
    training: Dataset
    held_out: Dataset
    search: Search
    windows: Sequence[Windows]
    where: Sequence[SignificantResidual]
    best: ScoredFit | None
    unknown: Description | None
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
    def explanation(self) -> Explanation:
        """The accepted explanation, empty where nothing is missing."""
        return Explanation() if self.best is None else self.best.explanation

    @property
    def improved(self) -> Hypothesis:
        """The hypothesis with the explanation and the empirical terms."""
        explained = self.explanation.apply(self.given)
        return explained if self.unknown is None else self.unknown.explanation.apply(explained)

    @property
    def improved_system(self) -> System:
        """The system with the improved model and what that leaves of these recordings."""
        datasets = self.search.training, self.search.held_out
        left = repeatability(self.system, self.improved, datasets)
        return replace(self.system, hypothesis=self.improved, repeatability=left)

    @property
    def missing(self) -> Mapping[str, str]:
        """Balance -> what is missing to compare it, '' where it is open."""
        return self.training.comparisons[0].run.missing

    @property
    def verdict(self) -> str:
        """
        One of consistent, uncalibrated, conditions, parameter, effect, unknown.

        What was restated as a whole makes nearly all of a gap: whatever is found beside it comes
        second.
        """
        if self.restated is not None:
            return CONDITIONS
        if self.unknown is not None:
            return UNKNOWN
        causes = [part for part in self.explanation.parts if part.name != CALIBRATION]
        if not causes:
            return UNCALIBRATED if self.where and self.explanation.parts else CONSISTENT
        if any(part.is_effect for part in causes):
            return EFFECT
        return PARAMETER if any(part.is_parameter for part in causes) else CONDITIONS

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
    system, rng = load_system(model), np.random.default_rng(seed)
    progress('reading', 0.02)
    groups = split_paths(bags, verify)
    workers = executor or SerialExecutor()
    paths = [path for group in groups for path in group]
    recordings = read_recordings(paths, system, mapping, workers)
    single = len(paths) == 1
    if single:
        recordings, paths = split_in_time(recordings[0], system, paths[0]), 2 * paths
    runs, count = prepare_runs(recordings, system, paths), len(groups[0])
    if single:
        runs[1] = with_unknown_temperature(runs[1])
    progress('localising residuals', 0.06)
    training, held_out = _datasets(system, runs, count, rng)
    windows = windows_of(training, system.hypothesis)
    where, restated = localise(windows), None
    if rms(training.whitened(system.hypothesis)) > DISCREPANT:
        restated = otherwise(system, recordings, runs, paths)
    if restated is not None:
        restated = replace(restated, excess=excess(held_out, system.hypothesis))
        system, runs = restated.system, list(restated.runs)
        training, held_out = _datasets(system, runs, count, rng)
    given = system.hypothesis
    steps = itertools.count(1)

    def report(stage: str) -> None:
        progress(stage, 0.1 + 0.75 * min(next(steps) / SEARCH_STEPS, 1.0))

    candidates, base = pool(system, runs, without)
    search = Search(
        given=given,
        training=training,
        held_out=held_out,
        rng=rng,
        pool=candidates,
        progress=report,
        executor=workers,
        base=base,
    )
    best = search.run()
    progress('testing what is left', 0.85)
    remaining = search.significant()
    unknown = None
    if search.reproduced():
        if search.leaves_something(remaining):
            progress('describing the unknown cause', 0.88)
            unknown = describe_unknown(search, where)
    elif best is None and restated is None:
        where = []
    best = search.best if unknown is None else search.calibrated
    errors = np.zeros((1, 0))
    if best is not None:
        progress('finding the errors of the fitted values', 0.93)
        errors = replicate_errors(best.explanation, given, search.training, rng, workers)
    progress('designing the next experiment', 0.97)
    experiment = next_experiment(rivals(search), training, system)
    return Diagnosis(
        system,
        restated,
        training,
        held_out,
        search,
        windows,
        where,
        best,
        unknown,
        errors,
        experiment,
        seed,
        single,
        time.perf_counter() - begin,
    )


def _datasets(
    system: System, runs: Sequence[Run], count: int, rng: Generator
) -> tuple[Dataset, Dataset]:
    """Return the first runs as training data, and the others as held-out data."""
    training, held_out = (
        Dataset.of(system.hypothesis, [Comparison(run) for run in part], rng)
        for part in (runs[:count], runs[count:])
    )
    return training, held_out
