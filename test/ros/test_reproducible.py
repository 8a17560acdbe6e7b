"""The same seed gives the same bag, byte for byte, in every process and in lock step."""

import json
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

from pneu_rig_ros.records.topics import DIAGNOSTICS

SEED = 7
REVISION = re.compile(rb'git revision \S+')
PROFILE = 'drives: u\nshape: staircase\nlevels: [0.0 V, 0.34 V, -0.3 V, 0.5 V]\nhold: 0.4 s\n'


def run(*arguments: object) -> None:
    command = [sys.executable, '-m', *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


def content(bag: Path) -> Mapping[str, list[tuple[int, bytes]]]:
    """Return times and bytes of all messages, without what tells of real time and of git."""
    found: dict[str, list[tuple[int, bytes]]] = defaultdict(list)
    with Reader(bag) as reader:
        for connection, time, cdr in reader.messages():
            if connection.topic != DIAGNOSTICS:
                data = REVISION.sub(b'', bytes(cdr))
                found[connection.topic].append((time, data))
    return found


def test_two_processes_simulate_the_same_bytes(tmp_path: Path) -> None:
    for name in ('a', 'b'):
        stroke = '--duration', 3, '--u', 0.34, '--seed', SEED
        run('pneu_rig_ros.cli', 'simulate', *stroke, '--out', tmp_path / name, '--quiet')
    first, second = content(tmp_path / 'a'), content(tmp_path / 'b')
    assert first == second
    assert len(first['/joint_states']) == 2587


@pytest.mark.live
def test_two_rigs_in_lock_step_record_the_same_bytes(tmp_path: Path) -> None:
    profile = tmp_path / 'profile.yaml'
    profile.write_text(PROFILE)
    for name in ('a', 'b'):
        record_in_lock_step(profile, tmp_path / name)
    first, second = content(tmp_path / 'a'), content(tmp_path / 'b')
    assert len(first['/joint_states']) > 1.5e9 / 1_160_000
    assert first == second


def record_in_lock_step(profile: Path, bag: Path) -> None:
    parameters = {
        'use_sim_time': True,
        'plant:speed': 0.0,
        'plant:seed': SEED,
        'excitation:profile': str(profile),
        'valve_command:command_timeout': 0.0,
        'recorder:output': str(bag),
    }
    options = [part for key, v in parameters.items() for part in ('-p', f'{key}:={json.dumps(v)}')]
    run('pneu_rig_ros.nodes.rig_with_excitation', '--ros-args', *options)
