"""Pictures of runs that were not fitted: measured, and simulated before and after."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from pneu_rig_ros.analysis.comparison import Run
from pneu_rig_ros.gap.diagnosis import Diagnosis
from pneu_rig_ros.gap.discriminate import DURATION, NextExperiment, readings
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.shrink import measured_run, predicted_run
from pneu_rig_ros.report.comparison_figures import SHOWN, thinned
from pneu_rig_ros.report.figure import BLUE, ORANGE, STYLE

Floats = NDArray[np.float64]

GREEN = '#2c8a5a'
SIGNALS = ('position', 'pressure_1', 'pressure_2')
COLOURS = {'measured': BLUE, 'model as given': ORANGE, 'improved model': GREEN}
WIDTHS = {'measured': 2.4, 'model as given': 1.1, 'improved model': 1.1}
RIVAL_COLOURS = (BLUE, ORANGE, GREEN)
DETAIL = 0.15
"""Share of the run that the detail shows [-]."""
MOVING = 0.1
"""The piston moves in the detail by so much of the longest way in as long a stretch [-]."""
STRIDE = 8
"""Samples between two stretches that are looked at."""


def runs_of(diagnosis: Diagnosis, experiment: Experiment, mode: Mode) -> dict[str, Run]:
    """Return the measured run, the given model's and, if it is another, the improved model's."""
    runs = {
        'measured': measured_run(experiment, diagnosis.given),
        'model as given': predicted_run(experiment, diagnosis.given, mode),
    }
    if diagnosis.verdict != 'consistent':
        runs['improved model'] = predicted_run(experiment, diagnosis.best, mode)
    return runs


def draw_shrink(runs: Mapping[str, Run]) -> Figure:
    """Return position and pressures against time; beside it where the given model is worst."""
    span = detail(runs['measured'], runs['model as given'])
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 5.6), layout='constrained')
        grid = figure.subplots(3, 2, sharex='col', width_ratios=(2.2, 1.0))
        for (whole, part), name in zip(grid, SIGNALS, strict=True):
            label, unit, scale = SHOWN[name]
            for legend, run in runs.items():
                _plot(whole, run, name, scale, legend, None)
                _plot(part, run, name, scale, legend, span)
            whole.axvspan(*span, color='#f0ead9', linewidth=0, zorder=0)
            whole.set_ylabel(f'{label}\n[{unit}]')
        whole.set_xlim(0.0, runs['measured'].time[-1])
        part.set_xlim(*span)
        whole.set_xlabel('time [s]')
        part.set_xlabel('time [s], the stretch that is shaded')
        handles = grid[0, 0].get_lines()
        figure.legend(handles, list(runs), loc='outside upper center', ncols=3, frameon=False)
        figure.align_ylabels()
    return figure


def detail(measured: Run, simulated: Run) -> tuple[float, float]:
    """
    Return from and to [s] of the stretch in which a simulation is farthest off.

    The piston moves in it, if it moves at all: at rest one sees nothing but an offset.
    """
    size = max(2, round(DETAIL * measured.time.size))
    windows = sliding_window_view(measured.position, size)[::STRIDE]
    way = np.ptp(windows, axis=1)
    far = np.zeros(way.size)
    for name in SIGNALS:
        off = ((simulated.signals[name] - measured.signals[name]) ** 2).cumsum()
        every = np.concatenate([[0.0], off])
        sums = (every[size:] - every[:-size])[::STRIDE]
        far += sums / max(float(np.ptp(measured.signals[name])), 1e-12) ** 2
    moving = way >= MOVING * float(way.max())
    start = STRIDE * int(np.argmax(np.where(moving, far, -1.0)))
    return float(measured.time[start]), float(measured.time[start + size - 1])


def _plot(
    axes: Axes, run: Run, name: str, scale: float, legend: str,
    span: tuple[float, float] | None,
) -> None:  # fmt: skip
    inside = slice(None) if span is None else slice(*np.searchsorted(run.time, span))
    time, values = thinned(run.time[inside], scale * run.signals[name][inside])
    axes.plot(time, values, color=COLOURS[legend], linewidth=WIDTHS[legend],
              alpha=0.5 if legend == 'measured' else 1.0)  # fmt: skip
    axes.tick_params(length=3)
    axes.ticklabel_format(useOffset=False)


def draw_next(
    plan: NextExperiment, rivals: Mapping[str, Hypothesis], experiment: Experiment
) -> Figure:
    """Return what each rival predicts for the experiment that tells them apart best."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.7), layout='constrained')
        panels = figure.subplots(1, 3)
        for (name, rival), colour in zip(rivals.items(), RIVAL_COLOURS, strict=False):
            table = readings(rival, experiment, plan.u, plan.supply_pressure, plan.load_mass,
                             plan.initial_position)  # fmt: skip
            time = np.linspace(0.0, DURATION, len(table))
            for axes, signal, values in zip(panels, SIGNALS, table.T, strict=True):
                label, unit, scale = SHOWN[signal]
                axes.plot(time, scale * values, color=colour, label=name)
                axes.set_ylabel(f'{label} [{unit}]')
                axes.set_xlabel('time [s]')
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc='outside upper center', ncols=3, frameon=False)
    return figure
