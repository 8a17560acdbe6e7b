"""SIGKILL of the recorder and of each other node at random moments."""

from __future__ import annotations

import os
import random
import signal
import time
from functools import partial
from pathlib import Path

from pneu_rig_ros.records import read_record, repair
from reliability.faults.finding import Finding, Scene
from reliability.live_rig import ProcessRig
from reliability.proof import messages, unproven
from reliability.witness import Witness

MARGIN_NS = 1_000_000_000
"""What had been received this long before a recorder died has to be in its bag [ns]."""

SHORTEST, LONGEST = 1.5, 3.0
"""Life of a recorder before it is killed [s]."""

ANSWERS = {
    'plant': 'joint_states',
    'valve_command': 'valve_voltages',
    'friction_estimator': 'friction',
}
"""By which a node shows that it is back."""


def kill_recorder(scene: Scene) -> Finding:
    """Kill the recorder again and again; each time it is started anew beside its last bag."""
    chance = random.Random(scene.times)
    lost = proven = 0
    with ProcessRig(scene.folder / 'bag') as rig, Witness() as witness:
        for number in range(1, scene.times + 1):
            bag = scene.folder / ('bag' if number == 1 else f'bag_{number}')
            witness.until(partial(_begun, bag), f'{bag} is begun')
            for topic in witness.received.values():
                topic.clear()
            witness.listen(chance.uniform(SHORTEST, LONGEST))
            os.kill(rig.nodes['recorder'].number, signal.SIGKILL)
            killed_ns = time.time_ns()
            witness.until(rig.nodes['recorder'].revive, 'the recorder can be started anew')
            repair(bag)
            missing = unproven(witness.received, messages(bag), killed_ns - MARGIN_NS)
            lost += sum(missing.values())
            proven += _count(witness, killed_ns - MARGIN_NS)
            scene.step()
        witness.until(lambda: _begun(scene.folder / f'bag_{scene.times + 1}'), 'the last bag')
    return Finding(
        f'SIGKILL of the recorder, {scene.times} times',
        'what it had received 1 s before is in the bag, which can be read at once and is made '
        'whole by `pneu-rig repair`; started anew, it records into a bag beside it (`bag_2` ...)',
        'the log names the new bag',
        f'{proven} messages received up to 1 s before, {lost} of them not in the repaired bags',
        held=not lost and proven > 0,
    )


def _begun(bag: Path) -> bool:
    """Return whether there is anything in a bag."""
    file = bag / f'{bag.name}.mcap'
    return file.exists() and file.stat().st_size > 100_000


def _count(witness: Witness, until_ns: int) -> int:
    found = (m.time_ns for topic in witness.received.values() for m in topic)
    return sum(time_ns <= until_ns for time_ns in found)


def kill_nodes(scene: Scene) -> Finding:
    """Kill each of the other nodes again and again; the recorder sees all of it."""
    chance = random.Random(scene.times)
    back: list[float] = []
    with ProcessRig(scene.folder / 'bag') as rig, Witness() as witness:
        witness.hears('friction')
        for name, topic in ANSWERS.items():
            for _ in range(scene.times):
                witness.listen(chance.uniform(0.3, 1.5))
                back.append(_kill(rig, witness, name, topic))
                scene.step()
        witness.listen(1.0)
        ended_ns = time.time_ns() - MARGIN_NS
    lost = sum(unproven(witness.received, messages(scene.folder / 'bag'), ended_ns).values())
    record = read_record(scene.folder / 'bag')
    holes = record.missing['joint_states'].size * record.interval
    return Finding(
        f'SIGKILL of plant, valve_command and friction_estimator, {scene.times} times each',
        'the node is started anew (`respawn` of the launch files, `pneu-rig live --start`); the '
        'others go on. Meanwhile: without plant no samples, then the initial state on the same '
        'grid of stamps; without valve_command the valves hold their voltages, then u = 0 until '
        'a command comes; without friction_estimator no friction, which then starts anew',
        'it is missing on /diagnostics; `pneu-rig info` counts the missing samples',
        f'back after {max(back):.1f} s at most; of {_count(witness, ended_ns)} messages received '
        f'{lost} not in the bag, which reads as one record with {holes:.0f} s of samples missing',
        held=not lost,
    )


def _kill(rig: ProcessRig, witness: Witness, name: str, topic: str) -> float:
    """Kill a node and start it anew; return how long it was not heard [s]."""
    node = rig.nodes[name]
    os.kill(node.number, signal.SIGKILL)
    start = time.monotonic()
    witness.until(node.revive, f'{name} can be started anew')
    witness.listen(0.1)  # for what it had sent before
    witness.hears(topic)
    return time.monotonic() - start
