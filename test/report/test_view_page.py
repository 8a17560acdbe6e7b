"""The page of a bag, in a browser: curves, zoom, cursor, cylinder, cycles; small and complete."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.analysis.motion import cycles_of
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.report import view_page
from pneu_rig_ros.report.view_page import facts, thinned, write_view
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

COLOURED = """
index => {
  const { ctx, bbox } = stack.charts[index];
  const { data } = ctx.getImageData(bbox.left, bbox.top + 8, bbox.width, bbox.height - 8);
  const columns = new Set();
  for (let k = 0; k < data.length; k += 4) {
    const [r, g, b] = data.subarray(k, k + 3);
    const off = Math.abs(r - 31) + Math.abs(g - 90) + Math.abs(b - 148);
    if (off < 40) columns.add((k / 4) % Math.round(bbox.width));
  }
  return columns.size / bbox.width;
}
"""
"""Share of the width of a chart in which its first curve is seen [-]."""

CHARTS = 5


pytestmark = pytest.mark.xdist_group('view')  # one browser, one record


@pytest.fixture(scope='module')
def record(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Seven seconds of cylinder 2."""
    path = tmp_path_factory.mktemp('bags') / 'stroke'
    return read_recording(simulate(load_configuration('cylinder_2'), 0.34, 7.0, path))


@pytest.fixture
def shown(open_page: Callable[[str], Any], tmp_path: Path) -> Callable[..., Any]:
    """Write the page of a record and open it."""

    def show(record: Recording, **options: Any) -> Any:
        write_view(tmp_path / 'page.html', record, 'a <stroke>', **options)
        page = open_page((tmp_path / 'page.html').as_uri())
        until(page, 'stack.charts.every(chart => chart.status === 1)')
        return page

    return show


def until(page: Any, condition: str) -> None:
    """Wait for an expression to hold; the page itself may not evaluate texts."""
    deadline = time.monotonic() + 20.0
    while not page.evaluate(condition):
        assert time.monotonic() < deadline, condition
        page.wait_for_timeout(20)


def reading(page: Any, name: str) -> float:
    return float(page.locator(f'[data-reading={name}]').inner_text())


def visible(page: Any) -> list[list[float]]:
    """Return what each chart shows, [from, to] of its time axis."""
    return page.evaluate('stack.charts.map(({ scales: { x } }) => [x.min, x.max])')


def drag(page: Any, chart: int, start: float, end: float) -> None:
    """Drag over a chart from one share of its width to another."""
    box = page.locator('.u-over').nth(chart).bounding_box()
    y = box['y'] + box['height'] / 2
    page.mouse.move(box['x'] + start * box['width'], y)
    page.mouse.down()
    page.mouse.move(box['x'] + end * box['width'], y, steps=3)
    page.mouse.up()


def test_page_loads_and_every_chart_has_its_curve(record: Recording, shown: Any) -> None:
    page = shown(record)
    assert page.locator('h1').inner_text() == 'a <stroke>'
    assert page.evaluate('stack.charts.length') == CHARTS
    for chart in range(CHARTS):
        assert page.evaluate(f'({COLOURED})({chart})') > 0.9, chart
    assert page.evaluate('bag.signals.position.length') > 1000
    assert 'supply 4 bar abs' in page.locator('header').inner_text()


def test_drag_zooms_all_charts_and_double_click_shows_all(record: Recording, shown: Any) -> None:
    page = shown(record)
    whole = [[0.0, pytest.approx(record.duration)]] * CHARTS
    assert visible(page) == whole
    drag(page, 2, 0.25, 0.5)
    expected = pytest.approx([0.25 * record.duration, 0.5 * record.duration], abs=0.02)
    assert visible(page) == [expected] * CHARTS
    low, high = page.evaluate('[stack.charts[0].scales.y.min, stack.charts[0].scales.y.max]')
    part = 1e3 * record.position[(record.time > 1.75) & (record.time < 3.5)]
    margin = 0.1 * np.ptp(part)
    assert low == pytest.approx(part.min() - margin, abs=0.2)
    assert high == pytest.approx(part.max() + margin, abs=0.2)
    for chart in range(CHARTS):
        assert page.evaluate(f'({COLOURED})({chart})') > 0.9, chart
    page.locator('.u-over').nth(1).dblclick()
    assert visible(page) == whole


def test_wheel_zooms_about_the_cursor_with_ctrl_only(record: Recording, shown: Any) -> None:
    page = shown(record)
    page.locator('.u-over').nth(0).hover()
    page.mouse.wheel(0, -100)
    assert visible(page)[0] == [0.0, pytest.approx(record.duration)]
    page.keyboard.down('Control')
    page.mouse.wheel(0, -100)
    until(page, 'stack.range[0] > 0')
    page.keyboard.up('Control')
    start, stop = visible(page)[0]
    assert stop - start == pytest.approx(record.duration / 1.25)
    assert (start + stop) / 2 == pytest.approx(record.duration / 2, abs=0.02)


def test_cylinder_and_values_are_those_at_the_cursor(record: Recording, shown: Any) -> None:
    page = shown(record)
    friction = friction_of(record)
    for share in (0.3, 0.9):
        box = page.locator('.u-over').nth(3).bounding_box()
        page.mouse.move(box['x'] + share * box['width'], box['y'] + 20)
        k = round(page.evaluate('stack.time') / record.interval)
        assert k * record.interval == pytest.approx(share * record.duration, abs=0.02)
        assert reading(page, 'time') == pytest.approx(record.time[k], abs=1e-3)
        assert reading(page, 'position') == pytest.approx(1e3 * record.position[k], abs=6e-3)
        assert reading(page, 'pressure_1') == pytest.approx(record.pressure_1[k] / 1e5, abs=6e-4)
        assert reading(page, 'friction') == pytest.approx(friction[k], abs=0.06)
        piston = float(page.locator('svg.cylinder g').get_attribute('data-position'))
        assert piston == pytest.approx(max(1e3 * record.position[k], 0.0), abs=1e-3)
        valves = page.locator('svg.cylinder path[data-state]')
        states = [valves.nth(i).get_attribute('data-state') for i in (0, 1)]
        assert states == ['fills', 'empties']


def test_cycles_are_listed_and_lead_to_their_breakaway(record: Recording, shown: Any) -> None:
    page = shown(record)
    cycles = cycles_of(record, friction_of(record))
    rows = page.locator('.events tbody tr')
    assert rows.count() == len(cycles) >= 3
    assert f'{len(cycles)} stick-slip cycles' in page.locator('aside').inner_text()
    for k, cycle in enumerate(cycles):
        assert f'{cycle.breakaway_time:.3f}' in rows.nth(k).inner_text()
    rows.nth(2).click()
    assert page.evaluate('stack.time') == pytest.approx(cycles[2].breakaway_time)
    start, stop = visible(page)[0]
    assert start < cycles[2].breakaway_time < stop < start + 2.0
    assert 'near' in rows.nth(2).get_attribute('class')
    assert page.locator('#regime').inner_text() in ('dwell', 'presliding')


def test_keys_step_by_a_sample_and_play_runs_to_the_end(record: Recording, shown: Any) -> None:
    page = shown(record)
    before = page.evaluate('stack.time')
    page.keyboard.press('ArrowRight')
    assert page.evaluate('stack.time') - before == pytest.approx(record.interval)
    page.select_option('#speed', '4')
    drag(page, 0, 0.8, 0.9)
    end = visible(page)[0][1]
    page.click('#play')
    until(page, f'stack.time > {end} - 1e-6 && playing === null')
    assert reading(page, 'position') == pytest.approx(
        1e3 * record.position[round(end / record.interval)], abs=0.2
    )


def test_page_fits_a_narrow_screen(record: Recording, shown: Any) -> None:
    page = shown(record)
    page.set_viewport_size({'width': 420, 'height': 900})
    until(page, 'stack.charts[0].width < 420')
    assert page.evaluate('document.documentElement.scrollWidth') <= 420


def undriven(record: Recording) -> Recording:
    """Return the recording as if nobody had noted command and voltages."""
    names = {'u', 'voltage_1', 'voltage_2'}
    signals = {name: values for name, values in record.signals.items() if name not in names}
    return replace(record, signals=signals)


def test_rig_that_is_not_known_is_shown_without_friction(record: Recording, shown: Any) -> None:
    page = shown(undriven(replace(record, configuration=None)))
    assert page.evaluate('stack.charts.length') == 3
    assert 'does not say which rig' in page.locator('aside').inner_text()
    assert page.locator('.events tbody tr').count() >= 3


def test_part_of_a_record(record: Recording, shown: Any) -> None:
    page = shown(record, start=2.0, stop=3.0)
    assert visible(page)[0] == [0.0, pytest.approx(1.0, abs=record.interval)]
    first = page.evaluate('signals.position[0]')
    assert first == pytest.approx(record.position[round(2.0 / record.interval)], rel=1e-6)


def test_long_record_is_thinned_to_its_extremes_and_says_so(
    record: Recording, shown: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(view_page, 'MOST_POINTS', 1000)
    page = shown(record)
    assert 'Of every 13 samples' in page.locator('main').inner_text()
    peak, points = page.evaluate('[Math.max(...signals.velocity), signals.velocity.length]')
    assert (peak, points) == (pytest.approx(record.velocity.max(), rel=1e-6), 2 * -(-6035 // 13))
    assert page.evaluate('time.at(-1)') == pytest.approx(record.duration, abs=13 * 1.16e-3)


def test_facts_tell_the_operating_point(record: Recording) -> None:
    still, driven = np.full_like(record.voltage_1, 2.5), record.voltage_1
    assert 'u = 0.34 V' in facts(record.with_signals(voltage_1=2.5 + 0.34 + 0 * driven))
    assert 'u = 0.00 V' in facts(record.with_signals(voltage_1=still, voltage_2=still))
    assert 'supply 4 bar abs' in facts(record)
    assert facts(undriven(replace(record, configuration=None))) == [
        '7.00 s, a sample every 1.16 ms'
    ]


@pytest.mark.parametrize('times', [9, 90])
def test_page_stays_below_five_megabytes(record: Recording, tmp_path: Path, times: int) -> None:
    signals = {name: np.tile(values, times) for name, values in record.signals.items()}
    long = Recording('long', 0, record.interval_ns, signals, configuration=record.configuration)
    page = write_view(tmp_path / 'page.html', long, 'long')
    assert long.duration > 7 * times - 1
    assert page.stat().st_size < 5e6


def test_thinned_keeps_every_extreme_in_order() -> None:
    values = np.random.default_rng(1).standard_normal(1001)
    kept = thinned(values, 10)
    assert kept.size == 2 * 101
    for bucket in range(101):
        part = values[10 * bucket : 10 * bucket + 10]
        pair = kept[2 * bucket : 2 * bucket + 2]
        assert set(pair) == {part.min(), part.max()}
        assert (pair[0] == part.min()) == (part.argmin() <= part.argmax())
    assert thinned(values, 1) is values


@pytest.mark.parametrize(
    ('part', 'told'),
    [
        ((8.0, 9.0), r'no samples from 8 s on: the record ends at \d\.\d+ s$'),
        ((3.0, 2.0), 'under 2 samples from 3 to 2 s: the record goes from 0 to'),
        ((-2.0, -1.0), 'under 2 samples from -2 to -1 s'),
        ((2.0, 2.0), 'under 2 samples from 2 to 2 s'),
    ],
)
def test_part_without_samples_is_refused(
    record: Recording, tmp_path: Path, part: tuple[float, float], told: str
) -> None:
    with pytest.raises(RigError, match=told):
        write_view(tmp_path / 'page.html', record, 'none', *part)
    assert list(tmp_path.iterdir()) == []
