"""Bags to be diagnosed: read, their conditions applied, parted into fitted and left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.records import Record, read_record
from pneu_rig_ros.records.conditions import (
    apply_conditions,
    conditions_beside,
    conditions_of,
)
from pneu_rig_ros.records.plausible import check_plausible, signals_of
from pneu_rig_ros.records.table import is_bag, read_table
from pneu_rig_ros.records.table_record import record_of
from pneu_rig_ros.rig import RigConfiguration

HELD_OUT = 3
"""One of so many bags is left out of the fits when none is named for it."""


def read_experiment(
    path: Path, configuration: RigConfiguration, mapping: Path | None = None
) -> Experiment:
    """
    Return the run in a bag or a text table under its own conditions.

    :param mapping: which column of a text table is what
    """
    record = read_record(path) if is_bag(path) else _read_table(path, mapping)
    conditioned = apply_conditions(configuration, conditions_of(path, record))
    check_plausible(path, signals_of(record), conditioned)
    return Experiment.of(run_name(path), record, conditioned)


def _read_table(path: Path, mapping: Path | None) -> Record:
    known = conditions_beside(path)
    return record_of(read_table(path, mapping, known.get('atmospheric_pressure')), None, known)


def run_name(path: Path) -> str:
    """Return what to call the run in a bag's directory or a file."""
    return path.name if path.is_dir() else path.stem


def check_there(paths: Sequence[Path]) -> None:
    """Raise RigError when a path does not exist."""
    for path in paths:
        if not path.exists():
            raise RigError(f'{path} does not exist; give a bag or a text table')


def check_distinct(paths: Sequence[Path]) -> None:
    """Raise RigError when two paths are of the same run, which then would judge its own fit."""
    seen: dict[Path, Path] = {}
    for path in paths:
        place = (path.parent if path.suffix == '.mcap' else path).resolve()
        if place in seen:
            before = '' if str(seen[place]) == str(path) else f', before as {seen[place]}'
            raise RigError(f'{path}: given twice{before}; a run is either fitted or left out')
        seen[place] = path


def parted(bags: Sequence[Path], verify: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """
    Return the bags, or tables, to be fitted and those left out.

    :raises RigError: when one does not exist or is given twice, or there are too few
    """
    check_there([*bags, *verify])
    check_distinct([*bags, *verify])
    if verify:
        return list(bags), list(verify)
    if len(bags) < 2:
        raise RigError('one run alone: give another, or one with --verify, to judge the fit by')
    held = list(bags[HELD_OUT - 1 :: HELD_OUT]) or [bags[-1]]
    return [bag for bag in bags if bag not in held], held
