"""Who comes late, who does not fit, who is there twice, who stands still."""

from __future__ import annotations

import os
import signal
import time

from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.qos import qos_profile
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.topics import TOPICS
from reliability.faults.finding import Finding, Scene
from reliability.live_rig import ORDER, ProcessRig
from reliability.proof import missing_samples
from reliability.witness import WARN, Witness

MISFIT = 'incompatible QoS'

STILL = 3.0
"""How long a process stands still [s]."""


def late_joiners(scene: Scene) -> Finding:
    """Come to a rig that runs, as a listener; its recorder was started anew in the meantime."""
    scene.stage.witness.listen(0.1)
    latched = [name for name, topic in TOPICS.items() if topic.latched]
    with Witness(commands=False, topics=latched) as late:
        waited = late.until(lambda: all(late.received[name] for name in latched), 'descriptions')
    configured = read_recording(scene.stage.newest_bag()).configuration is not None
    return Finding(
        'late joiners',
        'rig_description and robot_description reach whoever comes later; the bag has the '
        'configuration, friction is estimated',
        'friction_estimator WARN: waiting for rig_description, until it comes',
        f'both descriptions {waited:.1f} s after the start of a listener; configuration in the '
        f'bag of a recorder that came late: {"yes" if configured else "no"}',
        held=configured,
    )


def wrong_quality(scene: Scene) -> Finding:
    """Command with best effort, and listen for samples as if they were kept for late joiners."""
    witness = scene.stage.witness
    unreliable = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = witness.node.create_publisher(Float64, 'u', unreliable)
    kept = qos_profile(TOPICS['rig_description'])
    subscription = witness.node.create_subscription(Float64, 'position', _ignored, kept)
    concerned = 'valve_command', 'recorder', 'plant'
    told = [witness.told(node, WARN, MISFIT) for node in concerned]
    witness.node.destroy_publisher(publisher)
    witness.node.destroy_subscription(subscription)
    for node in concerned:
        witness.until(lambda name=node: MISFIT not in witness.said[name].message, 'it has gone')  # type: ignore[misc]
    scene.stage.rig.check()
    return Finding(
        'a publisher or subscriber whose quality of service does not fit',
        'it is not heard, or gets nothing; the others are not touched',
        'WARN of each node concerned, for as long as it is there, and a line in the log',
        f'told: "{told[0]}"',
        held=True,
    )


def _ignored(_: object) -> None:
    """Do nothing."""


def two_rigs(scene: Scene) -> Finding:
    """Start a second rig in the same namespace and domain, while the first is seen at work."""
    scene.stage.witness.hears('friction')
    with ProcessRig(scene.folder / 'second') as second:
        _await_end(second, scene.stage.witness)
        codes = {node.code for node in second.nodes.values()}
        line = second.log('plant').strip().splitlines()[-1]
        bags = list(scene.folder.iterdir())
    scene.stage.rig.check()
    scene.stage.witness.listen(1.0)
    # a sample of another rig between the others would be refused
    missing = missing_samples(read_recording(scene.stage.recorded(time.time_ns())))
    held = codes == {2} and not missing and not bags
    return Finding(
        'two rigs in one domain without namespaces',
        'the nodes of the second give way with exit code 2; the first goes on untouched',
        'one line each; of two that start at the same moment on one computer, one gives way',
        f'"{line}"; first rig: {missing} samples missing, none from the second',
        held,
    )


def _await_end(rig: ProcessRig, witness: Witness) -> None:
    """Listen until all nodes have ended; RigError with what the others said if they do not."""

    def going_on() -> list[str]:
        return [name for name, node in rig.nodes.items() if not node.ended()]

    try:
        witness.until(lambda: not going_on(), '')
    except RigError as error:
        logs = {name: rig.log(name)[-500:] for name in going_on()}
        said = {name: witness.said.get(name) for name in going_on()}
        raise RigError(f'the second rig goes on: {logs}, heard: {said}') from error


def standing_still(scene: Scene) -> Finding:
    """Stop each process but the plant for some seconds, as a debugger or a swapped disk would."""
    rig, witness = scene.stage.rig, scene.stage.witness
    numbers = [rig.nodes[name].number for name in ORDER[1:]]
    for number in numbers:
        os.kill(number, signal.SIGSTOP)
    witness.listen(STILL)
    for number in numbers:
        os.kill(number, signal.SIGCONT)
    witness.hears('friction')
    witness.listen(2.0)
    lost = int(witness.said['recorder'].values['lost'])
    record = read_recording(scene.stage.recorded(time.time_ns()))
    missing = missing_samples(record)
    return Finding(
        f'recorder, estimator and valve_command stand still for {STILL:g} s (SIGSTOP)',
        'what was sent meanwhile comes afterwards, up to 23 s; u falls to 0 if the commands stop',
        'recorder WARN: ... messages lost, if there were any',
        f'of {record.position.size} samples {missing} missing, {lost} messages lost',
        held=not missing and not lost,
    )
