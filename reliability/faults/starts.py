"""A middleware that is not installed; a command that is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil

from pneu_rig_ros.records import read_recording
from reliability.faults.finding import Finding, Scene
from reliability.live_rig import until
from reliability.witness import Witness


def wrong_middleware(scene: Scene) -> Finding:
    """Ask for a middleware that does not exist, of a node and of a command."""
    asked = {**os.environ, 'RMW_IMPLEMENTATION': 'rmw_nowhere_cpp'}
    codes, lines = [], []
    for arguments in (['pneu_rig_ros.nodes.plant'], ['pneu_rig_ros.cli', 'demo']):
        command = [sys.executable, '-m', *arguments]
        done = subprocess.run(
            command, env=asked, cwd=scene.folder, capture_output=True, text=True, check=False
        )
        codes.append(done.returncode)
        lines += done.stderr.splitlines()
    return Finding(
        'RMW_IMPLEMENTATION that is not installed',
        'node or command ends with exit code 2',
        'one line',
        f'"{lines[0]}"',
        held=codes == [2, 2] and len(lines) == 2,
    )


def killed_demo(scene: Scene) -> Finding:
    """Kill `pneu-rig demo`, which owns four nodes."""
    bag = scene.folder / 'bag'
    command = [sys.executable, '-m', 'pneu_rig_ros.cli', 'demo', '--duration', '600']
    with subprocess.Popen([*command, '--out', str(bag)], stderr=subprocess.DEVNULL) as demo:
        until(lambda: _size(bag) > 300_000, 'the demonstration records')
        nodes = psutil.Process(demo.pid).children(recursive=True)
        demo.send_signal(signal.SIGKILL)
        demo.wait()
        start = time.monotonic()
        until(lambda: not any(map(psutil.Process.is_running, nodes)), 'its nodes end')
    took = time.monotonic() - start
    record = read_recording(bag)
    missing = record.missing['joint_states'].size
    return Finding(
        'SIGKILL of `pneu-rig demo`',
        'its nodes notice that their owner is gone and end in good order; the bag is complete',
        'none: nobody is left to be told',
        f'{len(nodes)} processes gone after {took:.1f} s; {record.duration:.1f} s in the bag, '
        f'{missing} samples missing',
        held=not missing and len(nodes) >= 4 and (bag / 'metadata.yaml').exists(),
    )


def killed_in_live(scene: Scene) -> Finding:
    """Kill the plant of `pneu-rig live --start`."""
    command = [sys.executable, '-m', 'pneu_rig_ros.cli', 'live', '--start', 'cylinder_2']
    with (
        subprocess.Popen([*command, '--port', '0'], stdout=subprocess.PIPE,
                         stderr=subprocess.PIPE, text=True) as live,
        Witness() as witness,
    ):  # fmt: skip
        witness.hears('friction')
        children = psutil.Process(live.pid).children(recursive=True)
        (plant,) = [p for p in children if 'pneu_rig_ros.nodes.plant' in p.cmdline()]
        plant.send_signal(signal.SIGKILL)
        witness.listen(0.3)
        back = 0.3 + witness.hears('joint_states')
        witness.hears('friction')
        live.send_signal(signal.SIGINT)
        _, errors = live.communicate(timeout=60)
    said = [line for line in errors.splitlines() if 'started anew' in line]
    return Finding(
        'SIGKILL of the plant of `pneu-rig live --start`',
        'it is started anew, the others and the page go on',
        'one line of the command; the page shows that no samples come',
        f'back after {back:.1f} s; "{said[0] if said else errors}"',
        held=len(said) == 1 and live.returncode == 0,
    )


def _size(bag: Path) -> int:
    file = bag / f'{bag.name}.mcap'
    return file.stat().st_size if file.exists() else 0
