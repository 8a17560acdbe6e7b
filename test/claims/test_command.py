"""`pneu-rig claims` prints a row for each statement and writes what it is asked for."""

import json
import re
from itertools import islice
from pathlib import Path

import pytest
from terminal import Terminal

from pneu_rig_ros.claims import statements as module
from pneu_rig_ros.claims.experiments import Reading
from pneu_rig_ros.claims.findings import Finding, Row, Statement
from pneu_rig_ros.claims.statements import STATEMENTS, Neighbour, neighbours

from .conftest import Run


def test_prints_a_row_for_each_statement_and_writes_files(run: Run, tmp_path: Path) -> None:
    page, data = tmp_path / 'page.html', tmp_path / 'data.json'
    code, out, err = run('--no-neighbours', '--html', page, '--json', data)
    assert (code, err) == (0, '')
    verdicts = re.findall(r'^ {0,2}(\d+)   .* (holds|does not) *$', out, re.MULTILINE)
    assert [int(number) for number, _ in verdicts] == [s.number for s in STATEMENTS]
    written = json.loads(data.read_text())
    assert [entry['holds'] for entry in written] == [word == 'holds' for _, word in verdicts]
    held = sum(entry['holds'] for entry in written)
    assert f"{held} of {len(STATEMENTS)} statements hold under the reading 'default'" in out
    assert str(page) in out
    assert page.stat().st_size > 100_000


def test_json_alone_is_the_whole_output(run: Run) -> None:
    code, out, _ = run('--no-neighbours', '--json')
    assert code == 0
    entries = json.loads(out)
    assert [entry['statement'] for entry in entries] == [s.number for s in STATEMENTS]
    for entry, statement in zip(entries, STATEMENTS, strict=True):
        assert set(entry) == {'statement', 'expected', 'measured', 'holds', 'neighbours'}
        assert entry['neighbours'] is None
        assert entry['expected'] == statement.text
        findings = entry['measured']
        assert {type(finding['holds']) for finding in findings} == {bool}
        assert entry['holds'] == all(finding['holds'] for finding in findings)


def test_row_tells_in_full_what_does_not_hold() -> None:
    findings = (
        Finding('cylinder_1: shorter', '3, 2 s', 0.5),
        Finding('cylinder_1: fewer', '9, 2', 0.0),
        Finding('larger', '1, 1 mm', -0.1),
    )
    row = Row(Statement(1, 'text', lambda _: findings), findings)
    assert row.measured == 'NOT larger: 1, 1 mm'
    held = Row(row.statement, findings[:2])
    assert held.measured == 'cylinder_1: fewer: 9, 2'


@pytest.mark.long
def test_neighbours_of_a_reading_are_measured_and_their_share_is_printed(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    reading = tmp_path / 'stiff.yaml'
    reading.write_text('friction: {element_stiffness: [1e6 N/m], element_limit: []}')
    asked = []

    def one(about: Reading) -> list[Neighbour]:
        asked.append(about.name)
        return list(islice(neighbours(about), 1))

    monkeypatch.setattr(module, 'neighbours', one)
    code, out, _ = run('--reading', reading, '--json', tmp_path / 'data.json')
    assert code == 0
    assert set(asked) == {'stiff'}
    written = json.loads((tmp_path / 'data.json').read_text())
    assert {entry['neighbours'] for entry in written} == {0.0, 1.0}
    assert "hold under the reading 'stiff'" in out
    assert 'neighbours' in out
    assert re.search(r'cylinder_1: \d+ cycles, at rest \d+%', ' '.join(out.split()))


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (['--reading', 'nope'], "unknown name 'nope'"),
        (['--reading', 'nope.yaml'], 'nope.yaml: cannot be read'),
        (['--html', '/nowhere/x.html'], 'there is no directory /nowhere'),
        (['--json', '/nowhere/x.json'], 'there is no directory /nowhere'),
        (['--markdown', '--json'], '--markdown and --json without FILE both print'),
        (['--html', 'x', '--json', 'x'], '--html and --json both name x'),
        (['--html', '/'], '--html / exists'),
    ],
)
def test_mistake_is_told_in_one_line(
    terminal: Terminal, arguments: list[str], complaint: str
) -> None:
    assert complaint in terminal.refusal('claims', *arguments)
