"""Two runs side by side as one self-contained HTML page."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from pneu_rig_ros.analysis.comparison import SIMULATED, Comparison
from pneu_rig_ros.analysis.metrics import AnalysedRun
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.conditions import CONDITIONS
from pneu_rig_ros.report.comparison_figures import (
    detail,
    draw_cycles,
    draw_differences,
    draw_overlay,
)
from pneu_rig_ros.report.figure import SIGNALS, plain_name
from pneu_rig_ros.report.page import Picture, data_address, render

FIGURES = 4
"""Most figures on a page."""


class SignalRow(NamedTuple):
    """The metrics of one signal as text; '-' is not known."""

    signal: str
    unit: str
    rmse: str
    largest: str
    bias: str
    noise: str
    multiple: str


class EventRow(NamedTuple):
    """One number of both runs as text."""

    what: str
    measured: str
    simulated: str


def signal_rows(comparison: Comparison) -> list[SignalRow]:
    """Return a row for each signal, in its display unit for differences."""
    rows = []
    for name, gap in comparison.gaps.items():
        scale = SIGNALS[name].difference_scale
        rmse, largest, bias = (f'{scale * v:.3g}' for v in (gap.rmse, gap.largest, gap.bias))
        noise = '-' if gap.noise is None else f'{scale * gap.noise:.3g}'
        multiple = '-' if gap.multiple is None else f'{gap.multiple:.1f}'
        unit = SIGNALS[name].difference_unit
        rows.append(SignalRow(plain_name(name), unit, rmse, largest, bias, noise, multiple))
    return rows


def event_rows(comparison: Comparison) -> list[EventRow]:
    """Return the events of both runs in a few numbers."""
    median: Statistic = statistics.median_high
    texts: dict[str, Callable[[AnalysedRun], str]] = {
        'stick-slip cycles': lambda run: str(len(run.events.cycles)),
        'first breakaway': partial(_of_cycles, name='breakaway_time', unit='s', statistic=min),
        'median dwell': partial(_of_cycles, name='dwell', unit='s', statistic=median),
        'longest dwell': partial(_of_cycles, name='dwell', unit='s', statistic=max),
        'median slip': partial(_of_cycles, name='slip', unit='mm', statistic=median),
        'median peak friction': partial(
            _of_cycles, name='peak_friction', unit='N', statistic=median
        ),
        'largest peak friction': partial(
            _of_cycles, name='peak_friction', unit='N', statistic=max
        ),
        'stroke time': _stroke_time,
    }
    return [
        EventRow(what, text(comparison.measured), text(comparison.simulated))
        for what, text in texts.items()
    ]


Statistic = Callable[[list[float]], float]


def _of_cycles(run: AnalysedRun, name: str, unit: str, statistic: Statistic) -> str:
    scale = 1e3 if unit == 'mm' else 1.0
    values = [scale * getattr(cycle, name) for cycle in run.events.cycles]
    known = [value for value in values if value == value]
    return f'{statistic(known):.3g} {unit}' if known else '-'


def _stroke_time(run: AnalysedRun) -> str:
    time = run.events.stroke_time
    return 'not reached' if time is None else f'{time:.2f} s'


def condition_texts(comparison: Comparison) -> list[str]:
    """Return the conditions, each with its origin unless it was measured."""
    return [
        f'{plain_name(c.name)} {c.value:g} {CONDITIONS[c.name].unit}'
        + ('' if c.measured else ' (from the model)')
        for c in comparison.conditions
    ]


def ratio_note(comparison: Comparison) -> str:
    """Return in lines why the ratio to the noise may be above 1; '' for two bags."""
    if comparison.second != SIMULATED:
        return ''
    return (
        'above 1 for the true model, too: it runs freely from the first readings,\n'
        'in which slips at another time and gain errors of the sensors add up.\n'
        'diagnose fits these gains and judges the balances of mass and force'
    )


def write_page(
    path: Path, comparison: Comparison, progress: Callable[[int], None] = lambda _: None
) -> Path:
    """
    Write the page.

    :param progress: callback(number of figures drawn), :data:`FIGURES` at most
    :raises RigError: when the file cannot be written
    """
    pictures = []
    for number, (title, caption, draw) in enumerate(_figures(comparison), start=1):
        figure = draw()
        if figure is not None:
            pictures.append(Picture(title, caption, data_address(figure)))
        progress(number)
    runs = comparison.measured, comparison.simulated
    text = render(
        'comparison_page.html',
        comparison=comparison,
        signals=signal_rows(comparison),
        events=event_rows(comparison),
        pairs=list(itertools.zip_longest(*(run.events.cycles for run in runs))),
        conditions=condition_texts(comparison),
        note=ratio_note(comparison),
        pictures=pictures,
        duration=comparison.measured.recording.duration,
    )
    return atomic_write(path, text)


def _figures(comparison: Comparison) -> Iterator[tuple[str, str, Callable[[], Figure | None]]]:
    """Yield title, caption and drawing function of each figure."""
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
        f'{comparison.second.capitalize()} minus measured. {band if comparison.noise else ""}',
        lambda: draw_differences(comparison),
    )
    yield (
        'Stick-slip cycles',
        'Each cycle at its breakaway: the dwell before it, the slip length and the friction peak.',
        lambda: draw_cycles(comparison),
    )
