"""The demonstration `pneu-rig gap`: record a rig with a hidden effect, diagnose it, check."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.metrics import (
    AnalysedRun,
    SignalGap,
    analyse_run,
    compare_signals,
    signal_noise,
)
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.executor import open_executor
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import FRICTION_MODELS
from pneu_rig_ros.model.quantity import write_section
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.whole_files import atomic_write
from pneu_rig_ros.report.diagnosis_page import write_files
from pneu_rig_ros.report.improvement_figures import draw_gap
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.sensors import sensor_noise
from pneu_rig_ros.scenarios.experiments import FIT, NAMES, VERIFY, set_up
from pneu_rig_ros.scenarios.hidden import LAWS, Changes, hide, true_parameters
from pneu_rig_ros.scenarios.recording import Run, record

CYLINDER, STRENGTH = 'cylinder_1', 'medium'
DRAWN = (
    'supply_droop',
    'cross_piston_leak',
    'chamber_leak',
    'wall_heat_transfer',
    'valve_lag',
    'line_lag',
    'spool_hysteresis',
    'nonlinear_opening',
    'valve_null_leak',
    'pressure_dependent_friction',
    'direction_dependent_friction',
    'position_dependent_friction',
    'inclination',
    'load_spring',
)
"""Effects that show well above the noise, each apart from the others."""


@dataclass(frozen=True)
class HiddenEffect:
    """
    An effect that the rig has and the model lacks.

    :param effect: its name
    :param parameters: its true parameters, as the library names them [SI]
    :param model: the rig without it
    :param truth: the rig with it
    """

    effect: str
    parameters: dict[str, float]
    model: RigConfiguration
    truth: RigConfiguration

    @property
    def text(self) -> str:
        """The effect's parameters as text, with their units."""
        values = write_section(library.load(self.effect).parameters(**self.parameters))
        return ', '.join(f'{name} {value}' for name, value in values.items())


def draw(seed: int, name: str | None = None) -> HiddenEffect:
    """
    Hide an effect of medium strength in the rig of the demonstration.

    :param seed: of the draw among :data:`DRAWN`
    :param name: of the effect; drawn when not given
    :raises RigError: when there is no such effect
    """
    drawn = str(np.random.default_rng(seed).choice(DRAWN))
    chosen = drawn if name is None else library.cause(name, '--effect')
    shipped = load_configuration(CYLINDER)
    # Errors of gain would be fitted along with what is missing, and hide the weaker effects.
    sensors = shipped.sensors._replace(position_class=0.0, pressure_class=0.0)
    plain = replace(shipped, sensors=sensors)
    friction = plain.model.friction._asdict()
    secret = hide(chosen, CYLINDER, STRENGTH, friction)
    values = true_parameters(chosen, secret, friction)
    truth = changed(plain, secret.truth)
    if chosen not in LAWS:
        truth = replace(truth, effects={chosen: library.load(chosen).parameters(**values)})
    return HiddenEffect(chosen, values, changed(plain, secret.model), truth)


def changed(rig: RigConfiguration, changes: Changes) -> RigConfiguration:
    """Return a rig with section.key replaced."""
    for name, value in changes.items():
        section, key = name.split('.')
        if key == 'model':
            value = FRICTION_MODELS.index(value)
        rig = rig.with_parameter(section, key, tuple(value) if isinstance(value, list) else value)
    return rig


RECORDED, DIAGNOSED, REPEATED = 0.2, 0.85, 0.97
"""Fractions of the work that are done after each step [-]."""
NOISE_SEED = 1000
"""Seed of the sensor noise in the first run; each run has its own."""
LARGEST_SEED = 2**53
"""Seeds are below it."""

Gaps = dict[str, SignalGap]


class Outcome(NamedTuple):
    """
    Result of the demonstration.

    :param answer: diagnosis.json
    :param before: signal -> its gap between the rig and the given model
    :param after: the same with the improved model
    """

    answer: dict[str, Any]
    before: Gaps
    after: Gaps


def close_gap(
    folder: Path, hidden: HiddenEffect, seed: int, progress: Callable[[str, float], None]
) -> Outcome:
    """
    Record the rig, diagnose the bags, record again with the model before and after, draw.

    :param folder: gets all files
    :param progress: callback(stage, fraction)
    :raises RigError: when a node fails
    """
    model = atomic_write(folder / 'model.yaml', hidden.model.to_yaml())
    truth = atomic_write(folder / 'hidden.yaml', hidden.truth.to_yaml())
    measured = [
        Run(experiment, CYLINDER, truth, folder / 'measured' / name, noise_seed(seed, index))
        for index, (name, experiment) in enumerate(zip(NAMES, (*FIT, *VERIFY), strict=True))
    ]
    title = f'recording {len(measured)} runs over ROS 2'
    record(measured, lambda fraction: progress(title, RECORDED * fraction))
    bags = [run.bag for run in measured]
    training, held_out = bags[: len(FIT)], bags[len(FIT) :]

    def diagnosing(stage: str, fraction: float) -> None:
        progress(f'diagnosing - {stage}', RECORDED + (DIAGNOSED - RECORDED) * fraction)

    out = folder / 'answer'
    out.mkdir()
    with open_executor(None) as executor:
        diagnosis = diagnose(
            training, model, held_out, seed=seed, executor=executor, progress=diagnosing
        )
    data = answer(diagnosis)
    write_files(out, diagnosis, data, lambda _: diagnosing('drawing the report', 0.96))
    models = {'before': model, 'after': out / 'improved.yaml'}
    again = [
        Run(VERIFY[0], CYLINDER, rig, folder / name / held_out[0].name, noise_seed(seed, -index))
        for index, (name, rig) in enumerate(models.items(), start=1)
    ]
    title = 'recording again with the model before and after'
    record(again, lambda part: progress(title, DIAGNOSED + (REPEATED - DIAGNOSED) * part))
    progress('drawing', REPEATED)
    runs = held_out[0], *(run.bag for run in again)
    return Outcome(data, *_draw(folder / 'gap.png', runs, model))


def noise_seed(seed: int, run: int) -> int:
    """Return the seed of the sensor noise in a run."""
    return (NOISE_SEED * (seed + 1) + run) % LARGEST_SEED


def _draw(path: Path, bags: Sequence[Path], model: Path) -> tuple[Gaps, Gaps]:
    """Draw the rig, the model before and after; return the gaps of both models."""
    stroke = load_configuration(model).model.cylinder.stroke
    rig = load_configuration(model, **set_up(VERIFY[0], CYLINDER, stroke))
    truth, *models = _analysed(bags, rig)
    interval, balance = truth.recording.interval, ForceBalance.of(rig)
    single = signal_noise(*sensor_noise(rig.sensors), interval, balance)
    # All runs went through the sensors: a difference of two has the noise of both.
    noise = {name: math.sqrt(2.0) * value for name, value in single.items()}
    before, after = (compare_signals(truth.signals, model.signals, noise) for model in models)
    draw_gap(path, truth, models, (before, after))
    return before, after


def _analysed(bags: Sequence[Path], rig: RigConfiguration) -> list[AnalysedRun]:
    """Return the runs in bags as those of a rig, cut to the length of the shortest."""
    recordings = [read_recording(bag) for bag in bags]
    size = min(recording.size for recording in recordings)
    return [
        analyse_run(replace(recording.cut(0, size), configuration=rig)) for recording in recordings
    ]
