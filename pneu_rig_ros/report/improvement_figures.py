"""Figures of held-out runs: measured, and simulated before and after."""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.lib.stride_tricks import sliding_window_view

from pneu_rig_ros.analysis.metrics import AnalysedRun, SignalGap
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.answer.improvement import along_the_motion, open_signals
from pneu_rig_ros.diagnosis.answer.next_experiment import (
    INTERVAL,
    NextExperiment,
    simulated_readings,
)
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.shooting import MultipleShooting
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.report.figure import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    STYLE,
    add_letter,
    display,
    plain_name,
    save_png,
)
from pneu_rig_ros.report.figure import SIGNALS as SHOWN

SIGNALS = ('position', 'pressure_1', 'pressure_2')
MEASURED, GIVEN, IMPROVED = 'measured', 'model as given', 'improved model'
STYLES: dict[str, dict[str, Any]] = {
    MEASURED: {'color': BLUE, 'linewidth': 2.4, 'alpha': 0.5},
    GIVEN: {'color': ORANGE, 'linewidth': 1.1},
    IMPROVED: {'color': GREEN, 'linewidth': 1.1},
}
DETAIL = 0.15
"""Share of the run that the detail shows [-]."""
MOVING = 0.1
"""The piston moves in the detail by so much of the longest way in as long a stretch [-]."""
STRIDE = 8
"""Samples between two stretches that are looked at."""


@dataclass(frozen=True)
class Traces:
    """
    Signals of a measured run and of its simulations over time.

    :param time: [s], shape (n,)
    :param position: measured [m], shape (n,)
    :param signals: measured or model -> name -> values [SI], shape (n,)
    """

    time: Floats
    position: Floats
    signals: Mapping[str, Mapping[str, Floats]]


def runs_of(
    comparison: Comparison, given: Hypothesis, improved: Hypothesis | None, free: bool = False
) -> Traces:
    """
    Return the measured run and those of the models whose simulation succeeds.

    :param improved: None where the given model is not improved
    :param free: whether the simulation of a rig is started once only
    """
    run = comparison.run
    readings = run.position[1:], *run.pressures[1:].T
    measured = dict(zip(SIGNALS, readings, strict=True)) if comparison.free else open_signals(run)
    signals = {MEASURED: measured}
    for name, hypothesis in ((GIVEN, given), (IMPROVED, improved)):
        if hypothesis is not None:
            with contextlib.suppress(RigError):  # a simulation that fails
                signals[name] = _simulated(hypothesis, comparison, free)
    time: Floats = run.begin + run.interval * np.arange(1.0, run.size)
    return Traces(time, run.position[1:], signals)


def _simulated(hypothesis: Hypothesis, comparison: Comparison, free: bool) -> dict[str, Floats]:
    if not comparison.free:
        return along_the_motion(hypothesis, comparison)
    simulated = MultipleShooting(comparison).simulate(hypothesis, free)
    return dict(zip(SIGNALS, simulated.T, strict=True))


@matplotlib.rc_context(STYLE)
def draw_improvement(runs: Traces) -> Figure:
    """Return all signals against time; beside it where the given model is worst."""
    span = detail(runs)
    worst = slice(*np.searchsorted(runs.time, span))
    names = list(runs.signals[MEASURED])
    figure = Figure(figsize=(8.6, 1.65 * len(names) + 0.9))
    grid = figure.subplots(len(names), 2, sharex='col', width_ratios=(2.2, 1.0), squeeze=False)
    for (whole, part), name in zip(grid, names, strict=True):
        signal = SHOWN[name]
        for label, signals in runs.signals.items():
            for axes, inside in ((whole, slice(None)), (part, worst)):
                values = signal.scale * signals[name][inside]
                axes.plot(runs.time[inside], values, **STYLES[label])
        whole.axvspan(*span, color='#f0ead9', linewidth=0, zorder=0)
        whole.set_ylabel(f'{signal.label}\n[{signal.unit}]')
    whole.set(xlabel='time [s]', xlim=(0.0, runs.time[-1]))
    part.set(xlabel='time [s], shaded interval', xlim=span)
    figure.legend(grid[0, 0].get_lines(), list(runs.signals), loc='outside upper center', ncols=3)
    figure.align_ylabels()
    return figure


def detail(runs: Traces) -> tuple[float, float]:
    """
    Return from and to [s] of the stretch in which the given model is farthest off.

    The piston moves in it, if it moves at all: at rest only an offset would be visible.
    """
    measured = runs.signals[MEASURED]
    simulated = runs.signals.get(GIVEN, measured)
    size = max(2, round(DETAIL * runs.time.size))
    windows = sliding_window_view(runs.position, size)[::STRIDE]
    way = np.ptp(windows, axis=1)
    far = np.zeros(way.size)
    for name, values in measured.items():
        off = ((simulated[name] - values) ** 2).cumsum()
        every = np.concatenate([[0.0], off])
        sums = (every[size:] - every[:-size])[::STRIDE]
        far += sums / max(float(np.ptp(values)), 1e-12) ** 2
    moving = way >= MOVING * float(way.max())
    start = STRIDE * int(np.argmax(np.where(moving, far, -1.0)))
    return float(runs.time[start]), float(runs.time[start + size - 1])


@matplotlib.rc_context(STYLE)
def draw_next(
    plan: NextExperiment | None, rivals: Mapping[str, Hypothesis], run: Run
) -> Figure | None:
    """
    Return the predictions of the rivals for the experiment that separates them best.

    None if that is a recording like an existing one, or there are no rivals.
    """
    if plan is None or plan.u is None or plan.supply_pressure is None:
        return None
    load, start = plan.load_mass or 0.0, plan.initial_position or 0.0
    figure = Figure(figsize=(8.6, 2.7))
    panels = figure.subplots(1, 3)
    for name, rival in rivals.items():
        table = simulated_readings(rival, run, plan.u, plan.supply_pressure, load, start)
        if table is None:
            continue
        time = INTERVAL * np.arange(len(table))
        for axes, signal, values in zip(panels, SIGNALS, table.T, strict=True):
            axes.plot(time, SHOWN[signal].scale * values, label=name)
    for axes, signal in zip(panels, SIGNALS, strict=True):
        axes.set(xlabel='time [s]', ylabel=SHOWN[signal].axis)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc='outside upper center', ncols=3)
    return figure


@matplotlib.rc_context(STYLE)
def draw_shape(effect: Mapping[str, Any]) -> Figure | None:
    """
    Return the factor by which an effect differs from its formula, or what it adds without one.

    :param effect: of diagnosis.json; None is returned of one without a ``shape``
    """
    if (shape := effect['shape']) is None:
        return None
    unit, scale = display(shape['unit'])
    figure = Figure(figsize=(8.6, 2.7))
    axes = figure.subplots()
    axes.plot(scale * np.array(shape['x']), shape['y'], 'o-')
    factor = shape['y_unit'] == '-'
    axes.axhline(1.0 if factor else 0.0, color=GREY, linestyle='--')
    if factor:
        axes.set_ylim(bottom=0.0)
    axes.set_xlabel(f'{plain_name(shape["variable"])} [{unit}]')
    what = 'factor on\n' if factor else ''
    axes.set_ylabel(f'{what}{plain_name(effect["name"])}\n[{shape["y_unit"]}]')
    return figure


GAP_SIGNALS = ('position', 'pressure_1', 'friction')
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
    figure = Figure(figsize=(8.6, 6.4), dpi=110)
    title = 'A held-out run: the rig, its model before and after the diagnosis'
    figure.suptitle(title, fontsize=10.5, x=0.01, ha='left')
    grid = figure.subplots(3, 2, width_ratios=(3.6, 1.0))
    for index, ((curves, bars), name) in enumerate(zip(grid, GAP_SIGNALS, strict=True)):
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
    signal, filtered = SHOWN[name], name == 'friction'
    styles = (BLUE, 4.5, 0.4), (ORANGE, 1.0, 1.0), (GREEN, 1.0, 1.0)
    for run, (colour, width, alpha) in zip((measured, *models), styles, strict=True):
        values = signal.scale * run.signals[name]
        if filtered:
            values = smoothed(values, run.recording.interval)
        axes.plot(run.recording.time, values, color=colour, linewidth=width, alpha=alpha)
    below = f'\nbelow {DRAWN_BELOW:g} Hz' if filtered else ''
    axes.set_ylabel(f'{signal.label}{below} [{signal.unit}]')
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
    noise = scale * (gaps[0][name].noise or 0.0)
    axes.bar(['before', 'after'], values, color=(ORANGE, GREEN), width=0.6)
    higher = axes.bar(['before', 'after'], np.maximum(values, noise), width=0.6, fill=False, lw=0)
    texts = [f'{value:.3g} {unit}' for value in values]
    axes.bar_label(higher, texts, padding=2.5, fontsize=8.0)
    if noise:
        axes.axhline(noise, color=GREY, linewidth=0.8, linestyle='--')
    axes.margins(y=0.2)
    axes.set_yticks([])
    axes.spines['left'].set_visible(False)
    axes.tick_params(length=0)
    axes.grid(visible=False)
