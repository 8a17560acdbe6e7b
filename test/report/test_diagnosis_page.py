"""The page of a diagnosis: what it draws is what was found."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from terminal import Terminal

from pneu_rig_ros.cli.diagnosis import show
from pneu_rig_ros.diagnosis.inputs.system import load_system
from pneu_rig_ros.diagnosis.residuals.latent import smooth
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import Diagnosis
from pneu_rig_ros.errors import printable
from pneu_rig_ros.report.dependence import dependence
from pneu_rig_ros.report.diagnosis_page import spans_of
from pneu_rig_ros.report.improvement_figures import GIVEN, IMPROVED, MEASURED, runs_of
from pneu_rig_ros.report.latent_figures import Track, broken, draw_latent, tracks_of

HOSTILE = (
    '<script>alert(1)<∕script>',
    'x\x1b[2J\x1b]0;owned\x07',
    os.fsdecode(b'$\\frac{$ [red] :bug: {{ 7 * 7 }} \xff'),
)
NOTE = '2 wrong position readings replaced'
GAUGES, SLOPE = (1e5, 4e5), 1e-5


@pytest.fixture(scope='module')
def tracks(bench: Diagnosis) -> list[Track]:
    """Return the recordings of the force balance without and with its latent input."""
    return tracks_of(bench.training, bench.given, None)['force']


@pytest.fixture(scope='module')
def explained(bench: Diagnosis) -> list[Track]:
    """Return the recordings with what the answer explains of the latent input."""
    return tracks_of(bench.training, bench.given, bench.improved)['force']


def test_latent_input_is_what_the_seal_rubs_more(bench: Diagnosis) -> None:
    for windows, gauge in zip(bench.windows, GAUGES, strict=True):
        latent = smooth(windows)
        direction = np.where(windows.direction == 'out', 1.0, -1.0)
        settled = np.abs(windows.variables['velocity']) > 9e-3
        for way in (1.0, -1.0):  # against the outstroke when moving out
            found = float(np.median(latent.mean[settled & (direction == way)]))
            assert found == pytest.approx(-way * SLOPE * gauge, rel=0.1)
        assert np.median(latent.deviation) < 0.1 * SLOPE * gauge


def test_band_of_noise_alone_has_its_width(bench: Diagnosis) -> None:
    windows = bench.windows[0]
    rng = np.random.default_rng(1)
    inside = []
    for _ in range(3):
        band = windows.whiten.band
        white = rng.normal(size=windows.residual.size)
        own = band[0] * white
        for lag in range(1, len(band)):
            own[lag:] += band[lag, :-lag] * white[:-lag]
        latent = smooth(replace(windows, residual=windows.factor * own))
        inside.append(float(np.mean(np.abs(latent.mean) < 2.0 * latent.deviation)))
    assert np.mean(inside) > 0.9


def test_pressure_is_what_it_depends_on(tracks: list[Track]) -> None:
    (side,) = dependence(tracks)
    assert side.variable == 'pressure_2'
    assert set(side.bins) == {'out', 'in'}
    assert np.all(np.diff(side.bins['in'].mean) > 0.0)
    assert np.all(np.diff(side.bins['out'].mean) < 0.0)


def test_explanation_is_drawn_over_the_latent_input(explained: list[Track]) -> None:
    track, _ = explained
    assert track.latent is not None
    assert track.explained is not None
    explained = track.latent.levelled(track.explained)
    assert np.corrcoef(track.latent.mean, explained)[0, 1] > 0.98


def test_significant_stretches_are_shaded(bench: Diagnosis, explained: list[Track]) -> None:
    data = answer(bench)
    spans = spans_of(data, 'force')
    assert set(spans) == {'run_0', 'run_1'}
    figure = draw_latent('force', explained, spans, bench.significant)
    assert isinstance(figure, Figure)
    significant = [span for one in bench.significant for span in one.intervals]
    for axes, name in zip(figure.axes[:2], ('run_0', 'run_1'), strict=True):
        stretches = [span for span in significant if span[0] == name]
        assert stretches
        assert len(axes.patches) == len(spans[name]) + len(stretches)


@pytest.mark.parametrize('signal', ['pressure_2', 'velocity', 'dwell'])
def test_significant_parts_of_a_range_are_shaded_against_their_signal(
    bench: Diagnosis, tracks: list[Track], signal: str
) -> None:
    dwelling = []
    for track in tracks:
        assert track.windows is not None
        columns = track.windows.variables | {'dwell': track.windows.middle}
        dwelling.append(replace(track, windows=replace(track.windows, variables=columns)))
    low, high = np.quantile(dwelling[0].windows.variables[signal], (0.2, 0.6))  # type: ignore[union-attr]
    first = replace(bench.significant[0], parts=((signal, float(low), float(high)),))
    sides = dependence(dwelling, [first])
    assert [side.variable for side in sides] == list(dict.fromkeys(['pressure_2', signal]))
    figure = draw_latent('force', dwelling, {}, [first])
    shades = [len(axes.patches) for axes in figure.axes[len(dwelling) :]]
    assert shades == [0] * (len(sides) - 1) + [1]


def test_significant_parts_are_in_the_answer(bench: Diagnosis) -> None:
    first, *_ = answer(bench)['where']
    parts = [(part['variable'], part['from'], part['to']) for part in first['parts']]
    assert parts == list(bench.significant[0].parts)
    assert {name for name, _, _ in parts} <= {'position', 'velocity', 'pressure_1', 'pressure_2'}
    assert 'pressure_2' in {name for name, _, _ in parts}


def test_dwell_is_drawn_of_what_rests_alone(bench: Diagnosis, tracks: list[Track]) -> None:
    track, _ = tracks
    assert track.windows is not None
    rests = track.windows.middle < 6.0
    regime = np.where(rests, 'dwell', 'sliding')
    columns = track.windows.variables | {'dwell': np.where(rests, track.windows.middle, np.nan)}
    windows = replace(
        track.windows,
        variables=columns,
        regime=regime,
        direction=np.where(rests, '', track.windows.direction),
    )
    first = replace(bench.significant[0], regime='dwell', parts=(('dwell', 1.0, 3.0),))
    side = dependence([replace(track, windows=windows)], [first])[-1]
    assert (side.variable, set(side.bins)) == ('dwell', {''})
    assert side.title.startswith('at rest')
    assert side.bins[''].middle.max() < 6.0


def test_nothing_stands_beside_what_depends_on_nothing(tracks: list[Track]) -> None:
    track, _ = tracks
    assert track.windows is not None
    constant = {name: np.zeros_like(v) for name, v in track.windows.variables.items()}
    residual = np.zeros_like(track.windows.residual)
    vessel = replace(track, windows=replace(track.windows, variables=constant, residual=residual))
    assert len(draw_latent('force', [track], {}).axes) == 2
    assert len(draw_latent('force', [vessel], {}).axes) == 1


def test_curve_breaks_where_no_window_says_anything() -> None:
    time = np.concatenate([np.arange(0.0, 1.0, 0.05), np.arange(3.0, 4.0, 0.05)])
    expected = np.insert(time, 20, np.nan)
    np.testing.assert_array_equal(broken(time, 2.0 * time), [expected, 2.0 * expected])


def test_improved_model_is_nearer_along_the_measured_motion(bench: Diagnosis) -> None:
    (comparison,) = bench.held_out.comparisons
    runs = runs_of(comparison, bench.given, bench.improved).signals
    assert list(runs) == [MEASURED, GIVEN, IMPROVED]
    assert list(runs[MEASURED]) == ['force']
    off = {
        name: float(np.std(run['force'] - runs[MEASURED]['force'])) for name, run in runs.items()
    }
    assert off[IMPROVED] < 0.3 * off[GIVEN]


def check_files(folder: Path, bench: Diagnosis, capsys: pytest.CaptureFixture[str]) -> None:
    """Check that the files of an answer are whole, that the model loads, and what is shown."""
    data = answer(bench)
    assert sorted(path.name for path in folder.iterdir()) == [
        'diagnosis.json',
        'improved.yaml',
        'report.html',
    ]
    assert json.loads((folder / 'diagnosis.json').read_text())['verdict'] == 'effect'
    assert load_system(folder / 'improved.yaml').hypothesis == bench.improved
    page = (folder / 'report.html').read_text()
    assert data['sentence'].split(' (')[0] in page
    assert len(re.findall('<img src="data:image/svg', page)) >= 3
    assert 'no signal pressure_1' in page or 'no cylinder.cap_dead_volume' in page
    assert data['notes'] == [{'recording': 'run_1', 'note': NOTE}]
    assert f'<li>run_1: {NOTE}</li>' in page
    assert '<h2>Each recording</h2>' not in page  # names no clock and no initial temperature
    show(data, folder)
    _check_terminal(capsys.readouterr().out, folder)


def test_command_says_what_the_python_call_finds(
    bench_files: Any,
    bench: Diagnosis,
    tmp_path: Path,
    terminal: Terminal,
    capsys: pytest.CaptureFixture[str],
) -> None:
    tables, system = bench_files.tables, ['--model', bench_files.system, '--workers', 1]
    words = ['diagnose', *tables[:2], '--verify', tables[2], '--map', bench_files.mapping, *system]
    printed = json.loads(terminal.output(*words, '--out', 'answer', '--json'))
    assert printed == json.loads((tmp_path / 'answer' / 'diagnosis.json').read_text())
    expected = json.loads(json.dumps(answer(bench)))
    assert {**printed, 'seconds': 0.0} == {**expected, 'seconds': 0.0}
    check_files(tmp_path / 'answer', bench, capsys)
    assert 'is not empty' in terminal.refusal(*words, '--out', 'answer')
    terminal.refusal(*words, '--without', 'pressure_dependant', '--out', 'b')
    assert list(tmp_path.iterdir()) == [tmp_path / 'answer']


def test_names_of_files_are_text(bench_files: Any, tmp_path: Path, terminal: Terminal) -> None:
    tables = [tmp_path / f'{name}.csv' for name in HOSTILE]
    for table, source in zip(tables, bench_files.tables, strict=True):
        table.write_bytes(source.read_bytes())
    system = tmp_path / f'{HOSTILE[0]}.yaml'
    system.write_text(bench_files.system.read_text().replace('name: seal', 'name: "<i>[/]"'))
    words = [*tables[:2], '--verify', tables[2], '--model', system, '--map', bench_files.mapping]
    shown = terminal.output('diagnose', *words, '--workers', 1, '--out', 'answer')
    assert all(line.isprintable() for line in shown.split('\n'))
    page = (tmp_path / 'answer' / 'report.html').read_text()
    assert '<script' not in page
    assert '<i>[/]' not in page
    assert all(escape(printable(name)) in page for name in HOSTILE[::2])


def _check_terminal(text: str, folder: Path) -> None:
    assert 'pressure_dependent_friction' in text
    assert re.search(r'gas_1 +closed: no ', text)
    assert re.search(r'force +sliding in', text)
    assert 'RMSE along the measured motion on run_2' in text
    assert re.search(f'notes +run_1: {NOTE}', text)
    assert 'RMSE in a free run' not in text  # of a system that is not a rig
    assert re.search('gap of +the balances of mass and force', text)
    assert str(folder / 'report.html') in text.replace('\n', '')
