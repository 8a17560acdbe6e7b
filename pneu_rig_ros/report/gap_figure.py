"""The gap in one picture: measured, the model before and the model after."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.friction import Floats
from pneu_rig_ros.analysis.metrics import AnalysedRun, SignalGap
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.report.comparison_figures import DIFFERENCE_UNITS, SHOWN
from pneu_rig_ros.report.figure import BLUE, GREY, ORANGE, STYLE

GREEN = '#2c8a5a'
SIGNALS = ('position', 'pressure_1', 'friction')
Gaps = Mapping[str, SignalGap]
DRAWN_BELOW = 5.0
"""Cut-off frequency of the friction that is drawn [Hz]: its noise would hide the other curves."""


def draw_gap(
    path: Path,
    title: str,
    measured: AnalysedRun,
    models: tuple[AnalysedRun, AnalysedRun],
    gaps: tuple[Gaps, Gaps],
) -> Path:
    """
    Write a PNG with position, pressure p1 and friction, and beside each the gap in numbers.

    The friction of all runs is drawn low-passed; the numbers are those of the unfiltered signals.

    :param measured: the run that no fit has seen
    :param models: the same by the model before, and after
    :param gaps: of both, name of signal -> gap
    :raises RigError: when the file cannot be written
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 6.4), dpi=110, layout='constrained')
        FigureCanvasAgg(figure)
        figure.suptitle(title, fontsize=10.5, x=0.01, ha='left')
        grid = figure.subplots(3, 2, width_ratios=(3.6, 1.0))
        for index, ((curves, bars), name) in enumerate(zip(grid, SIGNALS, strict=True)):
            _draw_curves(curves, name, measured, models)
            curves.annotate(f'({"abc"[index]})', (0.008, 0.97), xycoords='axes fraction',
                            va='top', fontweight='bold')  # fmt: skip
            _draw_bars(bars, name, gaps)
        for above in grid[:-1, 0]:
            above.sharex(grid[-1, 0])
            above.tick_params(labelbottom=False)
        grid[-1, 0].set_xlabel('time [s]')
        grid[0, 1].set_title('RMSE, dashed: noise', fontsize=9.0)
        handles = grid[0, 0].get_lines()
        figure.legend(handles, ['measured', 'model before', 'model after'], ncols=3,
                      loc='outside lower center', frameon=False)  # fmt: skip
        figure.align_ylabels(list(grid[:, 0]))
        try:
            figure.savefig(path, format='png')
        except OSError as error:
            raise RigError(f'cannot write the picture {path}: {error.strerror}') from error
    return path


def _draw_curves(
    axes: Axes, name: str, measured: AnalysedRun, models: tuple[AnalysedRun, AnalysedRun]
) -> None:
    label, unit, scale = SHOWN[name]
    styles = (
        (measured, BLUE, 4.5, 0.4),
        (models[0], ORANGE, 1.0, 1.0),
        (models[1], GREEN, 1.0, 1.0),
    )
    for run, colour, width, alpha in styles:
        values = scale * run.signals[name]
        if name == 'friction':
            values = smoothed(values, run.recording.interval)
        axes.plot(run.recording.time, values, color=colour, linewidth=width, alpha=alpha)
    if name == 'friction':
        axes.annotate(f'drawn below {DRAWN_BELOW:g} Hz', (0.992, 0.95), xycoords='axes fraction',
                      ha='right', va='top', fontsize=8.0, color=GREY)  # fmt: skip
    axes.set_ylabel(f'{label} [{unit}]')
    axes.set_xlim(0.0, measured.recording.time[-1])
    axes.tick_params(length=3)


def smoothed(values: Floats, interval: float) -> Floats:
    """
    Return equally spaced values low-passed at :data:`DRAWN_BELOW` without phase shift.

    :param values: shape (n,)
    :param interval: sampling interval [s]
    """
    from scipy.signal import butter, filtfilt

    b, a = butter(2, DRAWN_BELOW, fs=1.0 / interval)
    beyond = min(values.size - 1, round(1.0 / (DRAWN_BELOW * interval)))
    return np.asarray(filtfilt(b, a, values, padlen=beyond))


def _draw_bars(axes: Axes, name: str, gaps: tuple[Gaps, Gaps]) -> None:
    """Draw the RMSE before and after, and the noise as a line that crosses no number."""
    unit, scale = DIFFERENCE_UNITS.get(name, SHOWN[name][1:])
    values = [scale * one[name].rmse for one in gaps]
    axes.bar(['before', 'after'], values, color=(ORANGE, GREEN), width=0.6)
    noise = scale * (gaps[0][name].noise or 0.0)
    for place, value in enumerate(values):
        axes.annotate(f'{value:.3g} {unit}', (place, max(value, noise)), (0.0, 2.5),
                      textcoords='offset points', ha='center', va='bottom', fontsize=8.0,
                      zorder=3)  # fmt: skip
    if noise:
        axes.axhline(noise, color=GREY, linewidth=0.8, linestyle='--')
    axes.margins(y=0.2)
    axes.set_yticks([])
    axes.spines['left'].set_visible(False)
    axes.tick_params(length=0)
    axes.grid(visible=False)
