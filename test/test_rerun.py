"""The command that `make test` prints for a failed test runs that test."""

import shlex
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest
from rerun import rerun_command

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    'node',
    [
        'test/test_rerun.py',
        'test/test_rerun.py::test_it',
        'test/test_rerun.py::test_it[a-0.5]',
        "test/test_rerun.py::test_it[it's $HOME; `x`]",
        'test/test_rerun.py::test_it[a@b.c]',
    ],
)
@pytest.mark.parametrize('group', ['', '@live'])
def test_make_hands_on_the_name_of_the_test(
    node: str, group: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv('MAKE_TARGET', raising=False)
    command = rerun_command(SimpleNamespace(nodeid=node + group))
    words = ['bash', '-c', command.replace('make', 'make --dry-run', 1)]
    told = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert shlex.split(told.splitlines()[-1])[-1] == node


@pytest.mark.parametrize('target', ['test', 'test-long', 'test-no-fma'])
def test_command_is_of_the_target_that_was_made(
    target: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('MAKE_TARGET', target)
    assert rerun_command(SimpleNamespace(nodeid='a.py::b')) == f'make {target} ARGS=a.py::b'
