"""Recordings for a diagnosis: read, checked, split into training and held-out data."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pneu_rig_ros.diagnosis.inputs.prepare_runs import (
    lacks,
    on_bench,
    prepare_runs,
    with_unknown_temperature,
)
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.inputs.vessels import changes_until, from_shutting, is_empty, with_note
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks
from pneu_rig_ros.records import is_bag, read_recording
from pneu_rig_ros.records.conditions import CONDITIONS
from pneu_rig_ros.records.recording import PRESSURES, Recording

HELD_OUT = 3
"""Every third recording is held out when none is named for it."""
MACHINE = ('cylinder', 'valve')
"""Sections of a recording's configuration that are alike in all recordings of a system."""
ROUNDING = 1e-8
"""By how much the samples of one measurement may differ, as texts of nine digits do [-]."""


@dataclass(frozen=True)
class Inputs:
    """
    What a diagnosis is made of.

    :param paths: of the recordings, training data first
    :param recordings: as they were read
    :param runs: the recordings, prepared for the system
    :param count: number of those that are training data
    :param single: whether they are parts of one recording
    """

    system: System
    paths: Sequence[Path]
    recordings: Sequence[Recording]
    runs: Sequence[Run]
    count: int
    single: bool


def read_inputs(
    bags: Sequence[Path],
    verify: Sequence[Path],
    system: System,
    mapping: Path | None,
    executor: Executor,
) -> Inputs:
    """Return the recordings of a system, prepared; see ``diagnose``."""
    training, held_out = split_paths(bags, verify)
    paths = [*training, *held_out]
    recordings = read_recordings(paths, system, mapping, executor)
    if system.constant_volume:
        read = dict(zip(paths, recordings, strict=True))
        usual = system.hypothesis.model.gas.atmospheric_pressure
        training, held_out, recordings = _of_vessels(training, held_out, read, usual)
        paths = [*training, *held_out]
    single = len(paths) == 1
    if single:
        recordings, paths = split_in_time(recordings[0], system, paths[0]), 2 * paths
    runs = prepare_runs(recordings, system, paths)
    if single:
        runs[1] = with_unknown_temperature(runs[1])
    else:
        _check_different(recordings, paths)
    return Inputs(system, paths, recordings, runs, len(training), single)


def _of_vessels(
    training: list[Path], held_out: list[Path], recordings: Mapping[Path, Recording], usual: float
) -> tuple[list[Path], list[Path], list[Recording]]:
    """
    Return the paths of training and of held-out data, and the recordings while vessels are shut.

    If all held-out ones are of empty vessels, which show no law, others are in their place.

    :param usual: pressure of the atmosphere where a recording states none [Pa]
    """
    shut = {path: from_shutting(recording) for path, recording in recordings.items()}
    if held_out and all(is_empty(shut[path], shut.values(), usual) for path in held_out):
        names = ', '.join(shut[path].name for path in held_out)
        note = f'not used, as the vessel is empty: {names}'
        shut[training[0]] = with_note(shut[training[0]], note)
        training, held_out = split_paths(training)
    return training, held_out, [shut[path] for path in (*training, *held_out)]


def split_paths(
    paths: Sequence[Path], verify: Sequence[Path] = ()
) -> tuple[list[Path], list[Path]]:
    """
    Return the bags, or tables, of training data and those of held-out data.

    Of a single recording there are none: see :func:`split_in_time`.

    :raises RigError: when one does not exist or is given twice
    """
    seen: dict[Path, Path] = {}
    for path in (*paths, *verify):
        if not path.exists():
            raise RigError(f'{path} does not exist; give a bag or a text table')
        # a file and its directory are one run, which would validate its own fit
        place = (path.parent if path.suffix == '.mcap' else path).resolve()
        if place in seen:
            before = '' if str(seen[place]) == str(path) else f', before as {seen[place]}'
            raise RigError(
                f'{path}: given twice{before}; a recording is either training data or held-out '
                'data'
            )
        seen[place] = path
    if verify or len(paths) < 2:
        return list(paths), list(verify)
    held_out = list(paths[HELD_OUT - 1 :: HELD_OUT]) or [paths[-1]]
    return [path for path in paths if path not in held_out], held_out


def read_recordings(
    paths: Sequence[Path],
    system: System,
    mapping: Path | None,
    executor: Executor | None = None,
) -> list[Recording]:
    """
    Return the recordings in bags or text tables.

    :param mapping: file that maps the columns of a text table to signals with units
    :param executor: where they are read; this process if omitted
    :raises RigError: for a recording that cannot be read, or recordings of several systems
    """
    bags = [path for path in paths if is_bag(path)]
    if mapping is not None and system.rig is not None and len(bags) == len(paths):
        raise RigError(f'--map {mapping}: is for text tables, and there is none')
    zero = system.hypothesis.model.gas.atmospheric_pressure
    own = set(bags if system.rig is not None else ())
    tasks = [(path, None if path in own else mapping) for path in paths]
    recordings = map_tasks(executor or SerialExecutor(), _read, tasks, zero)
    _check_same_machine(recordings)
    return recordings


def split_in_time(recording: Recording, system: System, path: Path) -> list[Recording]:
    """
    Return the earlier part of a recording and its last third, which is held out.

    :raises RigError: for a free piston: what its seal remembers is not known where it is cut
    """
    missing = lacks(system, recording)
    if not missing['force'] and not on_bench(recording):
        raise RigError(
            f'{path}: only one recording of a free piston given; add another, or a held-out one '
            'with --verify'
        )
    size = recording.size
    if system.constant_volume:  # once a vessel is empty it shows nothing
        size = changes_until(recording)
    cut = size - size // HELD_OUT
    at, end = cut * recording.interval, recording.duration
    first, later = recording.cut(0, cut), recording.cut(cut, recording.size)
    return [
        replace(first, name=f'{recording.name}, 0 to {at:.1f} s'),
        replace(later, name=f'{recording.name}, {at:.1f} to {end:.1f} s'),
    ]


def _check_same_machine(recordings: Sequence[Recording]) -> None:
    """Raise RigError for recordings that say they are of different machines."""
    models = [(r.name, r.configuration.model) for r in recordings if r.configuration is not None]
    for name, model in models[1:]:
        first, of_first = models[0]
        for part in MACHINE:
            if getattr(model, part) != getattr(of_first, part):
                raise RigError(
                    f'{name}: recorded with another {part} than {first}; '
                    'diagnose recordings of one system at a time'
                )


def _check_different(recordings: Sequence[Recording], paths: Sequence[Path]) -> None:
    """Raise RigError for recordings of the same measurement, whatever their conditions."""
    pairs = itertools.combinations(zip(recordings, paths, strict=True), 2)
    for (one, first), (other, second) in pairs:
        if not _same_samples(one, other):
            continue
        if contradictions := _contradictions(one, other):
            raise RigError(
                f'{first} and {second}: the same samples under different conditions '
                f'({contradictions}); omit the one with the wrong conditions'
            )
        raise RigError(f'{second}: the same samples as in {first}; give each recording once')


def _same_samples(one: Recording, other: Recording) -> bool:
    """Return whether all signals are the same, gauge pressures from whatever zero."""
    size, shift = min(one.size, other.size), 0.0
    if one.atmospheric_pressure is not None and other.atmospheric_pressure is not None:
        shift = one.atmospheric_pressure - other.atmospheric_pressure

    def alike(name: str) -> bool:
        moved = other[name][:size] + (shift if name in PRESSURES else 0.0)
        return np.allclose(one[name][:size], moved, rtol=ROUNDING, atol=0.0)

    both = [name for name in ('position', *PRESSURES, 'force') if name in one and name in other]
    return one.interval_ns == other.interval_ns and bool(both) and all(map(alike, both))


def _contradictions(one: Recording, other: Recording) -> str:
    """Return the conditions of which two recordings state different values, '' for none."""
    stated = [(name, one.conditions.get(name), other.conditions.get(name)) for name in CONDITIONS]
    return ', '.join(
        f'{name} {a:g} and {b:g} {CONDITIONS[name].unit}'
        for name, a, b in stated
        if a is not None and b is not None and a != b
    )


def _read(task: tuple[Path, Path | None], zero: float) -> Recording:
    path, mapping = task
    return read_recording(path, mapping, zero)
