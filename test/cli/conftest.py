"""Runs `pneu-rig` in a directory of its own."""

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from pneu_rig_ros.cli import main
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

COMMAND = (sys.executable, '-m', 'pneu_rig_ros.cli')


class Outcome(NamedTuple):
    """What a command did."""

    code: int
    out: str
    err: str


class Terminal:
    """A working directory in which `pneu-rig` is run."""

    def __init__(self, directory: Path, capture: pytest.CaptureFixture[str]) -> None:
        self.directory = directory
        self._capture = capture

    def run(self, *arguments: object) -> Outcome:
        """Run in this process."""
        self._capture.readouterr()
        code = main([str(argument) for argument in arguments])
        return Outcome(code, *self._capture.readouterr())

    def start(self, *arguments: object) -> subprocess.Popen[str]:
        """Start in a process of its own."""
        return subprocess.Popen(
            [*COMMAND, *map(str, arguments)],
            cwd=self.directory,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )


@pytest.fixture
def terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Terminal:
    monkeypatch.chdir(tmp_path)
    return Terminal(tmp_path, capsys)


@pytest.fixture(scope='session')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three simulated seconds of cylinder 2; not to be changed."""
    configuration = load_configuration('cylinder_2')
    return simulate(configuration, 0.34, 3.0, tmp_path_factory.mktemp('bags') / 'stroke')
