"""`pneu-rig view` as its user runs it."""

import shutil
from pathlib import Path

import pytest
from terminal import Terminal


@pytest.fixture
def copy(bag: Path, terminal: Terminal) -> Path:
    return Path(shutil.copytree(bag, terminal.directory / 'runs' / 'my.stroke'))


def test_page_is_written_beside_the_bag(copy: Path, terminal: Terminal) -> None:
    outcome = terminal.run('view', 'runs/my.stroke')
    page = Path('runs', 'my.stroke.html')
    assert (outcome.code, outcome.err) == (0, '')
    assert str(page) in outcome.out
    assert '<h1>my.stroke</h1>' in page.read_text()
    assert copy.is_dir()
    assert f'--out {page} exists' in terminal.refusal('view', 'runs/my.stroke')


def test_part_goes_into_a_file_of_choice_quietly(bag: Path, terminal: Terminal) -> None:
    arguments = ('--out', 'part.html', '--from', 1, '--to', 2, '--quiet')
    assert terminal.run('view', bag, *arguments) == (0, '', '')
    part = (terminal.directory / 'part.html').stat().st_size
    terminal.run('view', bag, '--out', 'whole.html')
    assert part < (terminal.directory / 'whole.html').stat().st_size


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (['--from', '5'], 'no samples from 5 s on: the record ends at 2.99976 s'),
        (['--out', 'none/page.html'], 'there is no directory none'),
        (['--to', 'end'], 'end'),
        (['--from', 'nan'], "'nan' is not a finite number"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(
    bag: Path, terminal: Terminal, arguments: list[str], complaint: str
) -> None:
    assert complaint in terminal.refusal('view', bag, '--out', 'page.html', *arguments)
    assert list(terminal.directory.iterdir()) == []


def test_what_is_no_bag_is_refused(terminal: Terminal) -> None:
    assert 'nothing' in terminal.refusal('view', 'nothing')
    assert list(terminal.directory.iterdir()) == []
