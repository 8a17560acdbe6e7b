"""Two runs side by side as one self-contained HTML page."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import jinja2
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.comparison import Comparison
from pneu_rig_ros.analysis.metrics import AnalysedRun
from pneu_rig_ros.analysis.motion import Cycle
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.conditions import CONDITIONS
from pneu_rig_ros.records.description import git_revision
from pneu_rig_ros.report.claims_page import data_address
from pneu_rig_ros.report.comparison_figures import (
    detail,
    draw_cycles,
    draw_differences,
    draw_overlay,
)

DISPLAY = {
    'position': ('mm', 1e3),
    'velocity': ('mm/s', 1e3),
    'pressure_1': ('kPa', 1e-3),
    'pressure_2': ('kPa', 1e-3),
    'friction': ('N', 1.0),
}
"""Signal -> unit for people, units of it in one SI unit."""

FIGURES = 4
"""Most pictures on a page."""


class SignalRow(NamedTuple):
    """One signal's metrics, for people; '-' is not known."""

    signal: str
    unit: str
    rmse: str
    largest: str
    bias: str
    noise: str
    multiple: str


class EventRow(NamedTuple):
    """One number of both runs, for people."""

    what: str
    measured: str
    simulated: str


class Drawn(NamedTuple):
    """A picture with its title and what it shows."""

    title: str
    caption: str
    address: str


def signal_rows(comparison: Comparison) -> list[SignalRow]:
    """Return a row for each signal, in the units of :data:`DISPLAY`."""
    rows = []
    for name, gap in comparison.gaps.items():
        unit, scale = DISPLAY[name]
        rmse, largest, bias = (f'{scale * v:.3g}' for v in (gap.rmse, gap.largest, gap.bias))
        noise = '-' if gap.noise is None else f'{scale * gap.noise:.3g}'
        multiple = '-' if gap.multiple is None else f'{gap.multiple:.1f}'
        signal = name.replace('_', ' ')
        rows.append(SignalRow(signal, unit, rmse, largest, bias, noise, multiple))
    return rows


def event_rows(comparison: Comparison) -> list[EventRow]:
    """Return what happened in both runs, in a few numbers."""
    runs = comparison.measured, comparison.simulated

    def row(what: str, text: Callable[[AnalysedRun], str]) -> EventRow:
        return EventRow(what, text(runs[0]), text(runs[1]))

    return [
        row('stick-slip cycles', lambda run: str(len(run.events.cycles))),
        row('first breakaway', lambda run: _of(run, 'breakaway_time', 's', min)),
        row('median dwell', lambda run: _of(run, 'dwell', 's', _median)),
        row('longest dwell', lambda run: _of(run, 'dwell', 's', max)),
        row('median slip', lambda run: _of(run, 'slip', 'mm', _median, 1e3)),
        row('median peak friction', lambda run: _of(run, 'peak_friction', 'N', _median)),
        row('largest peak friction', lambda run: _of(run, 'peak_friction', 'N', max)),
        row('stroke time', lambda run: _seconds(run.events.stroke_time)),
    ]


def cycle_pairs(comparison: Comparison) -> Iterator[tuple[Cycle | None, Cycle | None]]:
    """Yield the cycles of both runs in their order, None where one has no more."""
    runs = comparison.measured, comparison.simulated
    yield from itertools.zip_longest(*(run.events.cycles for run in runs))


def condition_texts(comparison: Comparison) -> list[str]:
    """Return the conditions, each with where it comes from."""
    return [
        f'{c.name.replace("_", " ")} {c.value:g} {CONDITIONS[c.name].unit}'
        + ('' if c.measured else ' (the model says)')
        for c in comparison.conditions
    ]


def write_page(
    path: Path, comparison: Comparison, progress: Callable[[int], None] = lambda _: None
) -> Path:
    """
    Write the page.

    :param progress: told the number of pictures drawn, of :data:`FIGURES` at most
    :raises RigError: when the file cannot be written
    """
    figures = []
    for number, (title, caption, draw) in enumerate(_figures(comparison), start=1):
        figure = draw()
        if figure is not None:
            figures.append(Drawn(title, caption, data_address(figure)))
        progress(number)
    text = _template().render(
        comparison=comparison,
        signals=signal_rows(comparison),
        events=event_rows(comparison),
        pairs=list(cycle_pairs(comparison)),
        conditions=condition_texts(comparison),
        figures=figures,
        duration=comparison.measured.recording.duration,
        version=version('pneu_rig_ros'),
        revision=git_revision(),
    )
    return atomic_write(path, text)


Picture = tuple[str, str, Callable[[], Figure | None]]
"""Title, caption, what draws it."""


def _figures(comparison: Comparison) -> Iterator[Picture]:
    yield (
        f'Measured and {comparison.second}',
        'Velocity and friction are derived from position and pressures of both by the same '
        'estimators. Triangles mark breakaways.',
        lambda: draw_overlay(comparison),
    )
    span = detail(comparison)
    if span is not None:
        yield (
            'The first cycles',
            'The same, over the first measured stick-slip cycles.',
            lambda: draw_overlay(comparison, span),
        )
    band = 'The grey band is twice the standard deviation of the sensor noise.'
    yield (
        'Differences',
        f'{comparison.second.capitalize()} less measured. {band if comparison.noise else ""}',
        lambda: draw_differences(comparison),
    )
    yield (
        'Stick-slip cycles',
        'Each cycle at its breakaway: the dwell before it, the distance slipped, the friction '
        'peak.',
        lambda: draw_cycles(comparison),
    )


def _of(
    run: AnalysedRun,
    name: str,
    unit: str,
    take: Callable[[list[float]], float],
    scale: float = 1.0,
) -> str:
    values = [scale * getattr(cycle, name) for cycle in run.events.cycles]
    known = [value for value in values if value == value]
    return f'{take(known):.3g} {unit}' if known else '-'


def _median(values: list[float]) -> float:
    return sorted(values)[len(values) // 2]


def _seconds(time: float | None) -> str:
    return 'not reached' if time is None else f'{time:.2f} s'


def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader('pneu_rig_ros', 'report'),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template('comparison_page.html')
