"""The picture is a small PNG with four panels, drawn without a display; long curves are short."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.report.figure import draw_stroke, title_of
from pneu_rig_ros.report.page import data_address
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate


@pytest.fixture(scope='module')
def record(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    configuration = load_configuration('cylinder_2', supply_pressure=6e5)
    return read_recording(
        simulate(configuration, 0.34, 10.0, tmp_path_factory.mktemp('b') / 'bag')
    )


def test_picture_is_a_small_png(record: Recording, tmp_path: Path) -> None:
    path = draw_stroke(record, tmp_path / 'stroke.png')
    assert 20_000 < path.stat().st_size < 200_000
    pixels = imread(path)
    assert pixels.shape[:2] == (912, 960)
    assert np.ptp(pixels[..., :3]) > 0.9


def test_panels_are_those_of_the_paper(
    record: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(Figure, 'savefig', lambda figure, *_, **__: drawn.append(figure))
    draw_stroke(record, tmp_path / 'stroke.png')
    axes = drawn[0].axes
    assert [panel.get_ylabel() for panel in axes] == [
        'position [mm]',
        'velocity [mm/s]',
        'pressure [bar abs]',
        'friction force [N]',
    ]
    assert axes[3].get_xlabel() == 'time [s]'
    np.testing.assert_allclose(axes[0].lines[0].get_ydata(), 1e3 * record.position)
    np.testing.assert_allclose(axes[2].lines[1].get_ydata(), 1e-5 * record.pressure_2)


def test_title_names_the_operating_point(record: Recording) -> None:
    assert title_of(record).startswith('Cylinder 2: u = 0.34 V, $p_s$ = 6 bar abs, load 0.2 kg')


def test_unwritable_path_is_told_in_one_line(record: Recording, tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r'cannot write the picture .*: No such file'):
        draw_stroke(record, tmp_path / 'nowhere' / 'stroke.png')


def test_long_curve_is_short_on_a_page_and_keeps_its_extremes() -> None:
    values = np.random.default_rng(0).standard_normal(600_000)
    values[123_456], values[345_678] = 50.0, -50.0
    figure = Figure(layout='none')
    axes = figure.subplots()
    (line,) = axes.plot(values)
    line.set_gid('curve')
    address = data_address(figure)
    assert len(address) < 250_000
    svg = base64.b64decode(address.partition(',')[2]).decode()
    curve = re.search(r'<g id="curve">\s*<path d="([^"]*)"', svg)
    assert curve is not None
    heights = [float(pair.split()[2]) for pair in curve[1].strip().split('\n')]
    height = 72.0 * figure.get_figheight() * axes.get_position().height
    assert np.ptp(heights) == pytest.approx(height / 1.1, abs=0.5)  # with margins of 5 %
