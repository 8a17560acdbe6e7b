"""One small diagnosis that the tests of the report share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.workflow import Diagnosis, diagnose

SYSTEM = """
name: seal
cylinder: {cap_area: 5e-4 m^2, rod_area: 5e-4 m^2, stroke: 0.1 m}
friction: {model: coulomb_viscous, coulomb_force: 6.0 N, element_stiffness: [5e4 N/m]}
fixed: {pressure_1: 1e5 Pa}
each_recording: [force_offset]
"""
MAPPING = """
time: {column: time, unit: s}
position: {column: position, unit: m}
pressure_2: {column: pressure_2, unit: Pa}
force: {column: force, unit: N}
"""
GAUGES = (1e5, 4e5, 2.5e5)
"""Pressure beneath the seal in each recording [Pa]."""
WRONG = ((), (250, 820), ())
"""Samples of each recording at which the reading of the position is wrong."""
SLOPE = 1e-5
"""Growth of the friction with it [N/Pa]."""


def bench_table(path: Path, gauge: float, wrong: Sequence[int], rng: np.random.Generator) -> Path:
    """Return 12 s of a seal that is driven to and fro, by the law of Dahl, as a text table."""
    time = np.arange(0.0, 12.0, 0.01)
    phase = (time / 6.0) % 1.0
    position = 0.03 + 0.06 * np.where(phase < 0.5, phase, 1.0 - phase)
    friction = rubbed(position, 6.0 + SLOPE * gauge)
    read = position + rng.normal(0.0, 1e-5, time.size)
    read[list(wrong)] += 4e-4
    columns = [
        time,
        read,
        1e5 + gauge + rng.normal(0.0, 150.0, time.size),
        friction + 5e-4 * gauge + 2.0 + rng.normal(0.0, 0.05, time.size),
    ]
    np.savetxt(
        path,
        np.column_stack(columns),
        '%.9g',
        ',',
        header='time,position,pressure_2,force',
        comments='',
    )
    return path


def rubbed(position: NDArray[np.float64], level: float) -> NDArray[np.float64]:
    """Return the friction force along a motion [N]."""
    friction = np.zeros(position.size)
    for index, step in enumerate(np.diff(position), start=1):
        end = np.sign(step) * level
        friction[index] = end + (friction[index - 1] - end) * np.exp(-5e4 / level * abs(step))
    return friction


@dataclass(frozen=True)
class Bench:
    """Files of a seal on a bench that rubs more under pressure than its model."""

    tables: list[Path]
    system: Path
    mapping: Path


@pytest.fixture(scope='session')
def bench_files(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    folder = tmp_path_factory.mktemp('bench')
    rng = np.random.default_rng(0)
    tables = [
        bench_table(folder / f'run_{i}.csv', gauge, wrong, rng)
        for i, (gauge, wrong) in enumerate(zip(GAUGES, WRONG, strict=True))
    ]
    system, mapping = folder / 'seal.yaml', folder / 'map.yaml'
    system.write_text(SYSTEM)
    mapping.write_text(MAPPING)
    return Bench(tables, system, mapping)


@pytest.fixture(scope='session')
def bench(bench_files: Bench) -> Diagnosis:
    """Return the diagnosis of the seal, the last recording left out."""
    tables = bench_files.tables
    return diagnose(tables[:2], bench_files.system, tables[2:], mapping=bench_files.mapping)
