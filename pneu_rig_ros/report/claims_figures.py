"""The curves of the paper's figures, as simulated: Fig. 4-6, 3 and 7-13."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pneu_rig_ros.claims.captions import DWELL, RLG
from pneu_rig_ros.claims.dwell_law import PAUSES, pauses, static_peaks
from pneu_rig_ros.claims.experiments import CAPTIONS, CYLINDERS, Experiment, Laboratory, Stroke
from pneu_rig_ros.claims.trends import (
    LOAD_COMMAND,
    LOADS,
    SUPPLIES,
    commands,
    loads,
    starts,
    supplies,
)
from pneu_rig_ros.report.figure import BAR, BLUE, GREY, ORANGE, STYLE

LETTERS = 'abcd'
WIDTH = 9.6
"""Width of every figure [inch]."""


class Picture(NamedTuple):
    """
    One figure of the page.

    :param key: where links point to
    :param title: number and subject
    :param caption: what is drawn, and at which operating point
    :param draw: makes it
    """

    key: str
    title: str
    caption: str
    draw: Callable[[Laboratory], Figure]


def pictures() -> Iterator[Picture]:
    """Yield all figures in the order of the page."""
    for number, name in enumerate(CYLINDERS, start=4):
        yield _stick_slip_picture(f'fig-{number}', f'Fig. {number}', name)
    yield Picture(
        'fig-3',
        'Fig. 3b: static friction against dwell time',
        'Each friction peak at a breakaway against the dwell before it: in the strokes of '
        'Fig. 4-6, and when the piston is pushed, shut in for '
        f'{min(PAUSES):g} to {max(PAUSES):g} s and pushed again. The line is Eq. 16 with '
        'the values of Table 2. (Fig. 3a is panel (d) of Fig. 5.)',
        _static_friction,
    )
    yield from _sweep_pictures()
    for number, name in enumerate(CYLINDERS, start=11):
        yield _comparison_picture(f'fig-{number}', f'Fig. {number}', name)


def _sweep_pictures() -> Iterator[Picture]:
    yield Picture(
        'fig-7', 'Fig. 7: effect of the airflow rate',
        'Position against time at 4 bar and 0.2 kg, with the airflow of Fig. 4-6 and multiples '
        'of it, the same for all cylinders. The text prints only 0.28-0.29 V for cylinder 1.',
        lambda laboratory: _sweep(laboratory, _commands),
    )  # fmt: skip
    yield Picture(
        'fig-8', 'Fig. 8: effect of the supply pressure',
        f'Position against time from {min(SUPPLIES):g} to {max(SUPPLIES):g} bar, at the u of '
        'Fig. 4-6 and 0.2 kg.',
        lambda laboratory: _sweep(laboratory, _supplies),
    )  # fmt: skip
    yield Picture(
        'fig-9', 'Fig. 9: effect of the external load',
        f'Position of cylinder 1 against time for loads of {min(LOADS):g} to {max(LOADS):g} kg, '
        f'at {LOAD_COMMAND:.2f} V and 4 bar.',
        lambda laboratory: _sweep(laboratory, _loads, CYLINDERS[:1]),
    )  # fmt: skip
    yield Picture(
        'fig-10', 'Fig. 10: effect of the initial position',
        'Position against time from several initial positions, at the operating points of '
        'Fig. 4-6. The captions print no positions; these are shares of the stroke.',
        lambda laboratory: _sweep(laboratory, _starts),
    )  # fmt: skip


def _stick_slip_picture(key: str, title: str, name: str) -> Picture:
    return Picture(
        key,
        f'{title}: stick-slip of {_plain(name)}',
        f'(a) position, (b) velocity, (c) absolute chamber pressures, (d) friction force with the '
        f'breakaways marked. {_operating_point(CAPTIONS[name])}.',
        lambda laboratory: _panels([laboratory.perform(CAPTIONS[name])]),
    )


def _comparison_picture(key: str, title: str, name: str) -> Picture:
    return Picture(
        key,
        f'{title}: constant against dwell-dependent static friction, {_plain(name)}',
        f'The revised LuGre law (RLG) with constant static friction, and the same with Eq. 16. '
        f'{_operating_point(CAPTIONS[name])}. The paper also draws its measurement here; its data '
        f'are not published, so only the two simulations are shown.',
        lambda laboratory: _panels(
            [laboratory.perform(replace(CAPTIONS[name], law=law)) for law in (RLG, DWELL)]
        ),
    )


def _operating_point(point: Experiment) -> str:
    return f'u = {point.u:.2f} V, supply {point.supply:g} bar, load {point.load_mass:g} kg'


def _plain(name: str) -> str:
    return name.replace('_', ' ')


def _figure(rows: int, columns: int, height: float) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(WIDTH, height), layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=columns == 1)
    return figure, list(axes.flat)


LAW_STYLES = {RLG: (ORANGE, 'RLG, constant'), DWELL: (BLUE, 'with Eq. 16')}


def _panels(strokes: Sequence[Stroke]) -> Figure:
    """Draw position, velocity, pressures and friction of one stroke, or of two to compare."""
    with matplotlib.rc_context(STYLE):
        figure, axes = _figure(4, 1, 8.0)
        for stroke in strokes:
            color, label = LAW_STYLES[stroke.experiment.law]
            run, alone = stroke.run, len(strokes) == 1
            axes[0].plot(run.time, 1e3 * run.position, color=color, label=label)
            axes[1].plot(run.time, 1e3 * run.velocity, color=color, linewidth=0.7)
            second = ORANGE if alone else color
            axes[2].plot(run.time, run.pressure_1 / BAR, color=color, label='$p_1$')
            axes[2].plot(run.time, run.pressure_2 / BAR, color=second, label='$p_2$',
                         linestyle='-' if alone else (0, (3, 1.5)))  # fmt: skip
            axes[3].plot(run.time, run.friction_force, color=color, linewidth=0.7)
        if max(stroke.count for stroke in strokes) >= MANY_CYCLES:
            _enlarge(axes[0], strokes)
        if len(strokes) == 1:
            _mark_breakaways(axes[3], strokes[0])
        else:
            _legend(axes[0], ncols=2)
        _finish_panels(axes, strokes)
        figure.align_ylabels(axes)
        figure.draw_without_rendering()
    return figure


MANY_CYCLES = 50
"""With so many cycles single steps are too small to be seen in the whole stroke."""


def _enlarge(axes: Axes, strokes: Sequence[Stroke]) -> None:
    """Draw a short time in the middle of the last stroke into the free corner of the panel."""
    inset = axes.inset_axes((0.72, 0.15, 0.275, 0.42))
    for stroke in strokes:
        color, _ = LAW_STYLES[stroke.experiment.law]
        inset.plot(stroke.run.time, 1e3 * stroke.run.position, color=color)
    run = strokes[-1].run
    first, last = round(0.48 * run.time.size), round(0.52 * run.time.size)
    inset.set_xlim(run.time[first], run.time[last])
    low, high = 1e3 * run.position[[first, last]]
    inset.set_ylim(low, max(high, low + 1.0))
    inset.tick_params(labelsize=7, length=2)
    inset.locator_params(nbins=4)
    axes.indicate_inset_zoom(inset, edgecolor=GREY)


def _mark_breakaways(axes: Axes, stroke: Stroke) -> None:
    times, peaks = stroke.column('breakaway_time'), stroke.column('peak_friction')
    size = 4.5 if stroke.count < MANY_CYCLES else 2.0
    axes.plot(times, peaks, 'v', color=ORANGE, markersize=size, label='breakaway')
    _legend(axes)


def _finish_panels(axes: Sequence[Axes], strokes: Sequence[Stroke]) -> None:
    quantities = ('position [mm]', 'velocity [mm/s]', 'pressure [bar abs]', 'friction force [N]')
    for panel, letter, quantity in zip(axes, LETTERS, quantities, strict=True):
        panel.set_ylabel(quantity)
        panel.set_title(f'({letter})', loc='left', fontsize=9, fontweight='bold', pad=3)
    handles, labels = axes[2].get_legend_handles_labels()
    axes[2].legend(handles[-2:], labels[-2:], **LEGEND, ncols=2)
    axes[3].set_xlabel('time [s]')
    axes[3].set_xlim(0.0, 1.002 * max(float(stroke.run.time[-1]) for stroke in strokes))


Choice = Callable[[str], Iterator[tuple[str, Experiment]]]
"""Name of a cylinder -> label and experiment of each curve."""


def _commands(name: str) -> Iterator[tuple[str, Experiment]]:
    for experiment in commands(name):
        yield f'{experiment.u:.3g} V', experiment


def _supplies(name: str) -> Iterator[tuple[str, Experiment]]:
    for experiment in supplies(name):
        yield f'{experiment.supply:g} bar', experiment


def _loads(_: str) -> Iterator[tuple[str, Experiment]]:
    for experiment in loads():
        yield f'{experiment.load_mass:g} kg', experiment


def _starts(name: str) -> Iterator[tuple[str, Experiment]]:
    for experiment in starts(name):
        yield f'{experiment.start or 0.0:.0%} of the stroke', experiment


def _sweep(laboratory: Laboratory, choice: Choice, names: Sequence[str] = CYLINDERS) -> Figure:
    """Draw position against time, a panel for each cylinder, a curve for each experiment."""
    with matplotlib.rc_context(STYLE):
        figure, axes = _figure(1, len(names), 3.4)
        for panel, name, letter in zip(axes, names, LETTERS, strict=False):
            length = laboratory.perform(CAPTIONS[name]).plant.model.cylinder.stroke
            curves = list(choice(name))
            colors = matplotlib.colormaps['viridis'](np.linspace(0.0, 0.85, len(curves)))
            for (label, experiment), color in zip(curves, colors, strict=True):
                run = laboratory.perform(experiment).run
                panel.plot(run.time, 1e3 * run.position, color=color, label=label)
            title = f'({letter}) {_plain(name)}' if len(names) > 1 else _plain(name)
            panel.set_title(title, loc='left', fontsize=9, fontweight='bold')
            panel.set_xlabel('time [s]')
            panel.set_xlim(left=0.0)
            panel.set_ylim(-0.02 * 1e3 * length, 1.03 * 1e3 * length)
            panel.legend(loc='lower right', frameon=True, framealpha=0.85, edgecolor='none')
        axes[0].set_ylabel('position [mm]')
        figure.draw_without_rendering()
    return figure


def _static_friction(laboratory: Laboratory) -> Figure:
    with matplotlib.rc_context(STYLE):
        figure, axes = _figure(1, 3, 3.4)
        for panel, name, letter in zip(axes, CYLINDERS, LETTERS, strict=False):
            stroke = laboratory.perform(CAPTIONS[name])
            _equation_16(panel, stroke)
            panel.plot(stroke.column('dwell', 1), static_peaks(stroke)[1:], 'o',
                       color=BLUE, markersize=4, alpha=0.6, label='in the stroke')  # fmt: skip
            panel.plot(*pauses(laboratory, name), 's', color=ORANGE, markersize=5,
                       label='after pauses')  # fmt: skip
            panel.set_title(
                f'({letter}) {_plain(name)}', loc='left', fontsize=9, fontweight='bold'
            )
            panel.set_xscale('log')
            panel.set_xlabel('dwell time [s]')
            panel.set_ylim(bottom=0.0)
        axes[0].set_ylabel('friction peak [N]')
        axes[0].legend(loc='lower right', frameon=False)
        figure.draw_without_rendering()
    return figure


def _equation_16(panel: Axes, stroke: Stroke) -> None:
    law = stroke.plant.model.friction
    dwell = np.geomspace(0.02, 100.0, 200)
    span = law.breakaway_force - law.coulomb_force
    force = law.breakaway_force - span * np.exp(-law.dwell_coefficient * dwell**law.dwell_exponent)
    panel.plot(dwell, force, color=GREY, linewidth=1.4, label='Eq. 16')


LEGEND: Any = {'loc': 'lower right', 'bbox_to_anchor': (1.0, 1.0), 'frameon': False,
          'borderaxespad': 0.0, 'borderpad': 0.1}  # fmt: skip
"""Above the panel, where no curve is."""


def _legend(axes: Axes, ncols: int = 1) -> None:
    axes.legend(**LEGEND, ncols=ncols)
