"""SIGKILL of the recorder and of each other node at random moments."""

from __future__ import annotations

import os
import random
import signal
import time
from collections import Counter
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from pneu_rig_ros.records import read_recording, repair
from pneu_rig_ros.records.bag import open_bag, storage_files
from pneu_rig_ros.records.topics import DIAGNOSTICS
from reliability.faults.finding import Finding, Scene, Stage
from reliability.live_rig import ProcessRig
from reliability.proof import messages, unproven
from reliability.witness import WATCHED, Witness

MARGIN_NS = 1_000_000_000
"""What had been received this long before a recorder died has to be in its bag [ns]."""

LONGEST_WAY = 20.0
"""On a busy machine, of what the witness has already, to the recorder that goes on [s]."""

SHORTEST, LONGEST = 1.5, 3.0
"""Life of a recorder before it is killed [s]."""

ANSWERS = {
    'plant': 'joint_states',
    'valve_command': 'valve_voltages',
    'friction_estimator': 'friction',
}
"""By which a node shows that it is back."""


PUBLISHED = {f'/{topic}' for topic in WATCHED if topic != DIAGNOSTICS}


def kill_recorder(scene: Scene) -> Finding:
    """Kill the recorder again and again; each time it is started anew beside its last bag."""
    chance = random.Random(scene.times)
    lost: Counter[str] = Counter()
    proven = 0
    for _ in range(scene.times):
        scene.stage.witness.until(partial(_begun, scene.stage), 'a bag with all topics')
        bag = scene.stage.newest_bag()
        scene.stage.witness.received.clear()
        scene.stage.witness.listen(chance.uniform(SHORTEST, LONGEST))
        killed_ns = _kill_recorder(scene.stage)
        repair(bag)
        missing = unproven(scene.stage.witness.received, messages(bag), killed_ns - MARGIN_NS)
        lost.update(missing)
        proven += _count(scene.stage.witness, killed_ns - MARGIN_NS)
        scene.stage.witness.until(partial(_begun, scene.stage, bag), f'a bag after {bag}')
        scene.step()
    return Finding(
        f'SIGKILL of the recorder, {scene.times} times',
        'what it had received 1 s before is in the bag, which can be read at once and is made '
        'whole by `pneu-rig repair`; started anew, it records into a bag beside it (`bag_2` ...)',
        'the log names the new bag',
        f'{proven} messages received up to 1 s before; of them not in the bags: {told(lost)}',
        held=not lost and proven > 0,
    )


def _kill_recorder(stage: Stage) -> int:
    """Kill it and start it anew; return when it was killed [ns since 1970]."""
    recorder = stage.rig.nodes['recorder']
    os.kill(recorder.number, signal.SIGKILL)
    killed_ns = time.time_ns()
    stage.witness.until(recorder.revive, 'the recorder can be started anew')
    return killed_ns


def _begun(stage: Stage, before: Path | None = None) -> bool:
    """Return whether a bag, not the one before, has begun with all that the rig publishes."""
    newest = stage.newest_bag()
    if newest == before or not storage_files(newest):
        return False
    with open_bag(newest) as reader:
        begun = {connection.topic for connection in reader.connections if connection.msgcount}
    return begun >= PUBLISHED


def told(lost: Mapping[str, int]) -> str:
    """Return how many were lost, with their topics if any."""
    return ', '.join(f'{count} of {topic}' for topic, count in lost.items()) or '0'


def _count(witness: Witness, until_ns: int) -> int:
    found = (m.time_ns for topic in witness.received.values() for m in topic)
    return sum(time_ns <= until_ns for time_ns in found)


def kill_nodes(scene: Scene) -> Finding:
    """Kill each of the other nodes again and again; the recorder sees all of it."""
    chance = random.Random(scene.times)
    back: list[float] = []
    deaths: list[int] = []
    witness = scene.stage.witness
    witness.received.clear()
    for name, topic in ANSWERS.items():
        for _ in range(scene.times):
            witness.listen(chance.uniform(0.3, 1.5))
            deaths.append(time.time_ns())
            back.append(_kill(scene.stage.rig, witness, name, topic))
            scene.step()
    ended_ns = time.time_ns()
    bag = scene.stage.recorded(ended_ns)
    lost = unproven(witness.received, messages(bag), ended_ns, deaths)
    patience = time.monotonic() + LONGEST_WAY
    while lost and time.monotonic() < patience:  # it may be under way to the recorder
        witness.listen(1.0)
        lost = unproven(witness.received, messages(bag), ended_ns, deaths)
    record = read_recording(bag)
    holes = record.missing['joint_states'].size * record.interval
    return Finding(
        f'SIGKILL of plant, valve_command and friction_estimator, {scene.times} times each',
        'the node is started anew (`respawn` of the launch files, `pneu-rig live --start`); the '
        'others go on. Meanwhile: without plant no samples, then the initial state on the same '
        'grid of stamps; without valve_command the valves hold their voltages, then u = 0 until '
        'a command comes; without friction_estimator no friction, which then starts anew',
        'it is missing on /diagnostics; `pneu-rig info` counts the missing samples',
        f'back after {max(back):.1f} s at most; {_count(witness, ended_ns)} messages received; of '
        f'them not in the bag: {told(lost)}; it reads as one record, {holes:.0f} s of it missing',
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
