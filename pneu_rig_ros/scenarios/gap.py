"""
The demonstration `pneu-rig gap`: record a rig with a hidden effect, diagnose it, check.

Runs are recorded over ROS 2, several at a time: each in a process of plant, excitation, valve
command, friction estimator and recorder in a DDS domain of its own, in lock step: as fast as the
machine allows, and the same every time.
"""

import math
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.metrics import SignalGap, analyse_run, compare_signals, signal_noise
from pneu_rig_ros.demo import NodeProcess, Value, held_signals
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.executor import open_executor
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import FRICTION_MODELS
from pneu_rig_ros.model.quantity import LARGEST_INTEGER, write_section
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.conditions import FILE_NAME, format_conditions
from pneu_rig_ros.report.diagnosis_page import write_files
from pneu_rig_ros.report.improvement_figures import draw_gap
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.sensors import sensor_noise
from pneu_rig_ros.scenarios.experiments import (
    FIT,
    NAMES,
    VERIFY,
    Experiment,
    levels,
    profile,
    set_up,
)
from pneu_rig_ros.scenarios.hidden import LAWS, Changes, hide, true_parameters

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
    An effect in a rig.

    :param parameters: of the effect, in terms of the library [SI]
    :param model: the rig without it, which the diagnosis is given
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


BYTES_PER_SECOND = 5.9e5
"""How fast a bag grows [byte per simulated second], from which progress is estimated."""
DOMAINS = 50
"""Domains that are used: 1 to this one; higher ones take ports that others may have."""
WATCH = 0.1
"""Time between two looks at the processes [s]."""


class Run(NamedTuple):
    """
    A run to be recorded.

    :param rig: file of the rig
    :param bag: that is created
    :param seed: of the noise of the sensors
    """

    experiment: Experiment
    rig: Path
    bag: Path
    seed: int

    def set_up(self) -> dict[str, float]:
        """Return the parameters of the plant that make the run's conditions [SI]."""
        stroke = load_configuration(self.rig).model.cylinder.stroke
        return set_up(self.experiment, CYLINDER, stroke)


def record(runs: Sequence[Run], progress: Callable[[float], None]) -> None:
    """
    Record runs side by side; in any case, no node is left running.

    :param progress: callback(fraction)
    :raises RigError: when a node fails
    """
    progress(0.0)
    for rig in dict.fromkeys(run.rig for run in runs):
        Rig(load_configuration(rig)).warm_up()  # else each node would compile the plant
    times = [t for run in runs for t, _ in levels(run.experiment, CYLINDER)]
    nodes: list[NodeProcess] = []
    with tempfile.TemporaryDirectory(prefix='pneu_rig_') as folder:
        try:
            for index, run in enumerate(runs):
                nodes.append(_start(run, index, Path(folder)))
            while [node for node in nodes if not node.done()]:  # done() raises if a node failed
                files = (file for run in runs for file in run.bag.glob('*.mcap'))
                size = sum(file.stat().st_size for file in files)
                progress(min(size / (BYTES_PER_SECOND * sum(times)), 1.0))
                time.sleep(WATCH)
        finally:
            with held_signals():
                for node in nodes:
                    node.stop()
    for run in runs:
        known = run.set_up()
        del known['initial_position']
        known['atmospheric_pressure'] = load_configuration(run.rig).model.gas.atmospheric_pressure
        atomic_write(run.bag / FILE_NAME, format_conditions(known))


def _start(run: Run, index: int, folder: Path) -> NodeProcess:
    shape = profile(run.experiment, CYLINDER)
    written = atomic_write(folder / f'{index}.yaml', yaml.safe_dump(shape, sort_keys=False))
    parameters: dict[str, Value] = {
        'use_sim_time': True,
        'plant:speed': 0.0,
        'plant:cylinder': str(run.rig.resolve()),
        'plant:seed': run.seed,
        'excitation:profile': str(written),
        'valve_command:command_timeout': 0.0,
        'recorder:output': str(run.bag.resolve()),
        **{f'plant:{name}': value for name, value in run.set_up().items()},
    }
    # Demonstrations that run at the same time must not share a domain.
    domain = {'ROS_DOMAIN_ID': str(1 + (16 * os.getpid() + index) % DOMAINS)}
    return NodeProcess('rig_with_excitation', parameters, folder / f'{index}.log', domain)


RECORDED, DIAGNOSED, REPEATED = 0.2, 0.85, 0.97
"""Fractions of the work that are done after each step [-]."""
NOISE_SEED = 1000
"""Seed of the sensor noise in the first run; each run has its own."""

Gaps = dict[str, SignalGap]


class Outcome(NamedTuple):
    """
    What comes out.

    :param answer: content of diagnosis.json
    :param before, after: signal -> its gap with the given and with the improved model
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
        Run(experiment, truth, folder / 'measured' / name, noise_seed(seed, index))
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
        Run(VERIFY[0], rig, folder / name / held_out[0].name, noise_seed(seed, -index))
        for index, (name, rig) in enumerate(models.items(), start=1)
    ]
    title = 'recording again with the model before and after'
    record(again, lambda part: progress(title, DIAGNOSED + (REPEATED - DIAGNOSED) * part))
    progress('drawing', REPEATED)
    return Outcome(data, *_draw(folder / 'gap.png', held_out[0], again))


def noise_seed(seed: int, run: int) -> int:
    """Return the seed of the sensor noise in a run."""
    return (NOISE_SEED * (seed + 1) + run) % LARGEST_INTEGER


def _draw(path: Path, bag: Path, again: Sequence[Run]) -> tuple[Gaps, Gaps]:
    """Draw the rig, the model before and after; return the gaps of both models."""
    rig = load_configuration(again[0].rig, **again[0].set_up())
    recordings = [read_recording(each) for each in (bag, *(run.bag for run in again))]
    size = min(recording.size for recording in recordings)
    cut = [replace(recording.cut(0, size), configuration=rig) for recording in recordings]
    truth, *models = map(analyse_run, cut)
    interval, balance = truth.recording.interval, ForceBalance.of(rig)
    single = signal_noise(*sensor_noise(rig.sensors), interval, balance)
    # All runs went through the sensors: a difference of two has the noise of both.
    noise = {name: math.sqrt(2.0) * value for name, value in single.items()}
    before, after = (compare_signals(truth.signals, model.signals, noise) for model in models)
    draw_gap(path, truth, models, (before, after))
    return before, after
