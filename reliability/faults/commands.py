"""Commands from two publishers at once, and far too many of them."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rclpy.publisher import Publisher

from pneu_rig_ros.nodes.topics import create_publisher
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.cdr import pack_float64, unpack_valve_voltages
from pneu_rig_ros.rig.valve_drive import valve_voltages
from reliability.faults.finding import Finding, Scene
from reliability.proof import missing_samples
from reliability.witness import WARN, U, Witness

OTHER_U = -0.5
SEVERAL = 'several publishers'
HALF_A_SECOND_NS = 500_000_000
LONGEST = 10.0
"""Until one who fell silent is no longer followed, on a busy machine [s]."""
FLOOD_HZ = 20_000
FLOOD_SECONDS = 3.0


def two_publishers(scene: Scene) -> Finding:
    """Let a second controller speak too, then fall silent."""
    witness = scene.stage.witness
    other = create_publisher(witness.node, 'u')
    witness.until(lambda: other.get_subscription_count() >= 2, 'subscribers of u')
    witness.received.clear()
    told = _both_speak(witness, other)
    witness.node.destroy_publisher(other)
    alone = witness.until(lambda: _alone(witness), 'the first alone is followed', LONGEST)
    return Finding(
        '`u` from two publishers',
        'the newest command counts, whoever sent it',
        'valve_command WARN: u comes from several publishers, the newest command counts',
        f'told: "{told}"; both were followed; {alone:.1f} s after the second fell silent, the '
        'first alone for half a second',
        held=True,
    )


def _both_speak(witness: Witness, other: Publisher) -> str:
    """Let the other speak beside the witness until both are followed and that is told."""
    due = 0.0

    def told_and_followed() -> bool:
        nonlocal due
        if time.monotonic() > due:
            due = time.monotonic() + 0.05
            other.publish(pack_float64(OTHER_U))
        followed = {unpack_valve_voltages(m.cdr) for m in witness.received['valve_voltages']}
        return SEVERAL in witness.said['valve_command'].message and (
            valve_voltages(OTHER_U) in followed and any(map(_of_the_witness, followed))
        )

    witness.until(told_and_followed, f'{SEVERAL!r} is told, and both are followed')
    return witness.said['valve_command'].message


def _alone(witness: Witness) -> bool:
    """Return whether what was received in the last half second comes from the witness alone."""
    since = time.time_ns() - HALF_A_SECOND_NS
    late = [m for m in witness.received['valve_voltages'] if m.time_ns > since]
    return bool(late) and all(_of_the_witness(unpack_valve_voltages(m.cdr)) for m in late)


def _of_the_witness(voltages: tuple[float, float]) -> bool:
    return any(math.dist(voltages, valve_voltages(u)) < 0.01 for u in (U, -U))


@contextmanager
def _flooding() -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, '-m', 'reliability.flooder', str(FLOOD_HZ), str(FLOOD_SECONDS)]
    with subprocess.Popen(command) as process:
        try:
            yield process
        finally:
            process.kill()


def flood(scene: Scene) -> Finding:
    """Let a publisher send commands at 20 kHz."""
    fastest = answered = 0.0
    witness = scene.stage.witness
    witness.silent = True
    with _flooding() as flooder:
        told = witness.told('valve_command', WARN, 'times a second')
        while flooder.poll() is None:
            witness.turn()
            values = witness.said['valve_command'].values
            fastest = max(fastest, float(values['commands [Hz]']))
            answered = max(answered, float(values['rate [Hz]']))
    witness.silent = False
    witness.listen(2.5)
    lost = int(witness.said['recorder'].values['lost'])
    late = int(witness.said['plant'].values['late ticks'])
    record = read_recording(scene.stage.recorded(time.time_ns()))
    missing = missing_samples(record)
    return Finding(
        f'a publisher floods `u`, {FLOOD_HZ // 1000} kHz for {FLOOD_SECONDS:g} s',
        'valve_command answers the newest command at most 2000 times a second; no sample is lost',
        'valve_command WARN: u comes ... times a second, the newest command counts',
        f'{fastest:.0f} commands/s arrived, {answered:.0f}/s answered; of {record.position.size} '
        f'samples {missing} missing, {lost} messages of other topics lost, {late} ticks late',
        held=not missing and not lost and answered <= 2100 and 'times a second' in told,
    )
