"""Figures of the latent input of a balance: over time, and against what it depends on."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import STOP_UNIT
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.localisation import SignificantResidual
from pneu_rig_ros.diagnosis.residuals.windows import BREAKAWAY, Windows, windows_of
from pneu_rig_ros.report.dependence import (
    COLOURS,
    NAMES,
    SYMBOLS,
    Dependence,
    Track,
    at_breakaways,
    dependence,
)
from pneu_rig_ros.report.diagnosis_rows import VARIABLE_UNITS
from pneu_rig_ros.report.figure import BLUE, GREEN, GREY, STYLE, display, literal

Spans = Sequence[tuple[float, float]]

SIGNIFICANT, BAND = '#dfe9d3', 0.25
BAR: dict[str, Any] = {'color': '#e0a83c', 'linewidth': 0}
BAR_FROM = 0.95
"""The bar above a panel begins at this share of its height [-]."""
EXPLAINED: dict[str, Any] = {'color': GREEN, 'linewidth': 1.2, 'linestyle': (0, (4, 2))}
MARKER: dict[str, Any] = {'color': BLUE, 'markersize': 3.2, 'markerfacecolor': 'white'}
BREAK: dict[str, Any] = {'fmt': 'o', 'zorder': 3, **MARKER}
"""Styles of the explanation and of breakaways."""
MOST_RECORDINGS = 6
"""Recordings that are drawn: those that disagree most."""
SMALL = 0.3
"""Curves below it are drawn in a smaller unit [mg/s]."""
PAUSE = 0.3
"""Windows farther apart are not joined by a line [s]."""
SHOWN, BEYOND = 97.0, 1.6
"""The scale of a panel shows so many times this percentile of the latent input and its band."""


def tracks_of(
    dataset: Dataset, hypothesis: Hypothesis, improved: Hypothesis | None
) -> dict[str, list[Track]]:
    """
    Return balance -> the latent input with a hypothesis in each recording.

    Readings at end stops, which are no force, are not drawn.

    :param improved: the hypothesis with the explanation, None without one
    """
    windows = _by_key(dataset, hypothesis)
    explained = {}
    if improved is not None:
        others = _by_key(dataset, improved)
        explained = {key: one.residual - others[key].residual for key, one in windows.items()}
    tracks: dict[str, list[Track]] = {balance: [] for balance, _, _ in windows}
    for balance, rows in tracks.items():
        for comparison in dataset.comparisons:
            run = comparison.run
            key = balance, run.name, False
            breakaways = windows.get((balance, run.name, True))
            duration = run.size * run.interval
            rows.append(
                Track(windows.get(key), explained.get(key), breakaways, run.name, duration)
            )
    return tracks


def _by_key(dataset: Dataset, hypothesis: Hypothesis) -> dict[tuple[str, str, bool], Windows]:
    """Return the windows by balance, recording, and whether they are breakaways."""
    return {
        (one.balance, one.recording, one.balance == 'force' and one.regime[0] == BREAKAWAY): one
        for one in windows_of(dataset, hypothesis)
        if not one.at_stops
    }


@matplotlib.rc_context(STYLE)
def draw_latent(
    balance: str,
    tracks: Sequence[Track],
    spans: Mapping[str, Spans],
    significant: Sequence[SignificantResidual] = (),
) -> Figure:
    """
    Return the latent input over the time of each recording, and beside it what it depends on.

    :param spans: recording -> from, to [s] that have a bar: above the noise of a window
    :param significant: residuals; stretches of time and parts of those of the balance are shaded
    """
    significant = [one for one in significant if one.balance == balance and one.unit != STOP_UNIT]
    shown = most_significant(tracks)
    unit, scale = unit_of(balance, shown)
    sides = dependence(tracks, significant)
    parts = [parts_of(side, significant) for side in sides]
    stretches = [stretches_of(track, significant) for track in shown]
    height = max(1.15 * len(shown), 1.7 * len(sides), 2.4) + 0.9
    figure = Figure(figsize=(8.8, height), layout='constrained')
    widths = (2.3, 1.0) if sides else (1.0,)
    left, *right = figure.subfigures(1, len(widths), squeeze=False, width_ratios=widths)[0]
    panels = left.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, track, stretch in zip(panels, shown, stretches, strict=True):
        shade(axes, stretch)
        _draw_track(axes, track, scale, spans.get(track.name, ()))
    panels[-1].set_xlim(0.0, max(track.duration for track in shown))
    panels[-1].set_xlabel('time [s]')
    left.supylabel(f'latent input [{unit}]', fontsize=9)
    if sides:
        panels = right[0].subplots(len(sides), 1, squeeze=False)[:, 0]
        for axes, side, part in zip(panels, sides, parts, strict=True):
            _draw_dependence(axes, side, part, unit, scale)
    directions = {name for side in sides for name in side.bins}
    _add_legend(figure, shown, spans, any((*stretches, *parts)), directions)
    return figure


def parts_of(side: Dependence, significant: Sequence[SignificantResidual]) -> Spans:
    """Return the significant parts of the range of a signal, of breakaways or of the others."""
    return [
        (low, high)
        for residual in significant
        if at_breakaways(residual) != side.joined
        for variable, low, high in residual.parts
        if variable == side.variable
    ]


def stretches_of(track: Track, significant: Sequence[SignificantResidual]) -> Spans:
    """Return the significant stretches of a recording [s], of all regimes."""
    return [
        (begin, end)
        for residual in significant
        for name, begin, end in residual.intervals
        if name == track.name
    ]


def shade(axes: Axes, spans: Spans, scale: float = 1.0) -> None:
    """Shade what is significant, in units of which many make one of the axis."""
    for begin, end in spans:
        axes.axvspan(scale * begin, scale * end, color=SIGNIFICANT, linewidth=0, zorder=0)


def most_significant(tracks: Sequence[Track]) -> list[Track]:
    """Return the recordings with the largest latent input relative to its noise, in order."""
    known = [track for track in tracks if track.windows or track.breakaways]

    def mean_square(track: Track) -> float:
        both = [w.whitened for w in (track.windows, track.breakaways) if w is not None]
        return float(np.mean(np.concatenate(both) ** 2))

    chosen = sorted(known, key=mean_square, reverse=True)[:MOST_RECORDINGS]
    return [track for track in known if track in chosen]


def unit_of(balance: str, tracks: Sequence[Track]) -> tuple[str, float]:
    """Return the display unit and how many of it are one SI unit."""
    if balance == 'force':
        return 'N', 1.0
    unit, scale = display('kg/s')
    small = scale * max(half_height(track) for track in tracks) < SMALL
    return ('μg/s', 1e3 * scale) if small else (unit, scale)


def half_height(track: Track) -> float:
    """Return half the height in which the breakaways and most of the curve are seen [SI]."""
    highest = 0.0
    if (latent := track.latent) is not None:
        reach = np.abs(latent.mean) + 2.0 * latent.deviation
        highest = float(min(BEYOND * np.percentile(reach, SHOWN), reach.max()))
    if (breaks := track.breakaways) is not None:
        highest = max(highest, float(np.max(np.abs(breaks.residual) + breaks.deviation)))
    return 1.15 * highest


def _draw_track(axes: Axes, track: Track, scale: float, spans: Spans) -> None:
    """Draw the latent input of a recording over time, its band broken where no window is."""
    for begin, end in spans:
        axes.axvspan(begin, end, BAR_FROM, **BAR)
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    if (latent := track.latent) is not None:
        mean, half = scale * latent.mean, 2.0 * scale * latent.deviation
        explained = None
        if track.explained is not None:
            explained = scale * latent.levelled(latent.average @ track.explained)
        for part in connected(latent.time):
            time, low, high = latent.time[part], (mean - half)[part], (mean + half)[part]
            axes.fill_between(time, low, high, color=BLUE, alpha=BAND, linewidth=0)
            axes.plot(time, mean[part], color=BLUE)
            if explained is not None:
                axes.plot(time, explained[part], **EXPLAINED)
    if (breaks := track.breakaways) is not None:
        deviation = 2.0 * scale * breaks.deviation
        axes.errorbar(breaks.middle, scale * breaks.residual, deviation, elinewidth=0.8, **BREAK)
    height = scale * half_height(track)
    axes.set_ylim(-height, height)
    axes.set_title(literal(track.name), fontsize=8, loc='left', pad=2)
    axes.tick_params(labelsize=8)


def connected(time: Floats) -> Iterator[slice]:
    """Yield the stretches between longer pauses."""
    pauses = np.flatnonzero(np.diff(time) > max(PAUSE, 3.0 * float(np.median(np.diff(time)))))
    edges = [0, *(pauses + 1), time.size] if time.size > 1 else [0, time.size]
    for begin, end in pairwise(edges):
        yield slice(int(begin), int(end))


def _draw_dependence(axes: Axes, side: Dependence, parts: Spans, unit: str, scale: float) -> None:
    own_unit, own_scale = display(VARIABLE_UNITS[side.variable])
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    shade(axes, parts, own_scale)
    for direction, bins in side.bins.items():
        axes.errorbar(
            own_scale * bins.middle,
            scale * bins.mean,
            2.0 * scale * bins.deviation,
            fmt='o-' if side.joined else 'o',
            color=COLOURS[direction],
            markersize=3.2,
            linewidth=0.9,
            elinewidth=0.8,
            capsize=1.5,
        )
    if side.logarithmic:
        axes.set_xscale('log')
    axes.set_ylim(*(scale * end for end in shown_range(side)))
    axes.set_title(side.title, fontsize=8, loc='left', pad=2)
    axes.set_xlabel(f'{SYMBOLS[side.variable]} [{own_unit}]', fontsize=8)
    axes.set_ylabel(f'[{unit}]', fontsize=8)
    axes.tick_params(labelsize=8)


def shown_range(side: Dependence) -> tuple[float, float]:
    """Return the range in which the means and half of their error bars are seen [SI]."""
    low = min(0.0, *(float(np.min(row.mean - row.deviation)) for row in side.bins.values()))
    high = max(0.0, *(float(np.max(row.mean + row.deviation)) for row in side.bins.values()))
    margin = 0.1 * (high - low)
    return low - margin, high + margin


def _add_legend(
    figure: Figure,
    tracks: Sequence[Track],
    spans: Mapping[str, Spans],
    shaded: bool,
    directions: set[str],
) -> None:
    """Add a legend of what is drawn anywhere in the figure."""
    line = Patch(color=BLUE, alpha=BAND), Line2D([], [], color=BLUE)
    marks: dict[str, Any] = {'latent input, ±2 standard deviations': line}
    if any(track.explained is not None for track in tracks):
        marks['explanation'] = Line2D([], [], **EXPLAINED)
    if any(spans.values()):
        what = 'explanation ' * ('explanation' in marks)
        marks[f'{what}above the noise'] = Patch(**BAR)
    if shaded:
        marks['significant'] = Patch(color=SIGNIFICANT)
    if any(track.breakaways is not None for track in tracks):
        marks['breakaway'] = Line2D([], [], linestyle='', marker='o', **MARKER)
    for direction in sorted(directions, reverse=True):
        colour = COLOURS[direction]
        marks[NAMES[direction]] = Line2D([], [], color=colour, marker='o', markersize=4)
    figure.legend(
        list(marks.values()),
        list(marks),
        loc='outside lower center',
        ncols=4,
        fontsize=8,
        columnspacing=1.4,
    )
