"""Who comes late, who does not fit, who is there twice, who stands still."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable

from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64

from pneu_rig_ros.nodes import wiring
from pneu_rig_ros.records import read_record
from pneu_rig_ros.records.topics import TOPICS
from reliability.faults.finding import Finding, Scene
from reliability.live_rig import ORDER, ProcessRig
from reliability.proof import messages, missing_samples
from reliability.witness import OK, WARN, Witness

STILL = 3.0
"""How long a process stands still [s]."""


def late_joiners(scene: Scene) -> Finding:
    """Start recorder, estimator and a listener when the rig has run for a while."""
    early = {name: {'wait_for_subscribers': 0} for name in ORDER[:3]}
    with ProcessRig(scene.folder / 'bag', early, only=('plant', 'valve_command')) as rig:
        with Witness() as witness:
            witness.hears('joint_states')
            waiting = witness.until(lambda: witness.received['rig_description'], 'description')
            witness.listen(2.0)
        for name in ('recorder', 'friction_estimator'):
            rig.start(name)
        with Witness() as late:
            late.hears('friction')
            late.listen(1.0)
            described = {name: len(late.received[name]) for name in TOPICS if TOPICS[name].latched}
    record = read_record(scene.folder / 'bag')
    configured = record.configuration is not None
    held = configured and described['rig_description'] == 1 and waiting < 5.0
    return Finding(
        'late joiners',
        'rig_description and robot_description reach whoever comes later; the bag has the '
        'configuration, friction is estimated',
        'friction_estimator WARN: waiting for rig_description, until it comes',
        f'a recorder started 2 s later: configuration in its bag: {"yes" if configured else "no"}',
        held,
    )


def wrong_quality(scene: Scene) -> Finding:
    """Command with best effort, and listen for samples as if they were kept for late joiners."""
    with ProcessRig(scene.folder / 'bag') as rig, Witness(commands=False) as witness:
        witness.hears('friction')
        unreliable = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        publisher = witness.node.create_publisher(Float64, 'u', unreliable)
        kept = wiring.quality(TOPICS['rig_description'])
        subscription = witness.node.create_subscription(Float64, 'position', _ignored, kept)
        told = [
            witness.told('valve_command', WARN, 'does not fit'),
            witness.told('recorder', WARN, 'does not fit'),
            witness.told('plant', WARN, 'does not fit'),
        ]
        witness.node.destroy_publisher(publisher)
        witness.node.destroy_subscription(subscription)
        for node in ('valve_command', 'plant'):
            witness.told(node, OK, '')
        rig.check()
    return Finding(
        'a publisher or subscriber whose quality of service does not fit',
        'it is not heard, or gets nothing; the others are not touched',
        'WARN of each node concerned, for as long as it is there, and a line in the log',
        f'told: "{told[0]}", "{told[2]}"',
        held=all('does not fit' in text for text in told),
    )


def _ignored(_: object) -> None:
    """Do nothing."""


def two_rigs(scene: Scene) -> Finding:
    """Start a second rig in the same namespace and domain."""
    with ProcessRig(scene.folder / 'bag') as rig, Witness() as witness:
        witness.hears('friction')
        witness.listen(1.0)
        with ProcessRig(scene.folder / 'second') as second:
            witness.until(_all_ended(second), 'the second rig ends')
            codes = {name: second.nodes[name].code for name in ORDER}
            lines = [second.log(name).strip().splitlines()[-1] for name in ORDER]
        rig.check()
        witness.listen(1.0)
    record = read_record(scene.folder / 'bag')
    missing = missing_samples(record)
    extra = len(messages(scene.folder / 'bag')['joint_states']) - record.position.size
    held = set(codes.values()) == {2} and not missing and not extra
    return Finding(
        'two rigs in one domain without namespaces',
        'the nodes of the second give way with exit code 2; the first goes on untouched',
        'one line each; two that start at the same moment both say ERROR: another ... is running',
        f'"{lines[0]}"; first rig: {missing} samples missing, {extra} from the second',
        held,
    )


def _all_ended(rig: ProcessRig) -> Callable[[], bool]:
    return lambda: all(node.ended() for node in rig.nodes.values())


def standing_still(scene: Scene) -> Finding:
    """Stop each process but the plant for some seconds, as a debugger or a swapped disk would."""
    with ProcessRig(scene.folder / 'bag') as rig, Witness() as witness:
        witness.hears('friction')
        for name in ORDER[1:]:
            number = rig.nodes[name].number
            os.kill(number, signal.SIGSTOP)
            witness.listen(STILL)
            os.kill(number, signal.SIGCONT)
            witness.listen(1.0)
            witness.hears('friction')
            scene.step()
        witness.listen(2.0)
        lost = int(witness.said['recorder'].values['lost'])
    record = read_record(scene.folder / 'bag')
    missing = missing_samples(record)
    return Finding(
        f'recorder, estimator and valve_command stand still for {STILL:g} s (SIGSTOP)',
        'what was sent meanwhile comes afterwards, up to 23 s; u falls to 0 if the commands stop',
        'recorder WARN: ... messages lost, if there were any',
        f'of {record.position.size} samples {missing} missing, {lost} messages lost',
        held=not missing and not lost,
    )
