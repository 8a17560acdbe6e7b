"""The variables by which Fast DDS finds its profiles, set when the nodes are imported."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pneu_rig_ros.nodes import PROFILES

ROOT = Path(__file__).resolve().parents[2]
CODE = f"""
import json, os, sys
import pneu_rig_ros.nodes
assert 'rclpy' not in sys.modules, 'Fast DDS may have read its profiles'
print(json.dumps([os.environ.get(name) for name in {PROFILES}]))
"""


def profiles_after_import(**given: str) -> list[str | None]:
    """Return the variables in a process that imports the nodes, started with those given."""
    own = {name: value for name, value in os.environ.items() if name not in PROFILES}
    words = [sys.executable, '-c', CODE]
    done = subprocess.run(words, env=own | given, capture_output=True, text=True, check=True)
    values = json.loads(done.stdout)
    assert isinstance(values, list)
    return values


def test_profiles_of_the_package_are_set_for_every_release_of_fast_dds() -> None:
    first, second = profiles_after_import()
    assert first == second
    assert first is not None
    assert Path(first).read_bytes() == (ROOT / 'config' / 'fastdds.xml').read_bytes()


@pytest.mark.parametrize('name', PROFILES)
@pytest.mark.parametrize('value', ['/lab/profiles.xml', ''])
def test_profiles_of_the_user_stay(name: str, value: str) -> None:
    expected = [value if each == name else None for each in PROFILES]
    assert profiles_after_import(**{name: value}) == expected
