"""A trial's rig: the second plant under its sensors, carried through the plan into bags."""

import json
from collections.abc import Collection, Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.scenarios.experiments import FIT, NAMES, VERIFY, Experiment, levels, set_up
from pneu_rig_ros.scenarios.hidden import Secret

from .bags import valve_voltages, write_bag
from .circumstances import (
    AS_STATED,
    Circumstances,
    as_it_is,
    command_delay,
    recorded,
    shown,
    stamps,
)
from .constants import HIDDEN
from .files import Files
from .forms import ALL, NUMBERS
from .plant import Motion, Plant, flatten
from .runs import Noise, Run, equations
from .sensors import CALIBRATED, CLASSES, LEVELS, SENSOR_ERRORS, Gains, Readings, distorted, read
from .settings import Settings, changed, model_file, operation, settings

INTERVAL_NS = 1_160_000
INTERVAL = INTERVAL_NS * 1e-9
SHIPPED_CLASSES = {'sensors.position_class': CLASSES[0], 'sensors.pressure_class': CLASSES[1]}
KEPT = 24
"""Motions that are kept, as bags and visibility need the same, and so do trials of a cylinder."""


def truth_of(cylinder: str, secret: Secret) -> Settings:
    """Return the settings of the true rig."""
    return changed(settings(cylinder), secret.truth)


def set_up_for(rig: Settings, cylinder: str, experiment: Experiment) -> Settings:
    """Return a rig's settings in an experiment."""
    return changed(rig, operation(set_up(experiment, cylinder, rig['cylinder']['stroke'])))


def command(experiment: Experiment, cylinder: str) -> Floats:
    """Return u [V] of each sampling interval."""
    pieces = levels(experiment, cylinder)
    return np.concatenate([np.full(round(duration / INTERVAL), u) for duration, u in pieces])


def in_plant(name: str) -> bool:
    """Whether an effect.parameter is of the equations, and not of a sensor."""
    return name in HIDDEN or (name in NUMBERS and bool(ALL[name.split('.')[0]].slot))


def move(
    true: Settings,
    secret: Secret,
    cylinder: str,
    experiment: Experiment,
    circumstances: Circumstances = AS_STATED,
) -> Motion:
    """Return what the true rig does in an experiment."""
    number = (*FIT, *VERIFY).index(experiment)
    prepared = as_it_is(set_up_for(true, cylinder, experiment), circumstances, number)
    hidden = flatten(secret.effects)
    unknown = set(hidden) - set(HIDDEN) - set(SENSOR_ERRORS) - NUMBERS
    assert not unknown, f'cannot be hidden: {unknown}'
    inside = {name: value for name, value in hidden.items() if in_plant(name)}
    return _moved(json.dumps([prepared, inside]), cylinder, experiment)


@lru_cache(maxsize=KEPT)
def _moved(rig: str, cylinder: str, experiment: Experiment) -> Motion:
    """Return the motion of a rig, settings and what is hidden in it being JSON."""
    u = command(experiment, cylinder)
    return Plant(*json.loads(rig)).run(valve_voltages(u), INTERVAL)


def measure(
    motion: Motion,
    true: Settings,
    secret: Secret,
    noise: float,
    seed: int,
    gains: Gains = CALIBRATED,
) -> Readings:
    """Return what the sensors make of a motion."""
    atmosphere = true['gas']['atmospheric_pressure']
    return read(motion, true['sensors'], atmosphere, noise, seed, flatten(secret.effects), gains)


def make_bags(
    folder: Path,
    cylinder: str,
    secret: Secret,
    noise: float,
    seed: int,
    gains: Gains = CALIBRATED,
    without: tuple[str, ...] = (),
    circumstances: Circumstances = AS_STATED,
    names: Collection[str] = NAMES,
) -> Files:
    """
    Record the six experiments of a trial, or some, and write the model file beside them.

    :param folder: must not hold bags yet
    :param noise: multiple of the rig's noise
    :param gains: slopes of the sensors; the model of ones that are wrong tells their class only
    :param without: topics that are not recorded
    :param circumstances: that are not as the bags and the model state
    :param names: of the experiments that are recorded
    """
    true = truth_of(cylinder, secret)
    folder.mkdir(parents=True, exist_ok=True)
    for index, (name, experiment) in enumerate(zip(NAMES, (*FIT, *VERIFY), strict=True)):
        if name not in names:
            continue
        motion = move(true, secret, cylinder, experiment, circumstances)
        readings = measure(motion, true, secret, noise, 100 * seed + index, gains)
        _record(
            folder / name,
            readings,
            true,
            cylinder,
            experiment,
            noise,
            without,
            circumstances,
            100 * seed + index,
        )
    model = folder / 'model.yaml'
    classes = dict(SHIPPED_CLASSES) if gains != CALIBRATED else {}
    given = circumstances.model_of or cylinder
    model.write_text(model_file(given, {**classes, **secret.model}))
    fit, verify = (
        [folder / name for name in group if name in names]
        for group in (NAMES[: len(FIT)], NAMES[len(FIT) :])
    )
    return Files(fit, verify, model)


def _record(
    path: Path,
    readings: Readings,
    true: Settings,
    cylinder: str,
    experiment: Experiment,
    noise: float,
    without: tuple[str, ...],
    circumstances: Circumstances,
    seed: int,
) -> None:
    prepared = set_up_for(true, cylinder, experiment)
    sensors: Mapping[str, Any] = true['sensors']
    variance = (noise * sensors['pressure_noise']) ** 2
    variance += (sensors['pressure_span'] / LEVELS) ** 2 / 12.0
    atmosphere = true['gas']['atmospheric_pressure']
    write_bag(
        path,
        recorded(readings, circumstances, atmosphere),
        command(experiment, cylinder),
        prepared['operation'],
        atmosphere,
        INTERVAL_NS,
        variance,
        without,
        stamps(len(readings.time), INTERVAL_NS, circumstances, seed),
        command_delay(circumstances),
    )


def visibility(
    cylinder: str,
    secret: Secret,
    noise: float,
    circumstances: Circumstances = AS_STATED,
    known: Mapping[str, dict[str, float]] = MappingProxyType({}),
) -> float:
    """
    Return the largest change of a signal by what is hidden, in multiples of its noise.

    Root mean square over all six bags, against the rig as the model describes it, without noise.

    :param known: effects that are part of the description
    """
    true = truth_of(cylinder, secret)
    model = changed(settings(circumstances.model_of or cylinder), secret.model)
    atmosphere = true['gas']['atmospheric_pressure']
    described, plan = Secret(dict(known), {}, {}), (*FIT, *VERIFY)
    squares = np.zeros(3)
    for experiment in plan:
        motion = move(true, secret, cylinder, experiment, circumstances)
        real = distorted(motion, flatten(secret.effects))
        if circumstances != AS_STATED:
            real = shown(real, circumstances, atmosphere)
            real = np.roll(real, round(circumstances.clock / INTERVAL), axis=1)
        expected = distorted(move(model, described, cylinder, experiment), flatten(known))
        squares += np.mean((real - expected) ** 2, axis=1) / len(plan)
    sensors = true['sensors']
    level = noise * np.array([sensors['position_noise'], *[sensors['pressure_noise']] * 2])
    return float(np.max(np.sqrt(squares) / level))


def runs(
    cylinder: str, secret: Secret, noise: float, circumstances: Circumstances = AS_STATED
) -> list[Run]:
    """Return the recordings for the fit as they really were, see :class:`Run`."""
    true, hidden = truth_of(cylinder, secret), flatten(secret.effects)
    given = changed(settings(circumstances.model_of or cylinder), secret.model)
    inside = {name: value for name, value in hidden.items() if in_plant(name)}
    errors = {name: value for name, value in hidden.items() if not in_plant(name)}
    found = []
    for name, experiment in zip(NAMES, FIT, strict=False):
        sides = [set_up_for(rig, cylinder, experiment) for rig in (true, given)]
        sides[0] = as_it_is(sides[0], circumstances, FIT.index(experiment))
        motion = move(true, secret, cylinder, experiment, circumstances)
        voltages = valve_voltages(command(experiment, cylinder))
        found.append(
            Run(
                name,
                INTERVAL,
                motion.states,
                motion.sticking,
                np.vstack([voltages, voltages[-1:]]),
                equations(sides[0], inside),
                equations(sides[1], {}),
                errors,
                noise_of(true['sensors'], noise),
                experiment.rest_time,
            )
        )
    return found


def noise_of(sensors: Mapping[str, float], noise: float) -> Noise:
    """Return what the sensors' noise and their converter make together."""
    rounding = {
        name: sensors[f'{name}_span'] / LEVELS / 12.0**0.5 for name in ('position', 'pressure')
    }
    return Noise(
        *(float(np.hypot(noise * sensors[f'{name}_noise'], rounding[name])) for name in rounding)
    )
