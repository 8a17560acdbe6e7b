"""Tables of laboratories: every way to write the same numbers, and what is wrong with a file."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording, text_table
from pneu_rig_ros.records.mapping import Layout

COUNT = 200
TIME = np.arange(COUNT) * 1.16e-3
POSITION = 0.05 + 0.03 * np.sin(6.0 * TIME)
PRESSURE = 3e5 + 5e4 * np.cos(9.0 * TIME)
MAPPING: dict[str, Any] = {
    'time': {'column': 't', 'unit': 'ms'},
    'position': {'column': 'x', 'unit': 'mm'},
    'pressure_1': {'column': 'p1', 'unit': 'bar', 'gauge': True},
}
HEADER = ['t', 'x', 'p1']
BY_NUMBER: dict[str, Any] = {
    name: {**source, 'column': number}
    for number, (name, source) in enumerate(MAPPING.items(), start=1)
}


def rows(decimal: str = '.') -> list[list[str]]:
    """Return the signals as a laboratory writes them: ms, mm, bar gauge."""
    columns = zip(TIME * 1e3, POSITION * 1e3, PRESSURE / 1e5 - 1.0, strict=True)
    return [[f'{value:.9g}'.replace('.', decimal) for value in row] for row in columns]


Writer = Callable[..., Path]


@pytest.fixture(params=['row by row', 'by columns'], autouse=True)
def _way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read tables that are longer than a few kB as those are that are longer than some 100 kB."""
    if request.param == 'by columns':
        monkeypatch.setattr(text_table, 'HEAD', 2500)


@pytest.fixture
def write(tmp_path: Path) -> Writer:
    def to_file(lines: list[list[str]], separator: str = ',', encoding: str = 'utf-8') -> Path:
        path = tmp_path / 'export.csv'
        text = ''.join(separator.join(line) + '\n' for line in lines)
        path.write_bytes(text.encode(encoding))
        return path

    return to_file


def check(table: Recording) -> None:
    np.testing.assert_allclose(table.time, TIME, atol=1e-9)
    np.testing.assert_allclose(table['position'], POSITION, atol=1e-10)
    np.testing.assert_allclose(table['pressure_1'], PRESSURE, atol=1e-3)
    assert table.atmospheric_pressure == 1e5
    assert table.interval_ns == 1_160_000
    assert table.notes == ()


@pytest.mark.parametrize(
    ('separator', 'decimal'), [(',', '.'), (';', '.'), (';', ','), ('\t', ','), (' ', '.')]
)
@pytest.mark.parametrize('encoding', ['utf-8', 'utf-8-sig', 'utf-16', 'cp1252'])
def test_any_separator_decimal_and_encoding(
    write: Writer, separator: str, decimal: str, encoding: str
) -> None:
    path = write([HEADER, *rows(decimal)], separator, encoding)
    check(read_recording(path, MAPPING))
    told = {'separator': separator, 'decimal': decimal, 'header': True}
    check(read_recording(path, MAPPING | told))


def test_blanks_may_be_many_and_lines_end_as_on_windows(tmp_path: Path) -> None:
    lines = ['\t '.join(HEADER), *('   '.join(['', *row]) for row in rows()), '', ' ']
    path = tmp_path / 'blanks.txt'
    path.write_bytes('\r\n'.join(lines).encode())
    check(read_recording(path, MAPPING | {'separator': 'blank'}))


@pytest.mark.parametrize(
    ('before', 'layout'),
    [
        ([], {}),
        ([['# DAQ of 2026'], [], ['# t', ' x', ' p1']], {}),
        ([['% DAQ'], ['% more']], {'comment': '%'}),
        ([['Version 2'], ['a', 'b']], {'skip_rows': 2}),
        ([['t', 'x', 'p1'], ['ms', 'mm', 'bar']], {'skip_after_header': 1}),
    ],
)
def test_lines_before_the_data(
    write: Writer, before: list[list[str]], layout: dict[str, Any]
) -> None:
    check(read_recording(write([*before, *rows()]), BY_NUMBER | layout))


def test_header_in_a_comment_names_the_columns(write: Writer) -> None:
    check(read_recording(write([['#t', 'x', 'p1'], *rows()]), MAPPING))


def test_unit_in_the_header(write: Writer) -> None:
    path = write([['t (ms)', 'x [mm]', 'p1 [barg]'], *rows()], ';')
    mapping = {'time': 't (ms)', 'position': 'x [mm]', 'pressure_1': 3, 'separator': ';'}
    check(read_recording(path, mapping))


def test_surroundings_are_those_of_the_mapping_then_of_the_caller(write: Writer) -> None:
    path = write([HEADER, *rows()])
    mapping = MAPPING | {'atmospheric_pressure': '990 hPa'}
    table = read_recording(path, mapping, atmospheric_pressure=1.02e5)
    assert table.atmospheric_pressure == pytest.approx(9.9e4)
    np.testing.assert_allclose(table['pressure_1'], PRESSURE - 1e3, atol=1e-3)
    assert read_recording(path, MAPPING, 1.02e5).atmospheric_pressure == 1.02e5


def test_scale_and_offset_of_a_sensor(write: Writer) -> None:
    volts = [[f'{t:.9f}', f'{(x - 0.01) / 0.06:.9f}'] for t, x in zip(TIME, POSITION, strict=True)]
    mapping = {
        'time': {'column': 1, 'unit': 's'},
        'position': {'column': 2, 'unit': 'V', 'scale': '60 mm/V', 'offset': '10 mm'},
    }
    table = read_recording(write(volts), mapping)
    np.testing.assert_allclose(table['position'], POSITION, atol=1e-9)
    mapping['position'] = {'column': 2, 'unit': 'm', 'scale': -1}
    turned = read_recording(write(volts), mapping)['position']
    np.testing.assert_allclose(turned, (0.01 - POSITION) / 0.06, atol=1e-9)


@pytest.mark.parametrize('time', [{'rate': '862.0689655 Hz'}, {'interval': '1.16 ms'}])
def test_time_without_a_column(write: Writer, time: dict[str, str]) -> None:
    table = read_recording(write([HEADER, *rows()]), {**MAPPING, 'time': time})
    np.testing.assert_allclose(table.time, TIME, atol=1e-9)


def test_dates_become_stamps(write: Writer) -> None:
    start = np.datetime64('2026-01-31T12:00:00.5', 'ns')
    stamps = start + (TIME * 1e9).round().astype(np.int64)
    texts = [str(stamp).replace('T', ' ') for stamp in stamps]
    lines = [[text, *row[1:]] for text, row in zip(texts, rows(), strict=True)]
    table = read_recording(write(lines), BY_NUMBER | {'time': {'column': 1, 'unit': 'datetime'}})
    assert table.start_ns == int(start.astype(np.int64))
    np.testing.assert_allclose(table.time, TIME, atol=1e-12)


def test_rounded_stamps_lie_on_the_grid(write: Writer) -> None:
    lines = [[f'{t * 1e3:.1f}', *row[1:]] for t, row in zip(TIME, rows(), strict=True)]
    table = read_recording(write([HEADER, *lines]), MAPPING)
    assert table.interval_ns == 1_160_000
    assert table.notes == ()
    assert table.size == COUNT


def test_missing_samples_stay_missing_and_are_told(write: Writer) -> None:
    lines = [row for k, row in enumerate(rows()) if k not in (50, 51, 120)]
    table = read_recording(write([HEADER, *lines]), MAPPING)
    assert table.missing['position'].tolist() == [50 * 1_160_000, 51 * 1_160_000, 120 * 1_160_000]
    assert table.notes == ('3 of 200 samples are missing',)
    np.testing.assert_allclose(table['position'], POSITION, atol=1e-6)
    np.testing.assert_allclose(table.time, TIME, atol=1e-9)


def test_jittering_stamps_are_interpolated_and_it_is_told(write: Writer) -> None:
    late = TIME + 4e-4 * np.random.default_rng(1).uniform(-1, 1, COUNT)
    lines = [
        [f'{t * 1e3:.6f}', f'{1e3 * (0.05 + 0.03 * np.sin(6.0 * t)):.9g}', '2.0'] for t in late
    ]
    table = read_recording(write([HEADER, *lines]), MAPPING)
    assert len(table.notes) == 1
    assert 'interpolated onto steps of' in table.notes[0]
    there = 0.05 + 0.03 * np.sin(6.0 * (late[0] + table.time))
    np.testing.assert_allclose(table['position'], there, atol=2e-6)


def test_gaps_between_jittering_stamps_are_missing_samples(write: Writer) -> None:
    late = TIME + 4e-4 * np.random.default_rng(1).uniform(-1, 1, COUNT)
    gap = slice(50, 80)
    lines = [
        [f'{t * 1e3:.6f}', f'{1e3 * (0.05 + 0.03 * np.sin(6.0 * t)):.9g}', '2.0']
        for t in np.delete(late, gap)
    ]
    table = read_recording(write([HEADER, *lines]), MAPPING)
    missing = (table.missing['position'] - table.start_ns) / table.interval_ns
    assert missing == pytest.approx(np.arange(missing[0], missing[0] + missing.size))
    assert missing.size == pytest.approx(30, abs=1)
    assert missing[0] == pytest.approx(50, abs=1)
    assert table.notes[1] == f'{missing.size} of {table.time.size} samples are missing'


def test_voltages_are_held_where_samples_are_missing(write: Writer) -> None:
    lines = [['0', '1'], ['1', '1'], ['2', '1'], ['5', '3'], ['6', '3']]
    mapping = {'time': {'column': 1, 'unit': 's'}, 'u': {'column': 2, 'unit': 'V'}}
    table = read_recording(write(lines), mapping)
    np.testing.assert_array_equal(table['u'], [1, 1, 1, 1, 1, 3, 3])


def test_low_absolute_pressure_raises_a_suspicion(write: Writer) -> None:
    mapping = {**MAPPING, 'pressure_1': {'column': 'p1', 'unit': 'kPa'}}
    assert 'is it gauge?' in read_recording(write([HEADER, *rows()]), mapping).notes[0]


def changed(row: int, column: int, text: str) -> list[list[str]]:
    lines = [HEADER, *rows()]
    lines[row - 1][column] = text
    return lines


@pytest.mark.parametrize(
    ('lines', 'mapping', 'message'),
    [
        (changed(17, 1, 'abc'), {}, "row 17, column 'x': 'abc' is not a finite number"),
        (changed(17, 1, ''), {}, "row 17, column 'x': the cell is empty"),
        (changed(17, 2, 'NaN'), {}, "row 17, column 'p1': 'NaN' is not a finite number"),
        (changed(17, 0, '1.0'), {}, "row 17, column 't': time 1.0 comes after 16.24; it must inc"),
        (changed(17, 2, '-1.5'), {}, "row 17, column 'p1': an absolute pressure of -50000 Pa"),
        (changed(2, 1, 'mm'), {}, "row 2, column 'x': 'mm' .* a line of units.* skip_after_head"),
        ([*changed(2, 0, '0')[:9], ['9', '1']], {}, 'row 10 has 2 cells, row 2 has 3'),
        ([HEADER, ['1', '2', '3', '4']], {}, 'row 2 has 4 cells, the header has 3'),
        ([HEADER], {}, 'no line of data after the header'),
        ([], {}, 'no line of data'),
        (changed(2, 0, '0')[:2], {}, '1 samples, at least 2 are needed'),
        (changed(2, 0, '0'), {'position': {'column': 'X', 'unit': 'mm'}}, "unknown name 'X'"),
        (changed(2, 0, '0'), {'position': {'column': 4, 'unit': 'mm'}}, 'column 4, .* has 3'),
        (changed(2, 0, '0'), {'position': 'x'}, 'position: missing unit, such as unit: m'),
        (changed(2, 0, '0'), {'time': 't'}, 'mapping: time: missing unit, such as unit: s'),
        ([['t', 'x', 'x'], *rows()], {}, "several columns 'x'; give a number: 2, 3"),
        (rows(), {'header': False}, "column 't', but .* has no header; give a number, 1 to 3"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_in_one_line(
    write: Writer, lines: list[list[str]], mapping: dict[str, Any], message: str
) -> None:
    with pytest.raises(RigError, match=message) as error:
        read_recording(write(lines), MAPPING | mapping)
    assert '\n' not in str(error.value)


def test_decimal_comma_is_suspected(write: Writer) -> None:
    path = write([HEADER, *rows(',')], ';')
    with pytest.raises(RigError, match=r"row 3, column 't': '1,16' .* decimal comma\? Add to the"):
        read_recording(path, MAPPING | {'decimal': '.'})


def test_files_that_are_no_tables(tmp_path: Path) -> None:
    with pytest.raises(RigError, match='cannot be read: No such file'):
        read_recording(tmp_path / 'none.csv', MAPPING)
    (tmp_path / 'binary.csv').write_bytes(b'\x00\x01\x02' * 50)
    with pytest.raises(RigError, match='is not a text file'):
        read_recording(tmp_path / 'binary.csv', MAPPING)
    with pytest.raises(RigError, match='must say which column'):
        read_recording(tmp_path / 'binary.csv')


@pytest.mark.parametrize(
    ('mapping', 'message'),
    [
        ({'presure_1': 1}, "unknown name 'presure_1', did you mean 'pressure_1'"),
        ({'position': {'colum': 1}}, "position: unknown name 'colum', did you mean 'column'"),
        ({'position': {'unit': 'mm'}}, 'position: missing column'),
        ({'position': {'column': 0}}, 'columns are counted from 1'),
        ({'position': {'column': True}}, 'column: True is not a text or a number'),
        ({'position': {'column': 1, 'gauge': True}}, 'gauge is for pressures only'),
        (
            {'position': {'column': 1, 'unit': 'bar'}},
            "unit 'bar' is of another kind, allowed is m",
        ),
        ({'position': {'column': 1, 'unit': 'V', 'scale': '3 N/V'}}, 'scale: unit .* of another'),
        ({'time': {'column': 1, 'rate': '1 Hz'}}, 'time: give one of column, rate, interval'),
        ({'time': {'rate': '-1 Hz'}}, 'must be positive'),
        ({'separator': '|'}, "separator '|', allowed"),
        ({'separator': [';']}, r"separator \[';'\], allowed"),
        ({'separator': ',', 'decimal': ','}, 'a comma cannot be both'),
        ({'header': 'maybe'}, "header 'maybe', allowed: true, false, auto"),
        ({'skip_rows': -1}, 'skip_rows -1, must be a number of lines'),
        ({'pressure_1': {'column': 3, 'unit': 'psia', 'gauge': True}}, 'the unit says absolute'),
        ({'topics': {'position': '/x'}}, 'time: not for a bag'),
    ],
)
def test_what_is_wrong_in_a_mapping_is_said(
    write: Writer, mapping: dict[str, Any], message: str
) -> None:
    with pytest.raises(RigError, match=message.replace('|', r'\|')):
        read_recording(write([HEADER, *rows()]), MAPPING | mapping)


def test_mapping_of_nothing(write: Writer, tmp_path: Path) -> None:
    with pytest.raises(RigError, match='names no signal'):
        read_recording(write(rows()), {'time': {'rate': '1 Hz'}})
    with pytest.raises(RigError, match='time: missing; name its column'):
        read_recording(write(rows()), {'position': {'column': 1, 'unit': 'm'}})
    (tmp_path / 'map.yaml').write_text('position: [')
    with pytest.raises(RigError, match='not valid YAML'):
        read_recording(write(rows()), tmp_path / 'map.yaml')


def test_signal_that_is_not_there(write: Writer) -> None:
    table = read_recording(write([HEADER, *rows()]), MAPPING)
    assert 'pressure_2' not in table
    with pytest.raises(RigError, match='export: no pressure_2 in it; it has position, pressure_1'):
        table['pressure_2']


@pytest.mark.parametrize(
    ('texts', 'decimal', 'values'),
    [
        (['0.000', '975.000', '1.075.000'], '.', [0.0, 975e3, 1075e3]),
        (['1.075,5', '3,25'], ',', [1075.5, 3.25]),
        (['1,234.5', '-1,000,000.25'], '.', [1234.5, -1000000.25]),
        (['975.000', '1.075'], '.', [975.0, 1.075]),
    ],
)
def test_signs_between_thousands_are_left_out(
    write: Writer, texts: list[str], decimal: str, values: list[float]
) -> None:
    table = text_table.read_cells(
        write([['x'], *([text] for text in texts)], ';'), Layout(separator=';', decimal=decimal)
    )
    np.testing.assert_allclose(table.values(0), values)


@pytest.mark.parametrize('texts', [['1.2.3', '4'], ['1.000.000', '12.34'], ['1.00.000', '1']])
def test_other_signs_in_a_number_are_refused(write: Writer, texts: list[str]) -> None:
    table = text_table.read_cells(
        write([['x'], *([text] for text in texts)], ';'), Layout(separator=';', decimal='.')
    )
    with pytest.raises(RigError, match='is not a finite number'):
        table.values(0)


@pytest.mark.parametrize(
    ('rows', 'values'),
    [
        (
            ['0;0', '0,01;1', '0,02;1,5'],
            [0.0, 0.01, 0.02],
        ),  # as a spreadsheet writes whole numbers
        (['0,000;3.658', '100,000;3.6', '1,000,000;3.657'], [0.0, 1e5, 1e6]),
        (['0.000;3.658', '100.000;3.657', '1.000.000;3.657'], [0.0, 1e5, 1e6]),
        (['0.000;3,658', '100.000;3,6', '1.000.000;3,657'], [0.0, 1e5, 1e6]),
        (['1.075,5;1', '1.076;1', '1.077,25;1'], [1075.5, 1076.0, 1077.25]),
        (['1,075.5;1', '1,076;1', '1,077.25;1'], [1075.5, 1076.0, 1077.25]),
        (['1,075;2,5', '1,076;2', '1,077;2'], [1.075, 1.076, 1.077]),
        (['0,075;2', '0,076;2', '1,077;2'], [0.075, 0.076, 1.077]),
        (['2,5e-3;2', '3e-3;2', '3,5e-3;2'], [2.5e-3, 3e-3, 3.5e-3]),
    ],
)
def test_decimal_sign_is_detected(write: Writer, rows: list[str], values: list[float]) -> None:
    table = text_table.read_cells(
        write([['x', 'y'], *(row.split(';') for row in rows)], ';'), Layout()
    )
    np.testing.assert_allclose(table.values(0), values)


@pytest.mark.parametrize('sign', ['\N{MICRO SIGN}', '\N{GREEK SMALL LETTER MU}', 'u'])
def test_microseconds_with_points_between_thousands(write: Writer, sign: str) -> None:
    lines = [[f't [{sign}s]', 'p'], ['0.000', '7.3'], ['600.000', '7.3'], ['1.200.000', '7.2']]
    mapping = {'time': f't [{sign}s]', 'pressure_1': {'column': 'p', 'unit': 'barg'}}
    table = read_recording(write(lines, ';'), mapping)
    assert table.interval == pytest.approx(0.6)


def test_force_may_be_the_sum_of_columns(write: Writer) -> None:
    cells_of_row = [['0', '1', '10', '20'], ['0.1', '2', '11', '18'], ['0.2', '1', '12', '15']]
    force = [
        {'column': 2, 'unit': 'kN'},
        {'column': 3, 'unit': 'bar', 'scale': '-1e-3 m^2'},
        {'column': 4, 'unit': 'bar', 'scale': '1e-3 m^2', 'offset': '5 N'},
    ]
    mapping = {'time': {'column': 1, 'unit': 's'}, 'force': force}
    table = read_recording(write(cells_of_row, ';'), mapping)
    np.testing.assert_allclose(table['force'], [2005.0, 2705.0, 1305.0])


@pytest.mark.parametrize(
    ('mapping', 'message'),
    [
        ({'position': [1, 2]}, 'position: a list is for the columns of a table'),
        ({'force': []}, 'force: a list is for the columns of a table'),
        ({'force': [1, [2]]}, 'force: a list is for the columns of a table'),
        ({'force': [{'column': 1}, {'unit': 'N'}]}, r'force\[2\]: missing column'),
        ({'force': [{'column': 9, 'unit': 'N'}, 2], 'position': 2}, 'are both column 2'),
        ({'topics': {'force': ['/a', '/b']}, 'time': None}, 'force: a list is for the columns'),
    ],
)
def test_what_is_wrong_in_a_sum_is_said(
    write: Writer, mapping: dict[str, Any], message: str
) -> None:
    with pytest.raises(RigError, match=message):
        read_recording(write([HEADER, *rows()]), {'time': 1} | mapping)


def long_table(rows: list[str]) -> str:
    """Return a table of which a regular beginning shows the form."""
    return '\n'.join(['x;y', *('1.5;2.5' for _ in range(400)), *rows, ''])


@pytest.mark.parametrize(
    ('rows', 'by_columns'),
    [
        (['1;2'], True),
        (['', ' 1.5 ;"2"', ''], True),
        (['# a remark', '1;2'], False),
        (['  ', '1;2'], False),
    ],
)
def test_a_long_regular_table_is_read_by_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: list[str], by_columns: bool
) -> None:
    pytest.importorskip('pyarrow')
    path = tmp_path / 'long.csv'
    path.write_text(long_table(rows))
    both = []
    for head in (2500, 10**9):
        monkeypatch.setattr(text_table, 'HEAD', head)
        table = text_table.read_cells(path, Layout())
        assert isinstance(table.columns[0], Sequence) == (head > 2500 or not by_columns)
        both.append([table.values(index) for index in range(2)])
    np.testing.assert_array_equal(*both)


@pytest.mark.parametrize(
    ('rows', 'message'),
    [
        (['', '1.5;abc'], "row 403, column 'y': 'abc' is not a finite number"),
        (['1.5;'], "row 402, column 'y': the cell is empty"),
        (['1.5;inf'], "row 402, column 'y': 'inf' is not a finite number"),
        (['1.5'], 'row 402 has 1 cells, row 2 has 2'),
        (['1.5;2;3'], 'row 402 has 3 cells, row 2 has 2'),
    ],
)
def test_an_error_far_down_a_long_table_has_its_row(
    tmp_path: Path, rows: list[str], message: str
) -> None:
    path = tmp_path / 'long.csv'
    path.write_text(long_table(rows))
    with pytest.raises(RigError, match=message):
        text_table.read_cells(path, Layout()).values(1)


def test_without_pyarrow_a_long_table_is_read_row_by_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'pyarrow', None)
    path = tmp_path / 'long.csv'
    path.write_text(long_table(['1;2']))
    assert text_table.read_cells(path, Layout()).values(1)[-1] == 2.0
