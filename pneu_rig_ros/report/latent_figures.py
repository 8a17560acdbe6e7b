"""Pictures of the latent input of a balance: over time, and against what it depends on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.latent import Latent, smooth
from pneu_rig_ros.diagnosis.windows import BREAKAWAY, Windows, windows_of
from pneu_rig_ros.report.dependence import COLOURS, NAMES, SYMBOLS, Dependence, dependence
from pneu_rig_ros.report.diagnosis_rows import UNITS
from pneu_rig_ros.report.figure import BLUE, GREY, STYLE

Floats = NDArray[np.float64]
Spans = Sequence[tuple[float, float]]

SHADE, BAND, GREEN = '#f6e7c8', 0.25, '#2c8a5a'
MOST_RECORDINGS = 6
"""Recordings that are drawn: those that disagree most."""
SMALL = 0.3
"""Curves below it are drawn in a smaller unit [mg/s]."""
PAUSE = 0.3
"""Windows farther apart are not joined by a line [s]."""
SHOWN, BEYOND = 97.0, 1.6
"""The scale of a panel shows so many times this percentile of the latent input and its band."""


@dataclass(frozen=True)
class Track:
    """
    The latent input of a balance in one recording.

    :param windows: with a hypothesis
    :param explained: what the explanation contributes to each window [unit], None without one
    :param breakaways: of the piston, for the force
    :param dwell: rest before each breakaway [s]
    :param duration: of the recording [s]
    """

    windows: Windows | None
    explained: Floats | None
    breakaways: Windows | None
    dwell: Floats
    name: str
    duration: float

    @cached_property
    def latent(self) -> Latent | None:
        """The latent input, None where no window says anything."""
        return None if self.windows is None else smooth(self.windows)


def tracks_of(
    dataset: Dataset, hypothesis: Hypothesis, improved: Hypothesis | None
) -> dict[str, list[Track]]:
    """
    Return balance -> the latent input with a hypothesis in each recording.

    :param improved: the hypothesis with the explanation, None without one
    """
    windows = windows_of(dataset, hypothesis)
    others = None if improved is None else windows_of(dataset, improved)
    explained = {} if others is None else {
        _key(one): one.residual - other.residual
        for one, other in zip(windows, others, strict=True)
    }  # fmt: skip
    every = {_key(one): one for one in windows}
    balances = dict.fromkeys(one.balance for one in windows)
    return {
        balance: [_track(one, balance, every, explained) for one in dataset.comparisons]
        for balance in balances
    }


def _key(windows: Windows) -> tuple[str, str, bool]:
    return windows.balance, windows.recording, _breaks_away(windows)


def _breaks_away(windows: Windows) -> bool:
    return windows.balance == 'force' and windows.regime[0] == BREAKAWAY


def _track(
    comparison: Comparison, balance: str, every: Mapping[Any, Windows],
    explained: Mapping[Any, Floats],
) -> Track:  # fmt: skip
    run = comparison.run
    key = balance, run.name, False
    breakaways = every.get((balance, run.name, True))
    dwell = np.zeros(0) if breakaways is None else dwells(comparison, breakaways)
    return Track(every.get(key), explained.get(key), breakaways, dwell, run.name,
                 run.size * run.interval)  # fmt: skip


def dwells(comparison: Comparison, breakaways: Windows) -> Floats:
    """Return how long the piston had rested before each breakaway [s]."""
    run = comparison.run
    ends = np.round(breakaways.middle / run.interval)
    times = []
    for end in ends:
        rest = min(run.rests, key=lambda one: abs(one.end - end))
        before = run.operation.rest_time if rest.first == 0 else 0.0
        times.append(before + (rest.end - rest.first) * run.interval)
    return np.array(times)


def draw_latent(balance: str, tracks: Sequence[Track], spans: Mapping[str, Spans]) -> Figure:
    """
    Return the latent input over the time of each recording, and beside it what it depends on.

    :param spans: recording -> from, to [s] where it is significant
    """
    shown = most_off(tracks)
    unit, scale = unit_of(balance, shown)
    sides = [one for one in dependence(tracks) if one is not None]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.8, max(1.15 * len(shown), 2.4) + 0.9), layout='constrained')
        left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=(2.3, 1.0))[0]
        panels = left.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axes, track in zip(panels, shown, strict=True):
            _over_time(axes, track, scale, spans.get(track.name, ()))
        panels[-1].set_xlim(0.0, max(one.duration for one in shown))
        panels[-1].set_xlabel('time [s]')
        left.supylabel(f'latent input [{unit}]', fontsize=9)
        if sides:
            for axes, side in zip(right.subplots(len(sides), 1, squeeze=False)[:, 0], sides,
                                  strict=True):  # fmt: skip
                _against(axes, side, unit, scale)
        _legend(figure, shown, spans, {name for side in sides for name in side.bins})
    return figure


def most_off(tracks: Sequence[Track]) -> list[Track]:
    """Return the recordings whose latent input is largest in its noise, in their order."""
    known = [one for one in tracks if one.windows is not None or one.breakaways is not None]

    def off(track: Track) -> float:
        both = [w.whitened for w in (track.windows, track.breakaways) if w is not None]
        return float(np.mean(np.concatenate(both) ** 2))

    chosen = sorted(known, key=off, reverse=True)[:MOST_RECORDINGS]
    return [one for one in known if one in chosen]


def unit_of(balance: str, tracks: Sequence[Track]) -> tuple[str, float]:
    """Return the unit for people and how many of it are one SI unit."""
    if balance == 'force':
        return 'N', 1.0
    unit, scale = UNITS['kg/s']
    small = scale * max(half_height(one) for one in tracks) < SMALL
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


def _over_time(axes: Axes, track: Track, scale: float, spans: Spans) -> None:
    for begin, end in spans:
        axes.axvspan(begin, end, color=SHADE, linewidth=0, zorder=0)
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    if track.latent is not None:
        _curve(axes, track, track.latent, scale)
    if (breaks := track.breakaways) is not None:
        axes.errorbar(breaks.middle, scale * breaks.residual, 2.0 * scale * breaks.deviation,
                      fmt='o', color=BLUE, markersize=3.2, elinewidth=0.8,
                      markerfacecolor='white', zorder=3)  # fmt: skip
    height = scale * half_height(track)
    axes.set_ylim(-height, height)
    axes.set_title(track.name, fontsize=8, loc='left', pad=2)
    axes.tick_params(length=3, labelsize=8)


def _curve(axes: Axes, track: Track, latent: Latent, scale: float) -> None:
    """Draw the latent input with its band, broken where no window says anything."""
    mean, half = scale * latent.mean, 2.0 * scale * latent.deviation
    for part in connected(latent.time):
        time = latent.time[part]
        axes.fill_between(time, (mean - half)[part], (mean + half)[part], color=BLUE,
                          alpha=BAND, linewidth=0)  # fmt: skip
        axes.plot(time, mean[part], color=BLUE)
        if track.explained is not None:
            explained = scale * latent.levelled(latent.average @ track.explained)
            axes.plot(time, explained[part], color=GREEN, linewidth=1.2, linestyle=(0, (4, 2)))


def connected(time: Floats) -> Iterator[slice]:
    """Yield the stretches between longer pauses."""
    pauses = np.flatnonzero(np.diff(time) > max(PAUSE, 3.0 * float(np.median(np.diff(time)))))
    edges = [0, *(pauses + 1), time.size] if time.size > 1 else [0, time.size]
    for begin, end in pairwise(edges):
        yield slice(int(begin), int(end))


def _against(axes: Axes, side: Dependence, unit: str, scale: float) -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    for direction, bins in side.bins.items():
        axes.errorbar(side.scale * bins.middle, scale * bins.mean, 2.0 * scale * bins.deviation,
                      fmt='o-' if side.joined else 'o', color=COLOURS[direction],
                      markersize=3.2, linewidth=0.9, elinewidth=0.8, capsize=1.5)  # fmt: skip
    if side.logarithmic:
        axes.set_xscale('log')
    axes.set_title(side.title, fontsize=8, loc='left', pad=2)
    axes.set_xlabel(f'{SYMBOLS[side.variable]} [{side.unit}]', fontsize=8)
    axes.set_ylabel(f'[{unit}]', fontsize=8)
    axes.tick_params(length=3, labelsize=8)


def _legend(
    figure: Figure, tracks: Sequence[Track], spans: Mapping[str, Spans], directions: set[str]
) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    marks: dict[str, Any] = {
        'latent input, ±2 standard deviations': (Patch(color=BLUE, alpha=BAND),
                                                 Line2D([], [], color=BLUE)),
    }  # fmt: skip
    if any(one.explained is not None for one in tracks):
        marks['the explanation'] = Line2D([], [], color=GREEN, linestyle=(0, (4, 2)))
    if any(spans.values()):
        marks['above the noise'] = Patch(color=SHADE)
    if any(one.breakaways is not None for one in tracks):
        marks['breakaway'] = Line2D([], [], color=BLUE, marker='o', linestyle='',
                                    markerfacecolor='white', markersize=4)  # fmt: skip
    for direction in sorted(directions, reverse=True):
        marks[NAMES[direction]] = Line2D(
            [], [], color=COLOURS[direction], marker='o', markersize=4
        )
    figure.legend(list(marks.values()), list(marks), loc='outside lower center', ncols=4,
                  frameon=False, fontsize=8, columnspacing=1.4)  # fmt: skip
