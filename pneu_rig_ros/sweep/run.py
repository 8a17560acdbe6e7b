"""The strokes of a grid: simulated block by block and summarised."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.batch.strokes import at_end, strokes
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.valve_drive import valve_voltages
from pneu_rig_ros.sweep.axes import Axis, at_point

BLOCK = 16
"""Strokes of a task, which run together: some for each processor, in 30 MB."""

Point = tuple[float, ...]


class Measures(NamedTuple):
    """
    Summary of a stroke; NaN where there is nothing to measure.

    :param stroke_time: time to the end of the stroke [s], NaN if it is not reached
    :param travel: [m]
    :param cycles: number of stick-slip cycles
    :param first_dwell, mean_dwell, longest_dwell: length of the sticks [s]
    :param mean_slip: [m]
    :param peak_friction: largest of all cycles [N]
    """

    stroke_time: float
    travel: float
    cycles: int
    first_dwell: float
    mean_dwell: float
    longest_dwell: float
    mean_slip: float
    peak_friction: float


UNITS = dict(zip(Measures._fields, ('s', 'm', '-', 's', 's', 's', 'm', 'N'), strict=True))
"""Measure -> its unit."""


class Setting(NamedTuple):
    """
    What the strokes of a sweep share.

    :param configuration: the rig
    :param names: of what is varied
    :param longest: a stroke is given up after this time [s]
    """

    configuration: RigConfiguration
    names: tuple[str, ...]
    longest: float


def grid(axes: Sequence[Axis]) -> list[Point]:
    """Return all points; the last axis changes fastest."""
    return list(itertools.product(*(one.values for one in axes)))


def sweep(
    configuration: RigConfiguration,
    axes: Sequence[Axis],
    longest: float,
    executor: Executor,
    progress: Callable[[int], None] = lambda _: None,
) -> list[Measures]:
    """
    Return the summary of the stroke at each point of the grid.

    :param axes: the command ``u`` is one of them
    :param longest: a stroke is given up after this time [s]
    :param executor: where strokes are simulated
    :param progress: called with the number of completed strokes
    :raises RigError: when values of a point contradict each other
    """
    points = grid(axes)
    setting = Setting(configuration, tuple(one.name for one in axes), longest)
    blocks = [points[i : i + BLOCK] for i in range(0, len(points), BLOCK)]
    done = map_tasks(
        executor,
        measure,
        blocks,
        setting,
        progress=lambda number: progress(min(number * BLOCK, len(points))),
    )
    return [measures for block in done for measures in block]


def measure(points: Sequence[Point], setting: Setting) -> list[Measures]:
    """Return the summaries of the strokes at some points."""
    rigs = [at_point(setting.configuration, setting.names, point) for point in points]
    plants = [Plant(rig.model, rig.effects) for rig in rigs]
    u = setting.names.index('u')
    voltages = np.array([valve_voltages(point[u]) for point in points])
    interval = setting.configuration.interval_ns * 1e-9
    runs = strokes(plants, voltages, interval, setting.longest)
    return [
        summary(run, interval, bool(at_end(plant, held, run)[-1]), plant)
        for plant, held, run in zip(plants, voltages, runs, strict=True)
    ]


def summary(run: Trajectory, interval: float, finished: bool, plant: Plant) -> Measures:
    """Return the summary of a stroke."""
    cycles = find_cycles(run.position, interval, run.friction_force)
    dwells = np.array([cycle.dwell for cycle in cycles] or [np.nan])
    start = plant.model.operation.initial_position
    return Measures(
        stroke_time=float(run.time[-1]) if finished else np.nan,
        travel=abs(float(run.position[-1]) - start),
        cycles=len(cycles),
        first_dwell=float(dwells[0]),
        mean_dwell=float(dwells.mean()),
        longest_dwell=float(dwells.max()),
        mean_slip=float(np.mean([cycle.slip for cycle in cycles])) if cycles else np.nan,
        peak_friction=max((cycle.peak_friction for cycle in cycles), default=np.nan),
    )


def units(axes: Sequence[Axis]) -> dict[str, str]:
    """Return column of a table of strokes -> its unit."""
    return {axis.name: axis.unit for axis in axes} | UNITS


def rows(axes: Sequence[Axis], measures: Sequence[Measures]) -> list[dict[str, float | str]]:
    """Return a row for each stroke of `sweep`: what is varied, and what was measured."""
    return [
        {axis.name: axis.shown(value) for axis, value in zip(axes, point, strict=True)}
        | row._asdict()
        for point, row in zip(grid(axes), measures, strict=True)
    ]


def to_csv(columns: Mapping[str, str], table: Sequence[Mapping[str, float | str]]) -> str:
    """
    Return a table as CSV text, with names such as 'stroke_time_s' and empty cells for NaN.

    :param columns: name -> unit
    :param table: rows
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(
        name if unit == '-' else f'{name}_{unit.replace("/", "_per_")}'
        for name, unit in columns.items()
    )
    for row in table:
        writer.writerow('' if value != value else value for value in row.values())
    return text.getvalue()
