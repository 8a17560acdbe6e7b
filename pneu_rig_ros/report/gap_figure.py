"""The gap in one picture: measured, the model before and the model after."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.comparison import Run, SignalGap
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.report.comparison_figures import DIFFERENCE_UNITS, SHOWN
from pneu_rig_ros.report.figure import BLUE, GREY, ORANGE, STYLE

GREEN = '#2c8a5a'
SIGNALS = ('position', 'pressure_1', 'friction')
Gaps = Mapping[str, SignalGap]


def draw_gap(
    path: Path, title: str, measured: Run, models: tuple[Run, Run], gaps: tuple[Gaps, Gaps]
) -> Path:
    """
    Write a PNG with position, pressure p1 and friction, and beside each the gap in numbers.

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


def _draw_curves(axes: Axes, name: str, measured: Run, models: tuple[Run, Run]) -> None:
    label, unit, scale = SHOWN[name]
    styles = (
        (measured, BLUE, 4.5, 0.4),
        (models[0], ORANGE, 1.0, 1.0),
        (models[1], GREEN, 1.0, 1.0),
    )
    for run, colour, width, alpha in styles:
        axes.plot(run.time, scale * run.signals[name], color=colour, linewidth=width, alpha=alpha)
    axes.set_ylabel(f'{label} [{unit}]')
    axes.set_xlim(0.0, measured.time[-1])
    axes.tick_params(length=3)


def _draw_bars(axes: Axes, name: str, gaps: tuple[Gaps, Gaps]) -> None:
    """Draw the RMSE before and after, and the noise as a line."""
    unit, scale = DIFFERENCE_UNITS.get(name, SHOWN[name][1:])
    values = [scale * one[name].rmse for one in gaps]
    bars = axes.bar(['before', 'after'], values, color=(ORANGE, GREEN), width=0.6)
    axes.bar_label(bars, [f'{value:.3g} {unit}' for value in values], fontsize=8.0, padding=1.5)
    noise = gaps[0][name].noise
    if noise:
        axes.axhline(scale * noise, color=GREY, linewidth=0.8, linestyle='--')
    axes.margins(y=0.2)
    axes.set_yticks([])
    axes.spines['left'].set_visible(False)
    axes.tick_params(length=0)
    axes.grid(visible=False)
