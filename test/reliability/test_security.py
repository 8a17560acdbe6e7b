"""DDS stays on this host unless somebody opens it; where security is asked for, it is there."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pneu_rig_ros.demo import prepare_environment

ROOT = Path(__file__).resolve().parents[2]
RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
TARGETS = re.findall(r'^([a-z-]+):.*## ', (ROOT / 'Makefile').read_text(), re.MULTILINE)


@pytest.mark.parametrize('target', TARGETS)
def test_make_keeps_dds_on_this_host_whatever_the_shell_says(target: str) -> None:
    wild = {RANGE: 'SUBNET', 'ROS_STATIC_PEERS': '192.0.2.1', 'ROS_LOCALHOST_ONLY': '0'}
    # A variable that make itself prints, under the rules and exports of the Makefile.
    told = subprocess.run(
        ['make', '-s', '--no-print-directory', '-f', '-', 'tell'],
        input=f'include {ROOT}/Makefile\ntell:\n\t@env | grep ^ROS_\n',
        cwd=ROOT,
        env={**os.environ, **wild},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert f'{RANGE}=LOCALHOST' in told
    assert 'ROS_STATIC_PEERS' not in told
    recipe = subprocess.run(
        ['make', '-n', target],
        cwd=ROOT,
        env={**os.environ, **wild},
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    assert 'SUBNET' not in recipe
    assert RANGE not in recipe


def function_of(file: Path, name: str) -> ast.FunctionDef:
    tree = ast.parse(file.read_text())
    return next(n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == name)


@pytest.mark.parametrize('file', sorted((ROOT / 'launch').glob('*.py')), ids=lambda f: f.name)
def test_launch_files_keep_dds_on_this_host(file: Path) -> None:
    returned = function_of(file, 'generate_launch_description').body[-1]
    assert ast.unparse(returned).startswith('return described(ARGUMENTS, ')
    shared = ROOT / 'pneu_rig_ros' / 'nodes' / 'launching.py'
    assert f"EnvironmentVariable('{RANGE}', default_value='LOCALHOST')" in shared.read_text()
    text = ast.unparse(function_of(shared, 'described'))
    assert text.endswith(f"SetEnvironmentVariable('{RANGE}', DISCOVERY), *actions])")


def test_demonstrations_keep_dds_on_this_host_unless_it_was_opened(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv(RANGE, raising=False)
    prepare_environment()
    assert os.environ[RANGE] == 'LOCALHOST'
    monkeypatch.setenv(RANGE, 'SUBNET')
    prepare_environment()
    assert os.environ[RANGE] == 'SUBNET'


@pytest.mark.live
@pytest.mark.parametrize('keystore', ['none', 'made'])
def test_node_refuses_to_run_unprotected(keystore: str, tmp_path: Path) -> None:
    """With the PyPI wheels, whose Fast DDS has no security, and with no keystore at all."""
    folder = tmp_path / 'keystore' / 'enclaves'
    if keystore == 'made':
        folder.mkdir(parents=True)
        for name in (
            'identity_ca.cert.pem',
            'cert.pem',
            'key.pem',
            'permissions_ca.cert.pem',
            'governance.p7s',
            'permissions.p7s',
        ):
            (folder / name).touch()
    wanted = {
        'ROS_SECURITY_ENABLE': 'true',
        'ROS_SECURITY_STRATEGY': 'Enforce',
        'ROS_SECURITY_KEYSTORE': str(folder.parent),
        RANGE: 'LOCALHOST',
        'ROS_DOMAIN_ID': '49',
    }
    ended = subprocess.run(
        [sys.executable, '-m', 'pneu_rig_ros.nodes.valve_command'],
        env={**os.environ, **wanted},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 2
    assert 'Traceback' not in ended.stderr
    assert 'securit' in ended.stderr.splitlines()[-1].lower()


@pytest.mark.live
@pytest.mark.parametrize(
    'argument',
    [
        'command_timeout:=nan',
        'x:=\x1b',
        *(pytest.param(text, marks=pytest.mark.long) for text in (':=', 'command_timeout:=[')),
    ],
)
def test_bad_parameters_end_a_node_with_one_line(argument: str) -> None:
    ended = subprocess.run(
        [sys.executable, '-m', 'pneu_rig_ros.nodes.valve_command', '--ros-args', '-p', argument],
        env={**os.environ, RANGE: 'LOCALHOST', 'ROS_DOMAIN_ID': '49'},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 2
    assert 'Traceback' not in ended.stderr
    assert ended.stderr.splitlines()[-1].startswith('Error: ')
