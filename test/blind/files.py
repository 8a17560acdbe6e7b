"""Recordings and model file of a system as a laboratory has them: text tables or bags."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from numpy.random import Generator

from .bags import write_signals
from .runs import Run
from .settings import Settings, section_texts
from .system import ATMOSPHERE, PRESSURE, PRESSURE_SPAN, Sensor, System, position_sensor

COLUMNS = {
    'position': ('x', 'mm', 1e-3, 0.0),
    'pressure_1': ('p1', 'bar', 1e5, ATMOSPHERE),
    'pressure_2': ('p2', 'bar', 1e5, ATMOSPHERE),
    'force': ('F', 'N', 1.0, 0.0),
}
"""Signal -> name of its column, unit, size of the unit and zero [SI]."""


class Files(NamedTuple):
    """Where a trial's files are: all that the workflow gets."""

    fit: list[Path]
    verify: list[Path]
    model: Path
    mapping: Path | None = None


def write_files(
    folder: Path, system: System, model: Settings, runs: list[Run], random: Generator
) -> Files:
    """
    Write recordings and model file into a folder that has none.

    :param random: of the sensors' noise
    """
    folder.mkdir(parents=True, exist_ok=True)
    sensors, paths = system.sensors(model), []
    for run in runs:
        read = {
            name: one.read(run.signals[name], random) if one.span else run.signals[name]
            for name, one in sensors.items()
        }
        path = folder / (run.name if system.bag else f'{run.name}.csv')
        if system.bag:
            write_signals(path, read, round(1e9 * run.interval))
        else:
            _write_table(path, read, run.interval)
        paths.append(path)
    file = folder / 'model.yaml'
    file.write_text(yaml.safe_dump(model_of(system, model), sort_keys=False))
    mapping = None if system.bag else _write_mapping(folder / 'mapping.yaml', sensors)
    groups = [[p for p in paths if p.name.startswith(name)] for name in ('fit', 'verify')]
    return Files(groups[0], groups[1], file, mapping)


def model_of(system: System, model: Settings) -> dict[str, Any]:
    """Return the content of a system's model file."""
    sections = section_texts(model, system.keys)
    return {'name': system.name, **sections, **system.more, 'sensors': _sensors_of(system, model)}


def _sensors_of(system: System, model: Settings) -> dict[str, str]:
    """Return the section ``sensors``: calibrated, with their spans and noise."""
    position = system.sensors(model).get('position', position_sensor(model))
    return {
        'kind': 'rig',
        'resolution': '12.0 bit',
        'position_span': f'{position.span!r} m',
        'position_class': '0.0 -',
        'position_noise': f'{position.noise!r} m',
        'pressure_span': f'{PRESSURE_SPAN!r} Pa',
        'pressure_class': '0.0 -',
        'pressure_noise': f'{PRESSURE.noise!r} Pa',
        'velocity_cutoff': '32.0 Hz',
    }


def _write_table(path: Path, signals: Mapping[str, np.ndarray], interval: float) -> None:
    columns = [COLUMNS[name] for name in signals]
    size = len(next(iter(signals.values())))
    cells = [np.arange(size) * interval]
    cells += [
        (signals[name] - zero) / unit
        for name, (_, _, unit, zero) in zip(signals, columns, strict=True)
    ]
    header = ';'.join(['t [s]', *(f'{name} [{unit}]' for name, unit, _, _ in columns)])
    np.savetxt(path, np.stack(cells, axis=1), '%.8g', ';', header=header, comments='')


def _write_mapping(path: Path, signals: Mapping[str, Sensor]) -> Path:
    entries: dict[str, Any] = {'time': {'column': 't [s]', 'unit': 's'}}
    for signal in signals:
        name, unit, _, _ = COLUMNS[signal]
        entries[signal] = {'column': f'{name} [{unit}]', 'unit': unit}
        if signal.startswith('pressure'):
            entries[signal]['gauge'] = True
    entries['atmospheric_pressure'] = f'{ATMOSPHERE!r} Pa'
    path.write_text(yaml.safe_dump({'separator': ';', **entries}, sort_keys=False))
    return path
