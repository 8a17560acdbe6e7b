"""The tutorial, step by step: it ends with the secret that it began with."""

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest

from pneu_rig_ros.cli import main

from .test_diagnose import without_all_but

ROOT = Path(__file__).resolve().parents[2]
TUTORIAL = (ROOT / 'docs' / 'tutorial.md').read_text()
pytestmark = pytest.mark.timeout(900)  # a diagnosis, on a machine that may be busy


def commands(*names: str) -> list[list[str]]:
    """Return the arguments of the tutorial's commands of some names, before the better model."""
    text = TUTORIAL[: TUTORIAL.index('## 4.')]
    lines = re.findall(rf'^pneu-rig ((?:{"|".join(names)}) .*)$', text, re.MULTILINE)
    return [shlex.split(line) for line in lines]


def test_tutorial_finds_its_leak(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / 'config' / 'cylinder_1.yaml', 'my_rig.yaml')
    secret = re.search(r"<<'END'\n(.*?)END\n", TUTORIAL, re.DOTALL)
    assert secret is not None
    with Path('my_rig.yaml').open('a') as rig:
        rig.write(secret[1])
    made = commands('simulate')
    assert len(made) == 3
    for arguments in made:
        assert main(arguments) == 0
    (arguments,) = commands('diagnose')
    others = without_all_but('chamber_leak', 'valve_null_leak', 'wall_heat_transfer')
    assert main([*arguments, '--workers', '1', *others]) == 0
    answer = json.loads(Path('answer/diagnosis.json').read_text())
    assert answer['verdict'] == 'effect'
    (effect,) = answer['effects']
    assert effect['name'] == 'chamber_leak'
    assert effect['parameters']['area_1']['value'] == pytest.approx(1e-8, rel=0.05)
