"""Pictures of the residuals of the balances: against time, velocity, position, pressure, dwell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.floors import noise_floor
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, block_means
from pneu_rig_ros.gap.regimes import REGIMES, block_regimes
from pneu_rig_ros.gap.where import SIGNIFICANT, Residual, residuals
from pneu_rig_ros.report.diagnosis_rows import UNITS
from pneu_rig_ros.report.figure import BLUE, GREY, ORANGE, STYLE

Floats = NDArray[np.float64]

REGIME_COLOURS = (GREY, '#a3195b', BLUE, ORANGE, '#2c8a5a')
"""Of dwell, breakaway, sliding out, sliding in, end stop."""
BAND = '#e9ebef'
SHOWN = 99.5
"""Percentile of the residuals that the scale shows; those beyond are drawn at its edge."""


@dataclass(frozen=True)
class Blocks:
    """
    A run's residuals and what they may depend on, block by block, each of shape (blocks,).

    :param residuals: one for each balance
    :param columns: time [s], velocity [m/s], position [m], p1 [Pa], p2 [Pa], dwell [s]
    :param regimes: indices of ``REGIMES``
    """

    name: str
    residuals: Sequence[Residual]
    columns: dict[str, Floats]
    regimes: NDArray[np.int8]
    duration: float


def blocks_of(hypothesis: Hypothesis, evidence: Evidence, seed: int) -> list[Blocks]:
    """
    Return the residuals of a hypothesis on some runs.

    :param seed: of the errors that make the noise floor
    """
    rng = np.random.default_rng(seed)
    return [_blocks(hypothesis, one, rng) for one in evidence.experiments]


def _blocks(
    hypothesis: Hypothesis, experiment: Experiment, rng: np.random.Generator
) -> Blocks:  # fmt: skip
    floor = noise_floor(hypothesis, experiment, Mode.CHAMBERS, rng)
    x, v, p1, p2 = block_means(experiment.measured[1:], experiment.block).T
    span = experiment.block * experiment.interval
    time = span * (np.arange(x.size) + 0.5)
    dwell = dwell_times(experiment)[1:][experiment.block // 2 :: experiment.block][: x.size]
    columns = {'time': time, 'velocity': v, 'position': x, 'p1': p1, 'p2': p2, 'dwell': dwell}
    stroke = hypothesis.model.cylinder.stroke
    return Blocks(
        experiment.name, residuals(hypothesis, experiment, floor), columns,
        block_regimes(experiment, stroke), x.size * span,
    )  # fmt: skip


def dwell_times(experiment: Experiment) -> Floats:
    """Return how long the piston has rested, or had before it slid [s], shape (n,)."""
    count = experiment.record.position.size
    dwell = np.full(count, np.nan)
    for rest in experiment.rests:
        before = experiment.operation.rest_time if rest.start == 0 else 0.0
        ticks = np.minimum(np.arange(count - rest.start), rest.end - rest.start)
        dwell[rest.start :] = before + experiment.interval * ticks
    return dwell


def draw_over_time(runs: Sequence[Blocks], scales: Sequence[float] | None = None) -> Figure:
    """
    Return the residuals over the time of all runs, one after the other, a panel a balance.

    :param scales: half the height of each panel [unit for people]; that of the residuals when
        not given
    """
    balances = len(runs[0].residuals)
    starts = np.cumsum([0.0, *(run.duration for run in runs)])
    time = np.concatenate([run.columns['time'] + t for run, t in zip(runs, starts, strict=False)])
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 1.9 * balances + 0.5), layout='constrained')
        panels = figure.subplots(balances, 1, sharex=True, squeeze=False)[:, 0]
        for index, axes in enumerate(panels):
            height = (scales or half_heights(runs))[index]
            _panel(axes, runs, index, time, height)
            axes.vlines(starts[1:-1], -height, height, color=GREY, linewidth=0.7)
            axes.set_ylabel(_label(runs[0].residuals[index]))
        for run, start in zip(runs, starts, strict=False):
            panels[0].text(start, 1.02, f' {run.name}', fontsize=8,
                           transform=panels[0].get_xaxis_transform())  # fmt: skip
        panels[-1].set_xlim(0.0, starts[-1])
        panels[-1].set_xlabel('time, one run after the other [s]')
        _legend(figure)
        figure.align_ylabels()
    return figure


def draw_dependence(runs: Sequence[Blocks]) -> Figure:
    """Return the residuals against velocity, position, pressure and dwell, a row a balance."""
    balances = len(runs[0].residuals)
    heights = half_heights(runs)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 1.9 * balances + 0.5), layout='constrained')
        grid = figure.subplots(balances, 4, sharey='row', sharex=False, squeeze=False)
        for index, row in enumerate(grid):
            for axes, (label, values) in zip(row, _causes(runs, index), strict=True):
                _panel(axes, runs, index, values, heights[index])
                axes.set_xlabel(label, fontsize=8)
                axes.tick_params(labelsize=8)
            if np.nanmin(values) > 0.0:  # dwell times span decades
                row[-1].set_xscale('log')
            row[0].set_ylabel(_label(runs[0].residuals[index]))
        _legend(figure)
        figure.align_ylabels()
    return figure


def _causes(runs: Sequence[Blocks], index: int) -> list[tuple[str, Floats]]:
    """Return label and values of what the residual of a balance may depend on."""

    def column(name: str, scale: float = 1.0) -> Floats:
        return scale * np.concatenate([run.columns[name] for run in runs])

    pressures = ('$p_1$', column('p1', 1e-5)), ('$p_2$', column('p2', 1e-5))
    label, pressure = (*pressures, ('$p_1 - p_2$', pressures[0][1] - pressures[1][1]))[index]
    return [
        ('velocity [mm/s]', column('velocity', 1e3)),
        ('position [mm]', column('position', 1e3)),
        (f'{label} [bar]', pressure),
        ('dwell [s]', np.maximum(column('dwell'), 1e-2)),
    ]


def half_heights(runs: Sequence[Blocks]) -> list[float]:
    """Return half the height of the panel of each balance [unit for people]."""
    heights = []
    for index in range(len(runs[0].residuals)):
        values, noise, _ = _joined(runs, index)
        known = np.abs(values[np.isfinite(values)])
        highest = float(np.percentile(known, SHOWN)) if known.size else 0.0
        heights.append(max(1.15 * highest, 2.0 * SIGNIFICANT * float(np.median(noise))))
    return heights


def _joined(runs: Sequence[Blocks], index: int) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """Return residuals, noise [unit for people] and regimes of all runs."""
    _, scale = UNITS.get(runs[0].residuals[index].unit, ('', 1.0))
    values = np.concatenate([scale * run.residuals[index].values for run in runs])
    noise = np.concatenate([scale * run.residuals[index].noise for run in runs])
    return values, noise, np.concatenate([run.regimes for run in runs])


def _panel(
    axes: Axes, runs: Sequence[Blocks], index: int, along: Floats, height: float
) -> None:  # fmt: skip
    values, noise, regimes = _joined(runs, index)
    band = SIGNIFICANT * float(np.median(noise))
    axes.axhspan(-band, band, color=BAND, linewidth=0, zorder=0)
    for code, colour in enumerate(REGIME_COLOURS):
        here = (regimes == code) & np.isfinite(values)
        shown = np.clip(values[here], -height, height)
        axes.plot(along[here], shown, '.', color=colour, markersize=2.2, rasterized=True)
    axes.set_ylim(-1.05 * height, 1.05 * height)
    axes.tick_params(length=3)


def _label(residual: Residual) -> str:
    unit, _ = UNITS.get(residual.unit, (residual.unit, 1.0))
    return f'{residual.balance}\n[{unit}]'


def _legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    marks: list[Line2D | Patch] = [
        Line2D([], [], color=colour, marker='o', linestyle='', markersize=4)
        for colour in REGIME_COLOURS
    ]
    names = [*REGIMES, f'within {SIGNIFICANT:g} times the noise']
    figure.legend([*marks, Patch(color=BAND)], names, loc='outside lower center', ncols=6,
                  frameon=False, fontsize=8, columnspacing=1.2, handletextpad=0.3)  # fmt: skip
