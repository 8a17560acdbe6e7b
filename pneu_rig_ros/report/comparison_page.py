"""Two runs side by side as one self-contained HTML page."""

import itertools
import statistics
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.comparison import SIMULATED, Comparison
from pneu_rig_ros.analysis.metrics import AnalysedRun
from pneu_rig_ros.records.conditions import CONDITIONS
from pneu_rig_ros.report import page
from pneu_rig_ros.report.figure import (
    BLUE,
    GREY,
    ORANGE,
    SIGNALS,
    STYLE,
    display,
    plain_name,
    time_panels,
)
from pneu_rig_ros.report.page import Draw

COLOURS = (BLUE, ORANGE)
"""Of measured and simulated."""
CYCLES_IN_DETAIL = 3
"""So many cycles are shown in the detail."""
CYCLE_UNITS = {'breakaway_time': 's', 'dwell': 's', 'slip': 'm', 'peak_friction': 'N'}
"""Field of a cycle -> SI unit."""
FIGURES = 4
"""On a page, those without anything to be seen included."""
SIGNAL_HEADS = ('signal', '>RMSE', '>largest', '>bias', 'unit', '>sensor noise', '>RMSE / noise')
"""Of the columns; one that begins with '>' is for numbers."""
OF_CYCLES = (
    ('first breakaway', 'breakaway_time', min),
    ('median dwell', 'dwell', statistics.median_high),
    ('longest dwell', 'dwell', max),
    ('median slip', 'slip', statistics.median_high),
    ('median peak friction', 'peak_friction', statistics.median_high),
    ('largest peak friction', 'peak_friction', max),
)
"""Name, field of a cycle and statistic of each number."""


def write_page(
    path: Path, comparison: Comparison, progress: Callable[[int], None] = lambda _: None
) -> Path:
    """
    Write the page.

    :param progress: callback(number of figures drawn), up to :data:`FIGURES`
    :raises RigError: when the file cannot be written
    """
    runs, span = (comparison.measured, comparison.simulated), detail(comparison)
    figures: dict[str, Draw] = {
        'overlay': partial(draw_overlay, comparison),
        'first_cycles': lambda: None if span is None else draw_overlay(comparison, span),
        'differences': partial(draw_differences, comparison),
        'cycles': partial(draw_cycles, comparison),
    }
    return page.write(
        path,
        'comparison_page.html',
        figures,
        progress,
        comparison=comparison,
        signal_heads=SIGNAL_HEADS,
        signals=signal_rows(comparison),
        events=event_rows(comparison),
        pairs=list(itertools.zip_longest(*(run.cycles for run in runs))),
        conditions=condition_texts(comparison),
        note=ratio_note(comparison),
    )


@matplotlib.rc_context(STYLE)
def draw_overlay(comparison: Comparison, span: tuple[float, float] | None = None) -> Figure:
    """
    Return measured and simulated signals against time, one panel a signal.

    :param span: from and to [s]; all when not given
    """
    measured, simulated = comparison.measured, comparison.simulated
    start, end = span or (0.0, measured.recording.duration)
    shown = [SIGNALS[name] for name in comparison.gaps]
    labels = [f'{one.label}\n[{one.unit}]' for one in shown]
    figure, panels = time_panels((8.6, 1.75 * len(labels) + 0.6), labels, start, end)
    for axes, name, signal in zip(panels, comparison.gaps, shown, strict=True):
        for run, colour, width in zip((measured, simulated), COLOURS, (1.4, 1.0), strict=True):
            inside = slice(*np.searchsorted(run.recording.time, (start, end)))
            time, values = run.recording.time[inside], signal.scale * run.signals[name][inside]
            axes.plot(time, values, color=colour, linewidth=width)
    curves = panels[0].get_lines()
    figure.legend(curves, ('measured', comparison.second), loc='outside upper right', ncols=2)
    for run, colour, height in zip((measured, simulated), COLOURS, (1.0, 0.93), strict=True):
        times = [cycle.breakaway_time for cycle in run.cycles]
        times = [time for time in times if start <= time <= end]
        if times:  # the layout fails on a line without points
            panels[0].plot(
                times,
                [height] * len(times),
                'v',
                color=colour,
                markersize=4.0,
                transform=panels[0].get_xaxis_transform(),
                clip_on=False,
            )
    return figure


def detail(comparison: Comparison) -> tuple[float, float] | None:
    """Return from and to [s] of the first measured cycles, None where they are the whole run."""
    cycles = comparison.measured.cycles
    if len(cycles) <= CYCLES_IN_DETAIL:
        return None
    first, last = cycles[0], cycles[CYCLES_IN_DETAIL - 1]
    margin = 0.15 * (last.breakaway_time - first.breakaway_time)
    start = max(0.0, first.breakaway_time - 2 * margin)
    return start, min(last.breakaway_time + 3 * margin, comparison.measured.recording.duration)


@matplotlib.rc_context(STYLE)
def draw_differences(comparison: Comparison) -> Figure:
    """Return simulated minus measured against time, with the noise of the sensors as a band."""
    recording = comparison.measured.recording
    units = {name: display(gap.unit) for name, gap in comparison.gaps.items()}
    labels = [f'{SIGNALS[name].label}\n[{unit}]' for name, (unit, _) in units.items()]
    size = (8.6, 1.75 * len(labels) + 0.6)
    figure, panels = time_panels(size, labels, 0.0, recording.duration)
    for axes, (name, (_, scale)) in zip(panels, units.items(), strict=True):
        difference = comparison.simulated.signals[name] - comparison.measured.signals[name]
        axes.plot(recording.time, scale * difference, linewidth=0.8)
        noise = 2.0 * scale * (comparison.gaps[name].noise or 0.0)
        axes.axhspan(-noise, noise, color=GREY, alpha=0.35, linewidth=0.0)
    return figure


@matplotlib.rc_context(STYLE)
def draw_cycles(comparison: Comparison) -> Figure | None:
    """Return dwell, slip and friction peak of each cycle of both; None if neither has a cycle."""
    runs = comparison.measured, comparison.simulated
    if not any(run.cycles for run in runs):
        return None
    figure = Figure(figsize=(8.6, 2.9))
    columns = ('dwell', 'slip', 'peak_friction')
    for axes, name in zip(figure.subplots(1, 3), columns, strict=True):
        unit, scale = display(CYCLE_UNITS[name])
        for run, marker in zip(runs, 'ov', strict=True):
            times = [cycle.breakaway_time for cycle in run.cycles]
            values = [scale * getattr(cycle, name) for cycle in run.cycles]
            axes.plot(times, values, marker, markersize=4.5, alpha=0.85)
        axes.set(xlabel='breakaway [s]', ylabel=f'{plain_name(name)} [{unit}]')
        axes.set_ylim(bottom=0.0)
    handles = axes.get_lines()
    figure.legend(handles, ('measured', comparison.second), loc='outside upper right', ncols=2)
    return figure


def signal_rows(comparison: Comparison) -> Iterator[tuple[str, ...]]:
    """Yield a row for each signal, in its display unit for differences; '-' is not known."""
    for name, gap in comparison.gaps.items():
        unit, scale = display(gap.unit)
        rmse, largest, bias = (f'{scale * v:.3g}' for v in (gap.rmse, gap.largest, gap.bias))
        noise = '-' if gap.noise is None else f'{scale * gap.noise:.3g}'
        multiple = '-' if gap.multiple is None else f'{gap.multiple:.1f}'
        yield plain_name(name), rmse, largest, bias, unit, noise, multiple


def event_rows(comparison: Comparison) -> Iterator[tuple[str, ...]]:
    """Yield the events of the measured run and of the other one in a few numbers."""
    both = comparison.measured, comparison.simulated
    yield 'stick-slip cycles', *(str(len(run.cycles)) for run in both)
    for what, name, statistic in OF_CYCLES:
        yield what, *(_of_cycles(run, name, statistic) for run in both)
    times = (run.stroke_time for run in both)
    yield 'stroke time', *('not reached' if time is None else f'{time:.2f} s' for time in times)


def _of_cycles(run: AnalysedRun, name: str, statistic: Callable[[list[float]], float]) -> str:
    unit, scale = display(CYCLE_UNITS[name])
    values = [scale * getattr(cycle, name) for cycle in run.cycles]
    known = [value for value in values if value == value]
    return f'{statistic(known):.3g} {unit}' if known else '-'


def condition_texts(comparison: Comparison) -> list[str]:
    """Return the conditions, each with its origin unless it was measured."""
    known = comparison.measured.recording.conditions
    return [
        f'{plain_name(name)} {value:g} {CONDITIONS[name].unit}'
        + ('' if name in known else ' (from the model)')
        for name, value in comparison.conditions.items()
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
