"""The gap in one figure: measured, the model before and the model after."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.metrics import AnalysedRun, SignalGap
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.report.figure import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    STYLE,
    add_letter,
    display,
    save_png,
)
from pneu_rig_ros.report.figure import SIGNALS as SHOWN

SIGNALS = ('position', 'pressure_1', 'friction')
Gaps = Mapping[str, SignalGap]
DRAWN_BELOW = 5.0
"""Cut-off frequency of the friction that is drawn [Hz]: its noise would hide the other curves."""


@matplotlib.rc_context(STYLE)
def draw_gap(
    path: Path,
    measured: AnalysedRun,
    models: Sequence[AnalysedRun],
    gaps: Sequence[Gaps],
) -> Path:
    """
    Write a PNG with position, pressure p1 and friction, and beside each the gap in numbers.

    The friction of all runs is drawn low-passed; the numbers are those of the unfiltered signals.

    :param measured: the held-out run
    :param models: the same by the model before, and after
    :param gaps: of both, name of signal -> gap
    :raises RigError: when the file cannot be written
    """
    figure = Figure(figsize=(8.6, 6.4), dpi=110, layout='constrained')
    title = 'A held-out run: the rig, its model before and after the diagnosis'
    figure.suptitle(title, fontsize=10.5, x=0.01, ha='left')
    grid = figure.subplots(3, 2, width_ratios=(3.6, 1.0))
    for index, ((curves, bars), name) in enumerate(zip(grid, SIGNALS, strict=True)):
        _draw_curves(curves, name, measured, models)
        add_letter(curves, index)
        _draw_bars(bars, name, gaps)
    for above in grid[:-1, 0]:
        above.sharex(grid[-1, 0])
        above.tick_params(labelbottom=False)
    grid[-1, 0].set_xlabel('time [s]')
    grid[0, 1].set_title('RMSE, dashed: noise', fontsize=9.0)
    names = ['measured', 'model before', 'model after']
    figure.legend(grid[0, 0].get_lines(), names, ncols=3, loc='outside lower center')
    figure.align_ylabels(list(grid[:, 0]))
    return save_png(figure, path)


def _draw_curves(
    axes: Axes, name: str, measured: AnalysedRun, models: Sequence[AnalysedRun]
) -> None:
    signal = SHOWN[name]
    styles = (
        (measured, BLUE, 4.5, 0.4),
        (models[0], ORANGE, 1.0, 1.0),
        (models[1], GREEN, 1.0, 1.0),
    )
    for run, colour, width, alpha in styles:
        values = signal.scale * run.signals[name]
        if name == 'friction':
            values = smoothed(values, run.recording.interval)
        axes.plot(run.recording.time, values, color=colour, linewidth=width, alpha=alpha)
    label = f'{signal.label} [{signal.unit}]'
    if name == 'friction':
        label = f'{signal.label}\nbelow {DRAWN_BELOW:g} Hz [{signal.unit}]'
    axes.set_ylabel(label)
    axes.set_xlim(0.0, measured.recording.time[-1])


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


def _draw_bars(axes: Axes, name: str, gaps: Sequence[Gaps]) -> None:
    """Draw the RMSE before and after, and the noise as a line that crosses no number."""
    unit, scale = display(gaps[0][name].unit)
    values = [scale * gap[name].rmse for gap in gaps]
    axes.bar(['before', 'after'], values, color=(ORANGE, GREEN), width=0.6)
    noise = scale * (gaps[0][name].noise or 0.0)
    for place, value in enumerate(values):
        axes.annotate(
            f'{value:.3g} {unit}',
            (place, max(value, noise)),
            (0.0, 2.5),
            textcoords='offset points',
            ha='center',
            va='bottom',
            fontsize=8.0,
            zorder=3,
        )
    if noise:
        axes.axhline(noise, color=GREY, linewidth=0.8, linestyle='--')
    axes.margins(y=0.2)
    axes.set_yticks([])
    axes.spines['left'].set_visible(False)
    axes.tick_params(length=0)
    axes.grid(visible=False)
