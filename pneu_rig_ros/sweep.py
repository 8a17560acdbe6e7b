"""Strokes over a grid of conditions and parameters: what is varied, simulated and summarised."""

import csv
import io
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.batch import at_end, strokes
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.model.quantity import Choice, Quantity, specifications, unknown
from pneu_rig_ros.model.shape import with_values
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.configuration import OVERRIDES, override
from pneu_rig_ros.rig.valve_drive import valve_voltages

COMMAND = Quantity('V', -2.5, 2.5, 'command of Eq. 1')
MOST_POINTS = 1_000_000
"""Points of a grid at most."""


@dataclass(frozen=True)
class Axis:
    """
    One thing that is varied.

    :param name: ``u``, a condition of the run, ``section.key`` or ``effect.parameter``
    :param specification: its unit and range, or the names of its choices
    :param values: SI units, or the index of a choice
    """

    name: str
    specification: Quantity | Choice
    values: tuple[float, ...]

    @property
    def unit(self) -> str:
        """SI unit; '-' for a pure number or a choice."""
        return self.specification.unit if isinstance(self.specification, Quantity) else '-'

    def shown(self, value: float) -> float | str:
        """Return a value as tables have it: the name of a choice, else the number."""
        if isinstance(self.specification, Choice):
            return self.specification.format(int(value))
        return value


def axis(name: str, text: str) -> Axis:
    """
    Return the axis of a name and of values such as ``0.3``, ``0.3,0.4`` or ``0.2:0.4:21``.

    :raises RigError: for an unknown name, or values that are not numbers or out of range
    """
    specification = _specification(name)
    values: list[float]
    if isinstance(specification, Choice):
        values = [specification.parse(part, name) for part in text.split(',')]
    else:
        values = [specification.check(number, name) for number in _numbers(text, name)]
    return Axis(name, specification, tuple(values))


def _specification(name: str) -> Quantity | Choice:
    section, _, key = name.rpartition('.')
    if not section:
        allowed = {'u': COMMAND, **OVERRIDES}
        if name not in allowed:
            raise RigError(f'{unknown(name, allowed)}, section.key or effect.parameter')
        return allowed[name]
    groups = (*SECTIONS, *library.names())
    if section not in groups:
        raise RigError(f'{name}: {unknown(section, groups)}')
    owner = SECTIONS[section] if section in SECTIONS else library.load(section).parameters
    known = {
        key: one
        for key, one in specifications(owner).items()
        if isinstance(one, Quantity | Choice)
    }
    if key not in known:
        raise RigError(f'{section}: {unknown(key, known)}')
    return known[key]


def _numbers(text: str, name: str) -> list[float]:
    try:
        if ':' not in text:
            return [float(part) for part in text.split(',')]
        low, high, count = text.split(':')
        if int(count) < 2:
            raise ValueError
        return [float(value) for value in np.linspace(float(low), float(high), int(count))]
    except ValueError:
        raise RigError(f'{name} {text}: expected a number, A,B,... or LOW:HIGH:COUNT') from None


def check_size(axes: Sequence[Axis]) -> int:
    """Return the number of points; RigError when a name is given twice or there are too many."""
    names = [one.name for one in axes]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise RigError(f'{twice[0]} is varied twice')
    size = math.prod(len(one.values) for one in axes)
    if size > MOST_POINTS:
        raise RigError(f'{size} points; at most {MOST_POINTS}')
    return size


def at_point(
    configuration: RigConfiguration, names: Sequence[str], point: Sequence[float]
) -> RigConfiguration:
    """
    Return the rig at a point of the grid; a command is no part of it.

    :param names: of the axes
    :param point: their values
    :raises RigError: when values contradict each other
    """
    conditions = {}
    for name, value in zip(names, point, strict=True):
        section, _, key = name.rpartition('.')
        if section in SECTIONS:
            configuration = configuration.with_parameter(section, key, value)
        elif section:
            own = configuration.effects.get(section, library.load(section).null)
            changed = {**configuration.effects, section: with_values(own, {key: value})}
            configuration = replace(configuration, effects=changed)
        elif name != 'u':
            conditions[name] = value
    return override(configuration, conditions)


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
    :raises RigError: when ``u`` is missing, or values of a point contradict each other
    """
    points, names = grid(axes), tuple(one.name for one in axes)
    if 'u' not in names:
        raise RigError('sweep: the command u is missing; give it as an axis')
    blocks = [points[i : i + BLOCK] for i in range(0, len(points), BLOCK)]
    done = map_tasks(
        executor,
        measure,
        blocks,
        configuration,
        names,
        longest,
        progress=lambda number: progress(min(number * BLOCK, len(points))),
    )
    return [measures for block in done for measures in block]


def measure(
    points: Sequence[Point], configuration: RigConfiguration, names: Sequence[str], longest: float
) -> list[Measures]:
    """Return the summaries of the strokes at some points of the grid; see :func:`sweep`."""
    rigs = [at_point(configuration, names, point) for point in points]
    plants = [Plant(rig.model, rig.effects) for rig in rigs]
    u = names.index('u')
    voltages = np.array([valve_voltages(point[u]) for point in points])
    interval = configuration.interval_ns * 1e-9
    runs = strokes(plants, voltages, interval, longest)
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
