"""The systems other than a whole rig, and what the trials need of them."""

from pathlib import Path

import numpy as np

from pneu_rig_ros.scenarios.hidden import Secret

from .bench import BENCH
from .block import BLOCK
from .files import Files, write_files
from .plant import flatten
from .runs import Run
from .sealed import SEALED, VESSEL
from .settings import Settings, changed
from .system import FIT, System, stream

SYSTEMS = {one.name: one for one in (SEALED, VESSEL, BENCH, BLOCK)}
SIZES, MOVES, NOISE = range(3)
"""Streams of random numbers of a trial."""


def sizes(system: System, key: str) -> Settings:
    """Return the settings of the model of a trial."""
    return system.sizes(stream(key, SIZES))


def runs(system: System, key: str, secret: Secret) -> list[Run]:
    """Return the recordings of a trial as they really were, those of the fit first."""
    model = sizes(system, key)
    true = changed(model, secret.truth)
    given = changed(model, secret.model)
    return system.runs(true, given, flatten(secret.effects), stream(key, MOVES))


def make_files(folder: Path, system: System, key: str, secret: Secret) -> Files:
    """Record a trial into a folder."""
    return write_runs(folder, system, key, secret, runs(system, key, secret))


def write_runs(folder: Path, system: System, key: str, secret: Secret, real: list[Run]) -> Files:
    """Write what the sensors show of the recordings of a trial into a folder."""
    given = changed(sizes(system, key), secret.model)
    return write_files(folder, system, given, real, stream(key, NOISE))


def fitted(system: System, key: str, secret: Secret) -> list[Run]:
    """Return the recordings for the fit."""
    return runs(system, key, secret)[:FIT]


def visibility(system: System, key: str, secret: Secret) -> float:
    """
    Return the largest change of a signal by what is hidden, in multiples of its noise.

    Root mean square over all recordings, against the model under the same motions, without noise.
    """
    real = runs(system, key, secret)
    model = changed(sizes(system, key), secret.model)
    expected = system.runs(model, model, {}, stream(key, MOVES))
    levels = []
    for name, sensor in system.sensors(model).items():
        gaps = [
            np.mean((a.signals[name] - b.signals[name]) ** 2)
            for a, b in zip(real, expected, strict=True)
        ]
        levels.append(float(np.sqrt(np.mean(gaps))) / sensor.noise if sensor.span else 0.0)
    return max(levels)
