"""The linters, as tests: `make lint` runs the same, `make format` mends what can be mended."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    'tool',
    [
        ['ruff', 'check', '--quiet'],
        ['ruff', 'format', '--check', '--quiet'],
        pytest.param(['mypy'], marks=pytest.mark.timeout(600)),
    ],
    ids=' '.join,
)
def test_linter_has_no_complaint(tool: list[str]) -> None:
    pytest.importorskip(tool[0], reason='no package of the distribution')
    run = subprocess.run(
        [sys.executable, '-m', *tool], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr


def test_package_needs_no_exception_of_the_formatter() -> None:
    files = (ROOT / 'pneu_rig_ros').rglob('*.py')
    assert [path for path in files if re.search(r'# fmt: (skip|off)', path.read_text())] == []
