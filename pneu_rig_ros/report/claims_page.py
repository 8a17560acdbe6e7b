"""
The paper's statements as one self-contained HTML page: findings, values, curves.

The curves are those of the paper's figures, as simulated: Fig. 4-6, 3 and 7-13.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pneu_rig_ros.batch import END_SHARE
from pneu_rig_ros.claims import trends
from pneu_rig_ros.claims.captions import DWELL, RLG, stroke_texts
from pneu_rig_ros.claims.experiments import (
    CAPTIONS,
    CYLINDERS,
    LONGEST_STROKE,
    Experiment,
    Laboratory,
    Stroke,
)
from pneu_rig_ros.claims.findings import Row
from pneu_rig_ros.claims.friction import PAUSES, equation_16, pauses, static_peaks
from pneu_rig_ros.claims.readings import (
    SPECIFICATIONS,
    open_quantities,
    printed_values_changed,
    short_text,
)
from pneu_rig_ros.report import page
from pneu_rig_ros.report.figure import (
    BAR,
    BLUE,
    GREY,
    ORANGE,
    QUANTITIES,
    STYLE,
    add_legend,
    add_letter,
    plain_name,
    time_panels,
)
from pneu_rig_ros.report.page import Draw

WIDTH = 9.6
"""Width of every figure [inch]."""
MANY_CYCLES = 50
"""With so many cycles single steps are too small to be seen in the whole stroke."""
LAW_STYLES = {RLG: (ORANGE, 'RLG, constant'), DWELL: (BLUE, 'with Eq. 16')}

SHOWS = {
    4: (1,),
    5: (2, 11),
    6: (3,),
    3: (9,),
    7: (4, 12),
    8: (5, 13),
    9: (6,),
    10: (7,),
    11: (8, 14, 15),
    12: (8, 14, 15),
    13: (8, 14, 15),
}
"""Number of a figure of the paper -> numbers of the statements that it shows; as on the page."""


def write_page(
    path: Path,
    rows: Sequence[Row],
    laboratory: Laboratory,
    shares: Mapping[int, float],
    progress: Callable[[int], None] = lambda _: None,
) -> Path:
    """
    Write the page.

    :param rows: all statements, measured in the laboratory
    :param laboratory: has carried out the experiments
    :param shares: number of a statement -> share of the neighbours under which it holds [-]
    :param progress: callback(number of figures drawn)
    :raises RigError: when the file cannot be written
    """
    return page.write(
        path,
        'claims_page.html',
        _figures(laboratory),
        progress,
        rows=rows,
        shares=shares,
        strokes=stroke_texts(laboratory),
        shows=SHOWS,
        reading=laboratory.reading,
        values=_reading_table(laboratory),
        changed=printed_values_changed(laboratory.reading),
        captions=CAPTIONS,
        pauses=PAUSES,
        trends=trends,
        end_share=END_SHARE,
        longest_stroke=LONGEST_STROKE,
    )


def _reading_table(laboratory: Laboratory) -> Iterator[tuple[str, str, list[str], bool]]:
    """
    Yield what the paper does not print, and what the reading changes of the printed.

    Name, meaning, text of the value for each cylinder, and whether a printed value changed.
    """
    models = [laboratory.reading.model(name) for name in CYLINDERS]
    changed = printed_values_changed(laboratory.reading)
    for name in dict.fromkeys([*open_quantities(), *changed]):
        section, key = name.split('.')
        specification = SPECIFICATIONS[section][key]
        used = [getattr(getattr(model, section), key) for model in models]
        texts = [short_text(specification, value) for value in used]
        yield key, specification.description, texts, name in changed


def _figures(laboratory: Laboratory) -> dict[str, Draw]:
    """Return the number of each figure of the paper -> draws it."""
    single, sweep = partial(_draw_strokes, laboratory), partial(_draw_sweep, laboratory)
    figures: dict[int, Draw] = {
        3: partial(_draw_static_friction, laboratory),
        7: partial(sweep, trends.commands, '{0.u:.3g} V'),
        8: partial(sweep, trends.supplies, '{0.supply:g} bar'),
        9: partial(sweep, trends.loads, '{0.load_mass:g} kg', CYLINDERS[:1]),
        10: partial(sweep, trends.starts, '{0.start:.0%} of the stroke'),
    }
    for index, point in enumerate(CAPTIONS.values()):
        figures[4 + index] = partial(single, [point])
        figures[11 + index] = partial(single, [replace(point, law=law) for law in LAW_STYLES])
    return {str(number): draw for number, draw in figures.items()}


@matplotlib.rc_context(STYLE)
def _draw_strokes(laboratory: Laboratory, experiments: Sequence[Experiment]) -> Figure:
    """Draw position, velocity, pressures and friction of one stroke, or of two to compare."""
    strokes = laboratory.perform_all(experiments)
    alone = len(strokes) == 1
    end = max(float(stroke.run.time[-1]) for stroke in strokes)
    figure, panels = time_panels((WIDTH, 8.0), QUANTITIES, 0.0, end)
    position, velocity, pressure, friction = panels
    for stroke in strokes:
        color, label = LAW_STYLES[stroke.experiment.law]
        run = stroke.run
        position.plot(run.time, 1e3 * run.position, color=color, label=label)
        velocity.plot(run.time, 1e3 * run.velocity, color=color, linewidth=0.7)
        pressure.plot(run.time, run.pressure_1 / BAR, color=color, label='$p_1$')
        second = {'color': ORANGE} if alone else {'color': color, 'linestyle': (0, (3, 1.5))}
        pressure.plot(run.time, run.pressure_2 / BAR, label='$p_2$', **second)
        friction.plot(run.time, run.friction_force, color=color, linewidth=0.7)
    if max(stroke.count for stroke in strokes) >= MANY_CYCLES:
        _enlarge(position, strokes)
    if alone:
        times, peaks = strokes[0].column('breakaway_time'), strokes[0].column('peak_friction')
        size = 4.5 if strokes[0].count < MANY_CYCLES else 2.0
        friction.plot(times, peaks, 'v', color=ORANGE, markersize=size, label='breakaway')
        add_legend(friction)
    else:
        add_legend(position)
    add_legend(pressure)
    return figure


def _enlarge(axes: Axes, strokes: Sequence[Stroke]) -> None:
    """Draw a short time in the middle of the last stroke into the free corner of the panel."""
    inset = axes.inset_axes((0.72, 0.15, 0.275, 0.42))
    for stroke in strokes:
        color, _ = LAW_STYLES[stroke.experiment.law]
        inset.plot(stroke.run.time, 1e3 * stroke.run.position, color=color)
    run = strokes[-1].run
    first, last = round(0.48 * run.time.size), round(0.52 * run.time.size)
    low, high = 1e3 * run.position[[first, last]]
    inset.set(xlim=run.time[[first, last]], ylim=(low, max(high, low + 1.0)))
    inset.tick_params(labelsize=7, length=2)
    inset.locator_params(nbins=4)
    axes.indicate_inset_zoom(inset, edgecolor=GREY)


@matplotlib.rc_context(STYLE)
def _draw_sweep(
    laboratory: Laboratory,
    experiments: Callable[[str], Sequence[Experiment]],
    label: str,
    cylinders: Sequence[str] = CYLINDERS,
) -> Figure:
    """Draw position against time, a panel for each cylinder, a curve for each experiment."""
    figure = Figure(figsize=(WIDTH, 3.4))
    panels = figure.subplots(1, len(cylinders), squeeze=False)[0]
    for index, (axes, name) in enumerate(zip(panels, cylinders, strict=True)):
        strokes = laboratory.perform_all(experiments(name))
        colors = matplotlib.colormaps['viridis'](np.linspace(0.0, 0.85, len(strokes)))
        for stroke, color in zip(strokes, colors, strict=True):
            text, run = label.format(stroke.experiment), stroke.run
            axes.plot(run.time, 1e3 * run.position, color=color, label=text)
        add_letter(axes, index, plain_name(name))
        length = 1e3 * strokes[0].plant.model.cylinder.stroke
        axes.set(xlabel='time [s]', ylim=(-0.02 * length, 1.03 * length))
        axes.set_xlim(left=0.0)
        axes.legend(loc='lower right', frameon=True, framealpha=0.85, edgecolor='none')
    panels[0].set_ylabel('position [mm]')
    return figure


@matplotlib.rc_context(STYLE)
def _draw_static_friction(laboratory: Laboratory) -> Figure:
    figure = Figure(figsize=(WIDTH, 3.4))
    panels = figure.subplots(1, len(CYLINDERS))
    dwell = np.geomspace(0.02, 100.0, 200)
    for index, (axes, name) in enumerate(zip(panels, CYLINDERS, strict=True)):
        stroke = laboratory.perform(CAPTIONS[name])
        law = equation_16(dwell, stroke.plant.model.friction)
        axes.plot(dwell, law, color=GREY, linewidth=1.4, label='Eq. 16')
        peaks = stroke.column('dwell', 1), static_peaks(stroke)[1:]
        axes.plot(*peaks, 'o', color=BLUE, markersize=4, alpha=0.6, label='in the stroke')
        after = pauses(laboratory, name)
        axes.plot(*after, 's', color=ORANGE, markersize=5, label='after pauses')
        add_letter(axes, index, plain_name(name))
        axes.set(xlabel='dwell time [s]', xscale='log')
        axes.set_ylim(bottom=0.0)
    panels[0].set_ylabel('friction peak [N]')
    panels[0].legend(loc='lower right')
    return figure
