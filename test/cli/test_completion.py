"""The shell completes commands, options and files with what `pneu-rig completion` prints."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pneu_rig_ros.cli import SHELLS

from .conftest import Terminal

BASH = """
eval "$(pneu-rig completion bash)"
words=({words}); COMP_WORDS=("${{words[@]}}"); COMP_CWORD=$((${{#words[@]}} - 1))
compopt() {{ :; }}
_pneu_rig_completion pneu-rig
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def completed(words: str) -> list[str]:
    """Return what a bash that has run the script offers for the last word."""
    environment = os.environ | {'PATH': f'{Path(sys.executable).parent}:{os.environ["PATH"]}'}
    run = subprocess.run(
        ['bash', '-c', BASH.format(words=words)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert run.stderr == ''
    return run.stdout.split()


@pytest.mark.skipif(shutil.which('bash') is None, reason='there is no bash here')
def test_bash_completes_commands_and_options() -> None:
    assert completed('pneu-rig si') == ['simulate']
    assert completed('pneu-rig simulate --supply') == ['--supply-pressure']
    assert completed('pneu-rig completion z') == ['zsh']


@pytest.mark.parametrize('shell', SHELLS)
def test_each_shell_gets_a_script_that_asks_it(terminal: Terminal, shell: str) -> None:
    outcome = terminal.run('completion', shell)
    assert outcome.code == 0
    assert f'{shell}_complete' in outcome.out
    assert '_PNEU_RIG_COMPLETE' in outcome.out
    if interpreter := shutil.which(shell):
        run = subprocess.run([interpreter, '-n'], input=outcome.out, text=True, timeout=60)
        assert run.returncode == 0


def test_other_shells_are_refused(terminal: Terminal) -> None:
    outcome = terminal.run('completion', 'tcsh')
    assert outcome.code == 2
    assert "'bash', 'zsh', 'fish'" in outcome.err
