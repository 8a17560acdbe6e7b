"""Pictures of two runs side by side, in the style of a stroke's picture."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.comparison import Comparison
from pneu_rig_ros.analysis.friction import Floats
from pneu_rig_ros.analysis.metrics import AnalysedRun
from pneu_rig_ros.report.figure import BLUE, GREY, ORANGE, STYLE

SHOWN = {
    'position': ('position', 'mm', 1e3),
    'velocity': ('velocity', 'mm/s', 1e3),
    'pressure_1': ('pressure $p_1$', 'bar abs', 1e-5),
    'pressure_2': ('pressure $p_2$', 'bar abs', 1e-5),
    'friction': ('friction force', 'N', 1.0),
}
"""Signal -> name, unit in pictures, units of it in one SI unit."""

DIFFERENCE_UNITS = {'pressure_1': ('kPa', 1e-3), 'pressure_2': ('kPa', 1e-3)}
"""Where differences are drawn in another unit: unit, units of it in one SI unit."""

MOST_POINTS = 3000
"""Longer curves are drawn by their smallest and largest values, which looks the same."""

CYCLES_IN_DETAIL = 3
"""So many cycles are shown in the detail."""


def draw_overlay(comparison: Comparison, span: tuple[float, float] | None = None) -> Figure:
    """
    Return measured and simulated signals against time, one panel a signal.

    :param span: from and to [s]; all when not given
    """
    runs = comparison.measured, comparison.simulated
    names = list(comparison.gaps)
    with matplotlib.rc_context(STYLE):
        figure, axes = _panels(len(names))
        for panel, name in zip(axes, names, strict=True):
            label, unit, scale = SHOWN[name]
            for run, colour, width in zip(runs, (BLUE, ORANGE), (1.4, 1.0), strict=True):
                time, values = thinned(*_part(run, name, span))
                panel.plot(time, scale * values, color=colour, linewidth=width)
            _finish(panel, f'{label}\n[{unit}]', names.index(name))
        _mark_breakaways(axes[0], comparison, span)
        axes[0].legend(
            axes[0].get_lines()[:2],
            ('measured', comparison.second),
            loc='lower right',
            frameon=False,
        )
        _time_axis(axes[-1], span or (0.0, comparison.measured.recording.duration))
    return figure


def draw_differences(comparison: Comparison) -> Figure:
    """Return simulated less measured against time, with the noise of the sensors as a band."""
    names = list(comparison.gaps)
    with matplotlib.rc_context(STYLE):
        figure, axes = _panels(len(names))
        for panel, name in zip(axes, names, strict=True):
            label, unit, scale = SHOWN[name]
            unit, scale = DIFFERENCE_UNITS.get(name, (unit, scale))
            difference = comparison.simulated.signals[name] - comparison.measured.signals[name]
            time, values = thinned(comparison.measured.recording.time, difference)
            panel.plot(time, scale * values, color=BLUE, linewidth=0.8)
            noise = 2.0 * scale * comparison.noise.get(name, 0.0)
            panel.axhspan(-noise, noise, color=GREY, alpha=0.35, linewidth=0.0)
            _finish(panel, f'{label}\n[{unit}]', names.index(name))
        _time_axis(axes[-1], (0.0, comparison.measured.recording.duration))
    return figure


def draw_cycles(comparison: Comparison) -> Figure | None:
    """Return dwell, slip and friction peak of each cycle of both; None if neither has a cycle."""
    columns = (('dwell', 'dwell [s]', 1.0), ('slip', 'slip [mm]', 1e3),
               ('peak_friction', 'peak friction [N]', 1.0))  # fmt: skip
    runs = comparison.measured, comparison.simulated
    if not any(run.events.cycles for run in runs):
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.7), layout='constrained')
        for axes, (name, label, scale) in zip(figure.subplots(1, 3), columns, strict=True):
            for run, colour, marker in zip(runs, (BLUE, ORANGE), 'ov', strict=True):
                times = [cycle.breakaway_time for cycle in run.events.cycles]
                values = [scale * getattr(cycle, name) for cycle in run.events.cycles]
                axes.plot(times, values, marker, color=colour, markersize=4.5, alpha=0.85)
            axes.set_ylabel(label)
            axes.set_xlabel('breakaway [s]')
            axes.set_ylim(bottom=0.0)
        axes.legend(('measured', comparison.second), frameon=False, loc='lower left')
    return figure


def detail(comparison: Comparison) -> tuple[float, float] | None:
    """Return from and to [s] of the first measured cycles, None where they are the whole run."""
    cycles = comparison.measured.events.cycles
    if len(cycles) <= CYCLES_IN_DETAIL:
        return None
    first, last = cycles[0], cycles[CYCLES_IN_DETAIL - 1]
    margin = 0.15 * (last.breakaway_time - first.breakaway_time)
    start = max(0.0, first.breakaway_time - 2 * margin)
    return start, min(last.breakaway_time + 3 * margin, comparison.measured.recording.duration)


def thinned(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return a curve with at most so many points, shape (m,): extremes of equal stretches."""
    if values.size <= MOST_POINTS:
        return time, values
    stretches = np.array_split(np.arange(values.size), MOST_POINTS // 2)
    extremes = [(part[values[part].argmin()], part[values[part].argmax()]) for part in stretches]
    kept = np.unique(extremes)
    return time[kept], values[kept]


def _part(run: AnalysedRun, name: str, span: tuple[float, float] | None) -> tuple[Floats, Floats]:
    time, values = run.recording.time, run.signals[name]
    inside = slice(None) if span is None else slice(*np.searchsorted(time, span))
    return time[inside], values[inside]


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(8.6, 1.75 * count + 0.4), layout='constrained')
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    return figure, list(axes)


def _mark_breakaways(
    axes: Axes, comparison: Comparison, span: tuple[float, float] | None
) -> None:  # fmt: skip
    runs = comparison.measured, comparison.simulated
    for run, colour, height in zip(runs, (BLUE, ORANGE), (1.0, 0.93), strict=True):
        times = [cycle.breakaway_time for cycle in run.events.cycles]
        inside = [t for t in times if span is None or span[0] <= t <= span[1]]
        if inside:  # the layout fails on a line without points
            axes.plot(inside, [height] * len(inside), 'v', color=colour, markersize=4.0,
                      transform=axes.get_xaxis_transform(), clip_on=False)  # fmt: skip


def _time_axis(axes: Axes, span: tuple[float, float]) -> None:
    axes.set_xlabel('time [s]')
    axes.set_xlim(span[0], span[0] + 1.002 * (span[1] - span[0]))
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.align_ylabels()


def _finish(axes: Axes, label: str, index: int) -> None:
    axes.set_ylabel(label)
    axes.tick_params(length=3)
    letter = 'abcdefgh'[index]
    axes.annotate(
        f'({letter})', (0.008, 0.95), xycoords='axes fraction', va='top', fontweight='bold'
    )
