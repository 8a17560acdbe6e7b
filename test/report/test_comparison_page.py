"""The page of two runs: self-contained, with every metric and cycle."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.analysis.comparison import (
    Comparison,
    compare_with_bag,
    compare_with_model,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.conversion import write_bag
from pneu_rig_ros.records.recording import WHOLE
from pneu_rig_ros.report.comparison_page import (
    SIGNAL_HEADS,
    detail,
    draw_cycles,
    signal_rows,
    write_page,
)
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven seconds of cylinder 2: more cycles than the detail shows."""
    configuration = load_configuration('cylinder_2')
    return simulate(configuration, 0.34, 12.0, tmp_path_factory.mktemp('bags') / 'measured')


@pytest.fixture(scope='module')
def still(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A second in which nothing moves."""
    folder = tmp_path_factory.mktemp('bags')
    return simulate(load_configuration('cylinder_2'), 0.0, 1.0, folder / 'still')


@pytest.fixture(scope='module')
def comparison(bag: Path) -> Comparison:
    return compare_with_model(bag, load_configuration('cylinder_2', friction='lugre'), 'a <model>')


@pytest.mark.filterwarnings('error')
def test_page_is_whole_and_needs_nothing_else(comparison: Comparison, tmp_path: Path) -> None:
    told: list[int] = []
    text = write_page(tmp_path / 'page.html', comparison, told.append).read_text()
    assert told == [1, 2, 3, 4]
    assert text.count('<img src="data:image/svg+xml;base64,') == 4
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert 'a &lt;model&gt;' in text
    for signal, rmse, *_ in signal_rows(comparison):
        assert f'<td>{signal}</td><td class="number">{rmse}</td>' in text
    for cycle in comparison.measured.cycles:
        assert f'{cycle.breakaway_time:.3f}' in text
    assert list(tmp_path.iterdir()) == [tmp_path / 'page.html']


def test_metrics_are_shown_in_the_units_of_people(comparison: Comparison) -> None:
    position, pressure = comparison.gaps['position'], comparison.gaps['pressure_1']
    rows = {
        signal: dict(zip(SIGNAL_HEADS[1:], texts, strict=True))
        for signal, *texts in signal_rows(comparison)
    }
    first, second = rows['position'], rows['pressure 1']
    assert float(first['>RMSE']) == pytest.approx(1e3 * position.rmse, rel=5e-3)
    assert (first['unit'], second['unit']) == ('mm', 'kPa')
    assert float(second['>bias']) == pytest.approx(1e-3 * pressure.bias, rel=5e-3)
    assert position.multiple is not None
    assert float(first['>RMSE / noise']) == pytest.approx(position.multiple, abs=0.05)


def test_bag_against_itself_is_no_gap(still: Path, bag: Path, tmp_path: Path) -> None:
    same = compare_with_bag(bag, bag)
    assert all(gap.largest == 0.0 for gap in same.gaps.values())
    assert same.shift == 0.0
    resting = compare_with_bag(still, still)
    assert 'Second bag' in write_page(tmp_path / 'page.html', resting).read_text()


def test_shift_moves_the_second_bag(bag: Path) -> None:
    moved = compare_with_bag(bag, bag, shift=0.116)
    first, second = (side.recording.position for side in (moved.measured, moved.simulated))
    np.testing.assert_allclose(first[100:], second[:-100], atol=1e-9)


def test_conditions_are_those_of_the_bag(bag: Path) -> None:
    other = load_configuration('cylinder_2', load_mass=5.0, supply_pressure=7e5)
    comparison = compare_with_model(bag, other)
    values = comparison.conditions
    assert (values['load_mass'], values['supply_pressure']) == (0.2, 4e5)
    assert set(values) <= set(comparison.measured.recording.conditions)
    assert len(comparison.measured.cycles) == len(comparison.simulated.cycles)


def test_bag_without_voltages_drives_no_model(bag: Path, tmp_path: Path) -> None:
    whole = read_recording(bag)
    signals = {name: whole[name] for name in WHOLE}
    write_bag(replace(whole, signals=signals), tmp_path / 'undriven')
    with pytest.raises(RigError, match='no valve_voltages recorded'):
        compare_with_model(tmp_path / 'undriven', load_configuration('cylinder_2'))
    gaps = compare_with_bag(tmp_path / 'undriven', bag).gaps
    assert gaps['pressure_1'].largest == 0.0


def test_detail_holds_the_first_cycles(comparison: Comparison) -> None:
    span = detail(comparison)
    assert span is not None
    times = [cycle.breakaway_time for cycle in comparison.measured.cycles]
    assert span[0] < times[0]
    assert times[2] < span[1] < comparison.measured.recording.duration + 1e-9


def test_run_without_cycles_has_no_picture_of_them(still: Path, tmp_path: Path) -> None:
    comparison = compare_with_model(still, load_configuration('cylinder_2'))
    assert draw_cycles(comparison) is None
    assert 'Stick-slip cycles' not in write_page(tmp_path / 'page.html', comparison).read_text()


def test_page_that_cannot_be_written(still: Path, tmp_path: Path) -> None:
    with pytest.raises(RigError, match='cannot write '):
        write_page(tmp_path / 'none' / 'page.html', compare_with_bag(still, still))
