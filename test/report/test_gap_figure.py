"""The picture of the gap: friction without its noise, numbers that no line crosses."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.metrics import AnalysedRun, analyse_run, compare_signals
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.report.improvement_figures import GAP_SIGNALS, draw_gap, smoothed
from pneu_rig_ros.rig import load_configuration

INTERVAL = 1.16e-3
RIG = load_configuration('cylinder_1')
NOISE = {'position': 3e-5, 'pressure_1': 2e2, 'friction': 1.0}


def run(seed: int, bias: float = 0.0) -> AnalysedRun:
    """Return three seconds at rest with the noise of the rig, pressure p1 off by a bias [Pa]."""
    noise = np.random.default_rng(seed).normal(size=(3, 2600))
    x = 0.05 + 2e-5 * noise[0]
    p1, p2 = 1.1e5 + bias + 150.0 * noise[1], 1e5 + 150.0 * noise[2]
    signals = {'position': x, 'pressure_1': p1, 'pressure_2': p2}
    interval = round(1e9 * INTERVAL)
    return analyse_run(Recording(str(seed), 0, interval, signals, configuration=RIG))


def drawn_gap(path: Path, monkeypatch: pytest.MonkeyPatch, bias: float) -> Figure:
    measured, models = run(1), (run(2, bias), run(3))
    before, after = (compare_signals(measured.signals, one.signals, NOISE) for one in models)
    figures: list[Figure] = []
    monkeypatch.setattr(Figure, 'savefig', lambda figure, *_, **__: figures.append(figure))
    draw_gap(path, measured, models, (before, after))
    figures[0].canvas.draw()
    return figures[0]


def heights(line: Line2D) -> Floats:
    return np.asarray(line.get_ydata(), dtype=np.float64)


def test_friction_is_drawn_without_most_of_its_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figure = drawn_gap(tmp_path / 'gap.png', monkeypatch, 1e3)
    curves = [heights(line) for line in figure.axes[2 * GAP_SIGNALS.index('friction')].get_lines()]
    whole = run(1).signals['friction']
    assert curves[0].shape == whole.shape
    assert np.std(curves[0]) < 0.3 * np.std(whole)
    assert np.mean(curves[1] - curves[2]) == pytest.approx(
        1e3 * ForceBalance.of(RIG).area_1, abs=0.05
    )


def test_smoothing_keeps_levels_and_shifts_nothing() -> None:
    time = INTERVAL * np.arange(2600)
    slow = 3.0 + np.sin(2.0 * np.pi * 0.5 * time)
    assert smoothed(slow, INTERVAL) == pytest.approx(slow, abs=0.05)
    assert smoothed(slow[:5], INTERVAL).shape == (5,)


@pytest.mark.parametrize('bias', [0.0, 250.0, 1e3, 1e4])
def test_no_number_stands_on_the_line_of_the_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bias: float
) -> None:
    for bars in drawn_gap(tmp_path / 'gap.png', monkeypatch, bias).axes[1::2]:
        (line,) = bars.get_lines()
        height = bars.transData.transform((0.0, heights(line)[0]))[1]
        for number in bars.texts:
            box = number.get_window_extent()
            assert not box.y0 <= height <= box.y1, number.get_text()
