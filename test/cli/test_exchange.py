"""`pneu-rig import` and `pneu-rig export`."""

import contextlib
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from terminal import Terminal

from pneu_rig_ros.cli import output
from pneu_rig_ros.records import BagWriter, conversion

MAPPING = """
time: {column: "t [ms]", unit: ms}
position: {column: "x [mm]", unit: mm}
pressure_1: {column: "p_cap [bar]", unit: bar, gauge: true}
pressure_2: {column: 4, unit: bar, gauge: true}
u: {column: "u [V]"}
"""
HEADER = 't [ms];x [mm];p_cap [bar];p_rod [bar];u [V]'


def lines(bad: str = '') -> list[str]:
    """Return half a second of a DAQ export: semicolons, decimal commas, gauge pressures."""
    rows = [f'{1.16 * k:.2f};{0.02 * k:.3f};{0.004 * k:.4f};0.0100;0.34' for k in range(430)]
    if bad:
        rows[14] = bad
    return [HEADER, *(row.replace('.', ',') for row in rows)]


def prepare(terminal: Terminal, bad: str = '') -> None:
    folder = terminal.directory
    (folder / 'daq.csv').write_text('\n'.join(lines(bad)) + '\n', encoding='utf-8-sig')
    (folder / 'map.yaml').write_text(MAPPING)
    (folder / 'cond.yaml').write_text('supply_pressure: 4 bar gauge\nload_mass: 200 g\n')


def test_export_of_a_laboratory_becomes_a_bag(terminal: Terminal) -> None:
    prepare(terminal)
    known = ('--map', 'map.yaml', '--conditions', 'cond.yaml', '--cylinder', 'cylinder_2')
    done = terminal.output('import', 'daq.csv', *known, '--out', 'runs/measured')
    assert '430 every 1.16 ms, 0.50 s' in done
    assert 'supply_pressure 500000 Pa, load_mass 0.2 kg' in done
    summary = json.loads(terminal.output('info', 'runs/measured', '--json'))
    assert summary['cylinder'] == 'cylinder_2'
    assert (summary['friction_model'], summary['seed']) == ('unknown', 'unknown')
    assert 'cylinder_2, imported from daq.csv' in terminal.output('info', 'runs/measured')
    assert summary['samples'] == 430
    assert abs(summary['travel'] - 0.02e-3 * 429) < 1e-9
    terminal.output('friction', 'runs/measured', '--json')


def test_wrong_file_is_one_line_and_leaves_nothing(terminal: Terminal) -> None:
    prepare(terminal, bad='16.24;abc;0.1;0.1;0.34')
    line = terminal.refusal('import', 'daq.csv', '--map', 'map.yaml', '--out', 'runs/measured')
    assert line == "daq.csv: row 16, column 'x [mm]': 'abc' is not a finite number"
    assert not (terminal.directory / 'runs').exists()


def test_interrupted_import_leaves_nothing(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepare(terminal)
    before = set(terminal.directory.iterdir())

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(BagWriter, 'close', interrupted)
    done = terminal.run('import', 'daq.csv', '--map', 'map.yaml', '--out', 'a/b/bag')
    assert done.code == 130
    assert set(terminal.directory.iterdir()) == before


def test_import_as_data_and_silent(terminal: Terminal) -> None:
    prepare(terminal)
    command = ('import', 'daq.csv', '--map', 'map.yaml')
    done = terminal.run(*command, '--out', 'a', '--json')
    data = json.loads(done.out)
    assert data['signals'] == ['position', 'pressure_1', 'pressure_2', 'u']
    assert data['conditions'] == {'atmospheric_pressure': 1e5}
    assert data['notes'] == []
    assert terminal.run(*command, '--out', 'b', '--quiet') == (0, '', '')
    assert '--out a exists' in terminal.refusal(*command, '--out', 'a')


def test_import_shows_that_it_reads_and_how_far_it_has_written(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepare(terminal)
    shown: list[tuple[str, float]] = []

    @contextlib.contextmanager
    def bar() -> Iterator[Callable[[str, float], None]]:
        yield lambda stage, share: shown.append((stage, share))

    monkeypatch.setattr(output, 'stage_bar', bar)
    monkeypatch.setattr(conversion, 'BLOCK', 100)
    terminal.run('import', 'daq.csv', '--map', 'map.yaml', '--out', 'a')
    stages, shares = zip(*shown, strict=True)
    assert stages == ('reading', *['writing 430 samples'] * 6)
    assert list(shares) == sorted(set(shares) | {0.0})
    assert shares[-1] == 1.0


def test_unknown_cylinder_and_missing_mapping(terminal: Terminal) -> None:
    prepare(terminal)
    command = ('import', 'daq.csv', '--out', 'a')
    line = terminal.refusal(*command, '--map', 'map.yaml', '--cylinder', 'cylinder_4')
    assert 'cylinder_' in line
    assert '--map' in terminal.refusal(*command)
    assert 'none.yaml: cannot be read' in terminal.refusal(*command, '--map', 'none.yaml')


def test_export_as_csv_and_parquet(terminal: Terminal, bag: Path) -> None:
    terminal.output('export', bag, '--csv', '--out', 'a.csv')
    head, *rows = (terminal.directory / 'a.csv').read_text().splitlines()
    assert head.startswith('stamp_ns,time_s,position_m,velocity_m_per_s,pressure_1_Pa,')
    assert len(rows) == json.loads(terminal.output('info', bag, '--json'))['samples']
    data = json.loads(terminal.output('export', bag, '--parquet', '--out', 'a.pq', '--json'))
    assert data['columns'] == head.split(',')
    assert terminal.run('export', bag, '--csv', '--out', 'b.csv', '--quiet') == (0, '', '')
    assert 'exists' in terminal.refusal('export', bag, '--csv', '--out', 'a.csv')
    assert '--csv or --parquet' in terminal.refusal('export', bag)
    assert 'does not exist' in terminal.refusal('export', 'none', '--csv')
    for out in ('c.parquet', '-'):
        assert f'--out {out}: ' in terminal.refusal('export', bag, '--csv', '--out', out)
    assert sorted(path.name for path in terminal.directory.iterdir()) == ['a.csv', 'a.pq', 'b.csv']


def test_bag_is_exported_from_within(
    terminal: Terminal, bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = shutil.copytree(bag, terminal.directory / 'bag')
    monkeypatch.chdir(copy)
    assert terminal.run('export', '.', '--csv', '--quiet') == (0, '', '')
    assert (terminal.directory / 'bag.csv').exists()


@pytest.mark.parametrize(
    ('was', 'instead', 'complaint'),
    [
        ('x [mm]", unit: mm', 'x [mm]", unit: m', 'position from 0 to 8.58 m, cylinder_2 allows'),
        (
            'bar, gauge: true}\npressure_2',
            'bar, gauge: true, offset: -0.6 bar}\npressure_2',
            'pressure_1 from 4e+04 to',
        ),
        ('t [ms]", unit: ms', 't [ms]", unit: s', 'a sample every 1160 ms, allowed'),
        ('column: 4', 'column: "p_cap [bar]"', "pressure_2 and pressure_1 are both column 'p_cap"),
    ],
)
def test_wrong_unit_or_column_is_told(
    terminal: Terminal, was: str, instead: str, complaint: str
) -> None:
    prepare(terminal)
    assert was in MAPPING
    (terminal.directory / 'map.yaml').write_text(MAPPING.replace(was, instead))
    done = terminal.run(
        'import', 'daq.csv', '--map', 'map.yaml', '--cylinder', 'cylinder_2', '--out', 'measured'
    )
    assert (done.code, done.err.count('\n')) == (2, 1)
    assert complaint in done.err
    assert not (terminal.directory / 'measured').exists()
