"""Recordings to be diagnosed: read, checked, parted into fitted and left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.nuisances import CLOCK_OFFSET, FORCE_OFFSET, INITIAL_TEMPERATURE
from pneu_rig_ros.diagnosis.run import LATEST, Noise, Run, Span
from pneu_rig_ros.diagnosis.system import BALANCES, System, on_bench
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import Operation
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE
from pneu_rig_ros.records.conditions import apply_conditions
from pneu_rig_ros.records.noise import reading_noise
from pneu_rig_ros.records.plausible import check_plausible
from pneu_rig_ros.records.reader import is_bag, read_recording
from pneu_rig_ros.records.recording import PRESSURES, Recording
from pneu_rig_ros.rig.sensors import Sensors, sensor_noise

Floats = NDArray[np.float64]

HELD_OUT = 3
"""One of so many recordings is left out of the fits when none is named for it."""
SATURATED = 0.5
"""Share of a recording that a signal may be at the upper end of its span [-]."""
LEAST_DURATION = 1.0
"""A shorter recording says nothing [s]."""
SLOWEST = 0.02
"""Samples less often than this do not show when a free piston breaks away [s]."""


def split_paths(paths: Sequence[Path], verify: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """
    Return the bags, or tables, to be fitted and those left out.

    :raises RigError: when one does not exist or is given twice, or there are too few
    """
    _check_there([*paths, *verify])
    if verify:
        return list(paths), list(verify)
    if len(paths) < 2:
        raise RigError('one run alone: give another, or one with --verify, to judge the fit by')
    held = list(paths[HELD_OUT - 1 :: HELD_OUT]) or [paths[-1]]
    return [path for path in paths if path not in held], held


def _check_there(paths: Sequence[Path]) -> None:
    """Raise RigError when a path is missing, or two are of one run, which would judge its fit."""
    seen: dict[Path, Path] = {}
    for path in paths:
        if not path.exists():
            raise RigError(f'{path} does not exist; give a bag or a text table')
        place = (path.parent if path.suffix == '.mcap' else path).resolve()
        if place in seen:
            before = '' if str(seen[place]) == str(path) else f', before as {seen[place]}'
            raise RigError(f'{path}: given twice{before}; a run is either fitted or left out')
        seen[place] = path


def read_groups(
    groups: Sequence[Sequence[Path]], system: System, mapping: Path | None
) -> list[list[Run]]:
    """
    Return the runs in groups of bags or text tables, prepared for a system.

    :param mapping: which column of a text table is what, and its unit
    :raises RigError: for what cannot be read, or cannot be of the system
    """
    paths = [path for group in groups for path in group]
    every = iter(read_runs(paths, system, mapping))
    return [[next(every) for _ in group] for group in groups]


def read_runs(paths: Sequence[Path], system: System, mapping: Path | None) -> list[Run]:
    """Return the runs in bags or text tables, prepared for a system; see :func:`read_groups`."""
    bags = [path for path in paths if is_bag(path)]
    if mapping is not None and system.rig is not None and len(bags) == len(paths):
        raise RigError(f'--map {mapping}: is for text tables, and there is none')
    zero = system.hypothesis.model.gas.atmospheric_pressure
    recordings = []
    for path in paths:
        own = is_bag(path) and system.rig is not None
        recordings.append(read_recording(path, None if own else mapping, zero))
    _check_alike(recordings)
    return [prepare_run(one, system, path) for one, path in zip(recordings, paths, strict=True)]


def _check_alike(recordings: Sequence[Recording]) -> None:
    """Raise RigError when recordings are of different cylinders."""
    known = [(one.name, one.configuration.model.cylinder) for one in recordings
             if one.configuration is not None]  # fmt: skip
    for name, cylinder in known[1:]:
        if cylinder != known[0][1]:
            raise RigError(f'{name}: recorded with another cylinder than {known[0][0]}; '
                           'diagnose recordings of one system at a time')  # fmt: skip


def prepare_run(recording: Recording, system: System, path: Path) -> Run:
    """Return a recording, prepared for a system; RigError where it cannot be of it."""
    closed = system.closed(recording)
    balances = frozenset(name for name, missing in closed.items() if not missing)
    if not balances:
        reasons = '; '.join(f'{name} needs {missing}' for name, missing in closed.items())
        raise RigError(f'{path}: nothing can be compared: {reasons}')
    _check_signals(recording, system, balances, path)
    model = system.hypothesis.model
    conditions = dict(recording.conditions)
    zero = conditions.pop('atmospheric_pressure', model.gas.atmospheric_pressure)
    operation: Operation = model.operation._replace(
        **{name: value for name, value in conditions.items() if name in Operation._fields}
    )
    size = recording.size
    pressures = [_signal(recording, system, name, zero, size) for name in PRESSURES]
    deviations = system.each_recording
    run = Run(
        recording.name, recording.interval, _signal(recording, system, 'position', 0.0, size),
        np.column_stack(pressures), _voltages(recording, system), operation, zero,
        model.cylinder.stroke, _noise(recording, system), _span(system.sensors, zero), closed,
        np.array(recording['force']) if on_bench(recording) else None,
        deviations.get(FORCE_OFFSET, 0.0), deviations.get(CLOCK_OFFSET, 0.0),
        deviations.get(INITIAL_TEMPERATURE, 0.0),
    )  # fmt: skip
    return run.with_delay(0.0) if run.clock_offset > 0.0 else run


def _signal(
    recording: Recording, system: System, name: str, unrecorded: float, size: int
) -> Floats:
    if name in recording:
        return np.array(recording[name])
    return np.full(size, system.fixed.get(name, unrecorded))


def _voltages(recording: Recording, system: System) -> Floats:
    if system.shut or not recording.driven:
        return np.full((recording.size - 1, 2), CENTRE_VOLTAGE)
    return np.column_stack([recording.voltage_1, recording.voltage_2])[:-1]


def _noise(recording: Recording, system: System) -> Noise:
    least: dict[str, float] = {}
    if system.sensors is not None:
        position, pressure = sensor_noise(system.sensors)
        least = {'position': position, 'pressure_1': pressure, 'pressure_2': pressure}

    def of(name: str) -> float:
        if name not in recording:
            return 0.0
        if name in least:
            return reading_noise(recording[name], least[name])
        return recording.noise[name]

    return Noise(of('position'), of('pressure_1'), of('pressure_2'), of('force'))


def _span(sensors: Sensors | None, zero: float) -> Span:
    if sensors is None:
        return Span()
    return Span(sensors.position_span, zero, zero + sensors.pressure_span)


def _check_signals(
    recording: Recording, system: System, balances: frozenset[str], path: Path
) -> None:
    """Raise RigError for signals that say nothing, or cannot be of the system."""
    needed = LEAST_DURATION + 2.0 * LATEST * system.each_recording.get(CLOCK_OFFSET, 0.0)
    if recording.duration < needed:
        raise RigError(f'{path}: {recording.duration:.2f} s, at least {needed:g} s needed')
    if recording.interval > SLOWEST and balances == frozenset(BALANCES):
        raise RigError(f'{path}: a sample every {1e3 * recording.interval:g} ms, at most '
                       f'{1e3 * SLOWEST:g} ms allowed to see the piston break away')  # fmt: skip
    for name in ('position', *PRESSURES, 'force'):
        if name in recording:
            _check_varies(recording, name, path)
    if system.rig is not None:
        conditioned = apply_conditions(system.rig, dict(recording.conditions))
        check_plausible(path, recording.signals, conditioned)
        high = {'position': system.rig.sensors.position_span}
        zero = conditioned.model.gas.atmospheric_pressure
        high |= dict.fromkeys(PRESSURES, zero + system.rig.sensors.pressure_span)
        for name, end in high.items():
            _check_span(recording, name, end, path)


def _check_varies(recording: Recording, name: str, path: Path) -> None:
    if np.ptp(recording[name]) == 0.0:
        raise RigError(f'{path}: {name} is {recording[name][0]:g} throughout: is it connected? '
                       'Leave it out, or name it under fixed, if it does not change')  # fmt: skip


def _check_span(recording: Recording, name: str, end: float, path: Path) -> None:
    if name not in recording:
        return
    share = float(np.mean(recording[name] >= end - 2.0 * recording.noise[name]))
    if share > SATURATED:
        raise RigError(f"{path}: {name} is at the end of its sensor's span ({end:g}) for "
                       f'{share:.0%} of the time; record it within the span')  # fmt: skip
