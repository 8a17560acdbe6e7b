"""For scripts: `--quiet` prints nothing, `--json` nothing but data."""

import json
from pathlib import Path

import pytest
from terminal import Terminal

from pneu_rig_ros.cli import command

LONG = ('demo', 'simulate', 'claims', 'replay', 'import', 'export', 'compare', 'diagnose')
"""Commands that compute or play for more than a moment, with a result."""


@pytest.mark.parametrize('name', LONG)
def test_long_commands_can_be_quiet_and_print_data(name: str) -> None:
    options = {option for p in command.commands[name].params for option in p.opts}
    assert {'--quiet', '--json'} <= options


def test_simulate(terminal: Terminal) -> None:
    quiet = terminal.run('simulate', '--duration', 0.5, '--out', 'a', '--quiet')
    assert quiet == (0, '', '')
    assert (terminal.directory / 'a').is_dir()
    data = terminal.run('simulate', '--duration', 0.5, '--out', 'b', '--quiet', '--json')
    assert json.loads(data.out)['bag'] == 'b'


def test_repair(terminal: Terminal, bag: Path) -> None:
    assert terminal.run('repair', bag, '--quiet') == (0, '', '')
    data = json.loads(terminal.output('repair', bag, '--json'))
    assert data['repaired'] is False
    assert data['cut_file'] is None
    assert data['duration'] == pytest.approx(3.0, abs=0.01)
