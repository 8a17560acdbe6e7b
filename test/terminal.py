"""Runs `pneu-rig` in a directory of its own."""

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from pneu_rig_ros.cli import main

COMMAND = (sys.executable, '-m', 'pneu_rig_ros.cli')
HEAD = 'pneu-rig: error: '


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

    def output(self, *arguments: object) -> str:
        """Run what succeeds; return what it prints."""
        code, out, err = self.run(*arguments)
        assert code == 0, err
        return out

    def refusal(self, *arguments: object) -> str:
        """Run what is refused; return the one line that it says, without what all begin with."""
        code, out, err = self.run(*arguments)
        assert (code, out, err.count('\n')) == (2, '', 1), err
        assert err.startswith(HEAD)
        return err.removeprefix(HEAD).rstrip('\n')

    def start(self, *arguments: object) -> subprocess.Popen[str]:
        """Start in a process of its own."""
        return subprocess.Popen(
            [*COMMAND, *map(str, arguments)],
            cwd=self.directory,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
