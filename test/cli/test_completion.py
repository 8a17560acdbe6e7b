"""The shell completes commands, options and files with what `pneu-rig completion` prints."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from terminal import Terminal

from pneu_rig_ros.cli import SHELLS

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
    script = terminal.output('completion', shell)
    assert f'{shell}_complete' in script
    assert '_PNEU_RIG_COMPLETE' in script
    if interpreter := shutil.which(shell):
        run = subprocess.run([interpreter, '-n'], input=script, text=True, timeout=60)
        assert run.returncode == 0


def test_other_shells_are_refused(terminal: Terminal) -> None:
    assert "'bash', 'zsh', 'fish'" in terminal.refusal('completion', 'tcsh')
