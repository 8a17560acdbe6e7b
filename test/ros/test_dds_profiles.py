"""The variables by which Fast DDS finds its profiles, set when the nodes are imported."""

import json
import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

import pytest

from pneu_rig_ros.nodes import PROFILES

ROOT = Path(__file__).resolve().parents[2]
CODE = f"""
import json, os, sys
import pneu_rig_ros.nodes
assert 'rclpy' not in sys.modules, 'Fast DDS may have read its profiles'
print(json.dumps([os.environ.get(name) for name in {tuple(PROFILES)}]))
"""


def output_of(code: str, **given: str) -> str:
    """Return what a process says that runs some code, with these profiles."""
    own = {name: value for name, value in os.environ.items() if name not in PROFILES}
    words = [sys.executable, '-c', code]
    done = subprocess.run(words, env=own | given, capture_output=True, text=True, check=True)
    return done.stdout + done.stderr


def profiles_after_import(**given: str) -> list[str | None]:
    """Return the variables in a process that imports the nodes, started with those given."""
    values = json.loads(output_of(CODE, **given))
    assert isinstance(values, list)
    return values


def test_profiles_of_the_package_are_set_for_the_release_of_fast_dds() -> None:
    """Fast DDS 3, which Kilted has, warns of the older variable and refuses the older profiles."""
    kilted = int(version('rclpy').partition('.')[0]) >= 9
    set_now = dict(zip(PROFILES, profiles_after_import(), strict=True))
    name = 'FASTDDS_DEFAULT_PROFILES_FILE' if kilted else 'FASTRTPS_DEFAULT_PROFILES_FILE'
    file = set_now.pop(name)
    assert set(set_now.values()) == {None}
    assert file is not None
    assert Path(file).name == PROFILES[name]
    assert Path(file).read_bytes() == (ROOT / 'config' / PROFILES[name]).read_bytes()


def test_fast_dds_reads_every_profile_without_a_complaint() -> None:
    code = "import pneu_rig_ros.nodes, rclpy; rclpy.init(); rclpy.create_node('reader')"
    assert output_of(code) == ''


def test_both_files_have_the_same_profiles() -> None:
    """Fast DDS 3 spells the names of times with underscores."""
    first, second = (
        [
            (re.sub(r'.*}|_', '', element.tag).lower(), (element.text or '').strip())
            for element in ElementTree.parse(ROOT / 'config' / name).iter()
        ]
        for name in PROFILES.values()
    )
    assert first == second


@pytest.mark.parametrize('name', PROFILES)
@pytest.mark.parametrize('value', ['/lab/profiles.xml', ''])
def test_profiles_of_the_user_stay(name: str, value: str) -> None:
    expected = [value if each == name else None for each in PROFILES]
    assert profiles_after_import(**{name: value}) == expected
