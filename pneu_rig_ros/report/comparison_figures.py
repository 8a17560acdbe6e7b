"""Figures of two runs side by side, in the style of a stroke's figure."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.comparison import Comparison
from pneu_rig_ros.report.figure import (
    BLUE,
    GREY,
    ORANGE,
    SIGNALS,
    STYLE,
    add_letter,
    thinned,
)

COLOURS = (BLUE, ORANGE)
"""Of measured and simulated."""
CYCLES_IN_DETAIL = 3
"""So many cycles are shown in the detail."""
CYCLE_COLUMNS = (
    ('dwell', 'dwell [s]', 1.0),
    ('slip', 'slip [mm]', 1e3),
    ('peak_friction', 'peak friction [N]', 1.0),
)
"""Field of a cycle, label with unit, units of it in one SI unit."""


@matplotlib.rc_context(STYLE)
def draw_overlay(comparison: Comparison, span: tuple[float, float] | None = None) -> Figure:
    """
    Return measured and simulated signals against time, one panel a signal.

    :param span: from and to [s]; all when not given
    """
    measured, simulated = comparison.measured, comparison.simulated
    start, end = span or (0.0, measured.recording.duration)
    figure, panels = _panels(comparison, start, end)
    for axes, name in zip(panels, comparison.gaps, strict=True):
        signal = SIGNALS[name]
        for run, colour, width in zip((measured, simulated), COLOURS, (1.4, 1.0), strict=True):
            inside = slice(*np.searchsorted(run.recording.time, (start, end)))
            time, values = thinned(run.recording.time[inside], run.signals[name][inside])
            axes.plot(time, signal.scale * values, color=colour, linewidth=width)
        axes.set_ylabel(f'{signal.label}\n[{signal.unit}]')
    curves = panels[0].get_lines()
    figure.legend(curves, ('measured', comparison.second), loc='outside upper right', ncols=2)
    for run, colour, height in zip((measured, simulated), COLOURS, (1.0, 0.93), strict=True):
        times = [cycle.breakaway_time for cycle in run.events.cycles]
        inside_span = [t for t in times if start <= t <= end]
        if inside_span:  # the layout fails on a line without points
            panels[0].plot(
                inside_span,
                [height] * len(inside_span),
                'v',
                color=colour,
                markersize=4.0,
                transform=panels[0].get_xaxis_transform(),
                clip_on=False,
            )
    return figure


@matplotlib.rc_context(STYLE)
def draw_differences(comparison: Comparison) -> Figure:
    """Return simulated minus measured against time, with the noise of the sensors as a band."""
    recording = comparison.measured.recording
    figure, panels = _panels(comparison, 0.0, recording.duration)
    for axes, name in zip(panels, comparison.gaps, strict=True):
        scale = SIGNALS[name].difference_scale
        difference = comparison.simulated.signals[name] - comparison.measured.signals[name]
        time, values = thinned(recording.time, difference)
        axes.plot(time, scale * values, color=BLUE, linewidth=0.8)
        noise = 2.0 * scale * comparison.noise.get(name, 0.0)
        axes.axhspan(-noise, noise, color=GREY, alpha=0.35, linewidth=0.0)
        axes.margins(y=0.15)  # room for the letter
        axes.set_ylabel(f'{SIGNALS[name].label}\n[{SIGNALS[name].difference_unit}]')
    return figure


@matplotlib.rc_context(STYLE)
def draw_cycles(comparison: Comparison) -> Figure | None:
    """Return dwell, slip and friction peak of each cycle of both; None if neither has a cycle."""
    runs = comparison.measured, comparison.simulated
    if not any(run.events.cycles for run in runs):
        return None
    figure = Figure(figsize=(8.6, 2.9), layout='constrained')
    for axes, (name, label, scale) in zip(figure.subplots(1, 3), CYCLE_COLUMNS, strict=True):
        for run, colour, marker in zip(runs, COLOURS, 'ov', strict=True):
            times = [cycle.breakaway_time for cycle in run.events.cycles]
            values = [scale * getattr(cycle, name) for cycle in run.events.cycles]
            axes.plot(times, values, marker, color=colour, markersize=4.5, alpha=0.85)
        axes.set_ylabel(label)
        axes.set_xlabel('breakaway [s]')
        axes.set_ylim(bottom=0.0)
    handles = axes.get_lines()
    figure.legend(handles, ('measured', comparison.second), loc='outside upper right', ncols=2)
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


def _panels(comparison: Comparison, start: float, end: float) -> tuple[Figure, list[Axes]]:
    """Return a panel for each signal that is compared, over one time axis [s]."""
    count = len(comparison.gaps)
    figure = Figure(figsize=(8.6, 1.75 * count + 0.6), layout='constrained')
    panels = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    for index, axes in enumerate(panels):
        add_letter(axes, index)
    panels[-1].set_xlabel('time [s]')
    panels[-1].set_xlim(start, start + 1.002 * (end - start))
    figure.align_ylabels(panels)
    return figure, panels
