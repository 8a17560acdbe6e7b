"""Figures of the latent input of a balance: over time, and against what it depends on."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

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

LATENT = 'latent input, ±2 standard deviations'
SIGNIFICANT: dict[str, Any] = {'color': '#dfe9d3', 'linewidth': 0, 'label': 'significant'}
BAR: dict[str, Any] = {'color': '#e0a83c', 'linewidth': 0}
BAR_FROM = 0.95
"""The bar above a panel begins at this share of its height [-]."""
EXPLAINED: dict[str, Any] = {'color': GREEN, 'linewidth': 1.2, 'linestyle': (0, (4, 2))}
BREAK: dict[str, Any] = {'color': BLUE, 'markersize': 3.2, 'markerfacecolor': 'white', 'zorder': 3}
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
    others = {} if improved is None else _by_key(dataset, improved)
    explained = {key: windows[key].residual - one.residual for key, one in others.items()}
    tracks: dict[str, list[Track]] = {balance: [] for balance, _, _ in windows}
    for balance, rows in tracks.items():
        for run in (comparison.run for comparison in dataset.comparisons):
            key, duration = (balance, run.name, False), run.size * run.interval
            breakaways = windows.get((balance, run.name, True))
            shown = windows.get(key), explained.get(key), breakaways
            rows.append(Track(*shown, run.name, duration))
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
    height = max(1.15 * len(shown), 1.7 * len(sides), 2.4) + 0.9
    figure = Figure(figsize=(8.8, height))
    widths = (2.3, 1.0) if sides else (1.0,)
    left, *right = figure.subfigures(1, len(widths), squeeze=False, width_ratios=widths)[0]
    panels = left.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    explained = any(track.explained is not None for track in shown)
    above = 'explanation above the noise' if explained else 'above the noise'
    for axes, track in zip(panels, shown, strict=True):
        _draw_track(axes, track, scale, spans.get(track.name, ()), above)
        shade(axes, stretches_of(track, significant))
    panels[-1].set(xlabel='time [s]', xlim=(0.0, max(track.duration for track in shown)))
    left.supylabel(f'latent input [{unit}]', fontsize=9)
    if sides:
        panels = right[0].subplots(len(sides), 1, squeeze=False)[:, 0]
        for axes, side in zip(panels, sides, strict=True):
            _draw_dependence(axes, side, unit, scale)
            own_scale = display(VARIABLE_UNITS[side.variable])[1]
            shade(axes, parts_of(side, significant), own_scale)
    _add_legend(figure)
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
        axes.axvspan(scale * begin, scale * end, zorder=0, **SIGNIFICANT)


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


def _draw_track(axes: Axes, track: Track, scale: float, spans: Spans, above: str) -> None:
    """
    Draw the latent input of a recording over time, its band broken where no window is.

    :param above: what the spans are called
    """
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    if (latent := track.latent) is not None:
        mean, half = scale * latent.mean, 2.0 * scale * latent.deviation
        time, middle, low, high = broken(latent.time, mean, mean - half, mean + half)
        axes.fill_between(time, low, high, color=BLUE, alpha=0.25, linewidth=0, label=LATENT)
        axes.plot(time, middle, color=BLUE, label=LATENT)
        if track.explained is not None:
            explained = scale * latent.levelled(latent.average @ track.explained)
            axes.plot(*broken(latent.time, explained), label='explanation', **EXPLAINED)
    for begin, end in spans:
        axes.axvspan(begin, end, BAR_FROM, label=above, **BAR)
    if (breaks := track.breakaways) is not None:
        places = breaks.middle, scale * breaks.residual, 2.0 * scale * breaks.deviation
        axes.errorbar(*places, fmt='o', elinewidth=0.8, label='breakaway', **BREAK)
    height = scale * half_height(track)
    axes.set_ylim(-height, height)
    axes.set_title(literal(track.name), fontsize=8, loc='left', pad=2)
    axes.tick_params(labelsize=8)


def broken(time: Floats, *curves: Floats) -> list[Floats]:
    """Return times and curves over them, shape (n,) each, with NaN in longer pauses."""
    steps = np.diff(time)
    pauses = np.flatnonzero(steps > max(PAUSE, 3.0 * float(np.median(steps)))) + 1
    return [np.insert(values, pauses, np.nan) for values in (time, *curves)]


def _draw_dependence(axes: Axes, side: Dependence, unit: str, scale: float) -> None:
    own_unit, own_scale = display(VARIABLE_UNITS[side.variable])
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    for direction, bins in side.bins.items():
        axes.errorbar(
            own_scale * bins.middle,
            scale * bins.mean,
            2.0 * scale * bins.deviation,
            fmt='o-' if side.joined else 'o',
            color=COLOURS[direction],
            label=NAMES[direction],
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


def _add_legend(figure: Figure) -> None:
    """Add a legend of what is drawn anywhere in the figure; a curve and its band are one mark."""
    marks: dict[str, dict[type, Any]] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            marks.setdefault(label, {}).setdefault(type(handle), handle)
    handles: list[Any] = [tuple(kinds.values()) for kinds in marks.values()]
    figure.legend(
        handles,
        list(marks),
        loc='outside lower center',
        ncols=4,
        fontsize=8,
        columnspacing=1.4,
    )
