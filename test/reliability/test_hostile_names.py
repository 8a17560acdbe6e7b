"""What stands in a bag, a table or a file name is text: nothing runs it or goes where it says."""

from __future__ import annotations

import os
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from terminal import Terminal

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import cdr_encoding, read_recording
from pneu_rig_ros.records.description import bag_metadata, describe
from pneu_rig_ros.records.writer import BagWriter
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

SCRIPT = '</script><script>alert(1)</script>'
NAMES = (
    f'a{SCRIPT}',
    '"><img src=x onerror=alert(1)>',
    '{{ 7 * 191 }}{% for x in y %}',
    '=cmd|calc!A0',
    r'$\frac{',
    r'$\frac{$ [/] :bug:',
    '..%2f..%2fetc',
    "'; DROP TABLE rigs; --",
)
HASH = 'RIHS01_' + '0' * 64
TOLD = ('cylinder', 'friction_model', 'package_version', 'git_revision', 'seed')
BYTES = os.fsdecode(b'n\xff')
TERMINAL = 'x\x1b[2J\x1b]0;owned\x07\u202e\r\n'


def named(folder: Path, name: str) -> Path:
    """Return a stroke of a rig with such a name, in a directory with such a name."""
    configuration = replace(load_configuration('cylinder_1'), name=name)
    return simulate(configuration, 0.5, 0.4, folder / 'runs' / name.replace('/', '∕'))


@pytest.fixture(params=NAMES)
def bag(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Return a stroke of a rig with one of the names."""
    return named(tmp_path, request.param)


@pytest.mark.parametrize(('one', 'other'), [NAMES[at : at + 2] for at in range(0, len(NAMES), 2)])
def test_pages_show_names_as_text(
    one: str, other: str, tmp_path: Path, terminal: Terminal
) -> None:
    bags = [named(tmp_path, name) for name in (one, other)]
    pages = {'view_1': bags[:1], 'view_2': bags[1:], 'compare': [bags[0], '--model', bags[1]]}
    for name, arguments in pages.items():
        page = tmp_path / f'{name}.html'
        terminal.output(name.split('_')[0], *arguments, '--out', page)
        html = page.read_text()
        assert '<script>alert' not in html
        assert '<img src=x' not in html
        assert '1337' not in html.replace('uPlot', '') or '{{ 7 * 191 }}' not in one + other
        assert 'Content-Security-Policy' in html
    assert {path.name for path in tmp_path.iterdir()} == {
        'runs',
        'view_1.html',
        'view_2.html',
        'compare.html',
    }


def test_pictures_and_tables_bear_such_names(bag: Path, terminal: Terminal) -> None:
    terminal.output('friction', bag, '--png', 'a.png')
    terminal.output('export', bag, '--csv', '--out', 'a.csv')
    cells = re.split(r'[,\n]', Path('a.csv').read_text())
    assert not [cell for cell in cells if cell[:1] in ('=', '+', '@', '\t', '\r')]
    assert not [cell for cell in cells if cell[:1] == '-' and not cell[1:2].isdigit()]


def test_nothing_in_a_bag_commands_the_terminal(tmp_path: Path, terminal: Terminal) -> None:
    text = describe(load_configuration('cylinder_1'))
    with BagWriter(tmp_path / 'bag') as writer:
        source = simulate(load_configuration('cylinder_1'), 0.5, 0.4, tmp_path / 'source')
        with Reader(source) as reader:
            for connection, stamp, raw in reader.messages():
                writer.write(connection.topic, connection.msgtype, stamp, bytes(raw))
        writer.close(bag_metadata(text) | dict.fromkeys(TOLD, TERMINAL))
    shown = terminal.output('info', tmp_path / 'bag')
    assert all(line.isprintable() for line in shown.split('\n'))
    assert terminal.refusal('info', tmp_path / TERMINAL).isprintable()


@pytest.mark.parametrize('name', [BYTES, TERMINAL.strip()])
def test_file_name_that_is_no_text_is_escaped(
    name: str, tmp_path: Path, terminal: Terminal
) -> None:
    table, mapping = tmp_path / f'{name}.csv', tmp_path / 'map.yaml'
    table.write_text('t,x\n' + ''.join(f'{k * 0.001:.3f},{k}\n' for k in range(50)))
    mapping.write_text('time: {column: t, unit: s}\nposition: {column: x, unit: mm}\n')
    words = ['import', table, '--map', mapping, '--out']
    line = terminal.refusal(*words, tmp_path / name)
    assert 'the name of a bag must be printable' in line
    shown = terminal.output(*words, tmp_path / 'bag')
    assert all(line.isprintable() for line in shown.split('\n'))
    assert read_recording(tmp_path / 'bag').metadata['source'].isprintable()
    simulate(load_configuration('cylinder_1'), 0.5, 0.4, tmp_path / 'rig').rename(tmp_path / name)
    terminal.output('view', tmp_path / name, '--out', 'view.html')


def test_name_of_a_rig_is_one_line() -> None:
    from pneu_rig_ros.rig import configuration_from_yaml

    text = replace(load_configuration('cylinder_1'), name=TERMINAL).to_yaml()
    with pytest.raises(RigError, match='not a line'):
        configuration_from_yaml(text, 'text')


def test_metadata_names_no_file_outside_the_bag(tmp_path: Path) -> None:
    bag = simulate(load_configuration('cylinder_1'), 0.5, 0.4, tmp_path / 'bag')
    shutil.copy(bag / 'bag.mcap', tmp_path / 'outside.mcap')
    metadata = bag / 'metadata.yaml'
    text = metadata.read_text().replace('bag.mcap', '../outside.mcap').rsplit('# crc32')[0]
    metadata.write_text(text)
    with pytest.raises(RigError, match='missing'):
        read_recording(bag)


@pytest.mark.parametrize(
    'definition',
    [
        "string X=\"'); __import__('pathlib').Path('owned').touch() #\"\nfloat64 data\n",
        'float64 data"""\n__import__("pathlib").Path("owned").touch()\n',
        'float64 data\n' + '=' * 80 + '\nMSG: a/b\n__import__("pathlib").Path("owned").touch()\n',
        'float64[999999999] data\n',
        'test_msgs/Own data\n',
    ],
)
@pytest.mark.parametrize('kind', ['test_msgs/msg/Own', '__import__("pathlib").Path("owned")'])
def test_message_definitions_do_not_run(
    kind: str, definition: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as made:
        connection = made.add_connection('/x', kind, msgdef=definition, rihs01=HASH)
        for k in range(4):
            made.write(connection, k, cdr_encoding.pack_float64(0.1))
    mapping = {'topics': {'position': {'topic': '/x', 'field': 'data'}}}
    with pytest.raises(RigError) as told:
        read_recording(tmp_path / 'bag', mapping)
    assert str(told.value).isprintable()
    assert not (tmp_path / 'owned').exists()


def test_table_with_hostile_names_becomes_a_bag(tmp_path: Path, terminal: Terminal) -> None:
    head = f'"{SCRIPT}","=cmd|calc","../../{{{{7*7}}}}"'
    table, mapping = tmp_path / f'{SCRIPT.replace("/", "∕")}.csv', tmp_path / 'map.yaml'
    table.write_text(f'{head}\n' + ''.join(f'{k * 0.001:.3f},{k},0.1\n' for k in range(50)))
    mapping.write_text(
        f'time: {{column: "{SCRIPT}", unit: s}}\nposition: {{column: "=cmd|calc", unit: mm}}\n'
        'u: {column: "../../{{7*7}}", unit: V}\n'
    )
    terminal.output('import', table, '--map', mapping, '--out', 'made')
    assert {path.name for path in tmp_path.iterdir()} == {table.name, 'map.yaml', 'made'}
    terminal.output('export', 'made', '--csv', '--out', 'out.csv')
    first = Path('out.csv').read_text().splitlines()[0]
    assert first == 'stamp_ns,time_s,position_m,velocity_m_per_s,u_V,voltage_1_V,voltage_2_V'
    mapping.write_text(mapping.read_text().replace('unit: mm', f'unit: "{SCRIPT}"'))
    terminal.refusal('import', table, '--map', mapping, '--out', 'other')
