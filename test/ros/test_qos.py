"""Publishers that are best effort are received; other incompatible QoS is reported."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rclpy.qos import qos_profile_sensor_data
from rosbags.rosbag2 import Reader
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.qos import qos_profile
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.topics import message_class
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records.cdr_decoding import unpack_float64, unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import PlantMessages, pack_float64
from pneu_rig_ros.records.topics import SAMPLE_TOPICS, TOPICS
from pneu_rig_ros.rig import Sample
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .bystander import Bystander, until

pytestmark = pytest.mark.live

COUNT = 400


def mutter(bystander: Bystander, runner: Runner, topic: str) -> Callable[[bytes], None]:
    """Return what publishes best effort, once the nodes of the runner listen to it."""
    kind = message_class(TOPICS[topic].type)
    publisher = bystander.create_publisher(kind, topic, qos_profile_sensor_data)
    until(lambda: runner.spin_once() or publisher.get_subscription_count() == 1)
    return publisher.publish


def test_valves_follow_a_best_effort_controller_without_a_warning(
    context: Any, bystander: Bystander, loop_of: Any
) -> None:
    runner = loop_of(ValveCommandNode(context, {'command_timeout': 0.0}))
    voltages, say = bystander.hear('valve_voltages'), mutter(bystander, runner, 'u')
    until(lambda: runner.nodes[0].count_subscribers('valve_voltages'))
    timer, heard = runner.nodes[0].loop_timer(), []
    for u in (0.1, 0.2, 0.3):
        say(pack_float64(u))
        timer.wait()
        until(lambda: runner.spin_once() or heard.extend(voltages.take_all()) or heard)
        assert unpack_valve_voltages(heard.pop()) == valve_voltages(u)
    message = runner.nodes[0].full_status().message
    assert 'QoS' not in message


def test_recorder_keeps_each_command_once_whoever_sends_it(
    context: Any, bystander: Bystander, tmp_path: Path
) -> None:
    runner = Runner([RecorderNode(context, {'output': str(tmp_path / 'bag')})])
    reliable = bystander.speak('u')
    unreliable = mutter(bystander, runner, 'u')
    for k in range(COUNT):
        reliable(pack_float64(k))
        unreliable(pack_float64(-k - 1))
        runner.spin_once()
    until(lambda: runner.spin_once() or runner.nodes[0].rate.count >= 2 * COUNT)
    for _ in range(50):
        runner.spin_once()
    lost = runner.nodes[0].status().values['lost']
    runner.close()
    with Reader(tmp_path / 'bag') as reader:
        connections = [c for c in reader.connections if c.topic == '/u']
        kept = [unpack_float64(bytes(cdr)) for *_, cdr in reader.messages(connections)]
    assert sorted(kept) == [float(k) for k in range(-COUNT, COUNT)]
    assert lost == 0


def test_friction_of_sensors_that_are_best_effort(
    context: Any, bystander: Bystander, loop_of: Any
) -> None:
    runner = loop_of(FrictionEstimatorNode(context, {'cylinder': 'cylinder_1'}))
    forces = bystander.hear('friction')
    say = {topic: mutter(bystander, runner, topic) for topic in SAMPLE_TOPICS}
    samples, heard = PlantMessages(0.0), []
    for k in range(COUNT):
        packed = samples.pack(Sample(k, 0.1, 0.0, 2e5, 2e5), 10**9 + k * 1_160_000)
        for topic in SAMPLE_TOPICS:
            say[topic](packed[topic])
        runner.spin_once()
    until(lambda: runner.spin_once() or heard.extend(forces.take_all()) or len(heard) > 100)


def test_incompatible_qos_is_reported_while_it_is_there(context, bystander, loop_of):
    runner = loop_of(FrictionEstimatorNode(context))
    publisher = bystander.create_publisher(String, 'rig_description', 1)
    latched = qos_profile(TOPICS['rig_description'])
    kept = bystander.create_subscription(JointState, 'friction', lambda _: None, latched)
    other = qos_profile(TOPICS['friction'])
    bystander.create_subscription(JointState, 'friction', lambda _: None, other)

    def warnings():
        runner.spin_once()
        message = runner.nodes[0].full_status().message
        return [
            text for text in ('publisher of /rig_description', 'to /friction') if text in message
        ]

    until(lambda: len(warnings()) == 2)
    bystander.destroy_publisher(publisher)
    until(lambda: warnings() == ['to /friction'])
    bystander.destroy_subscription(kept)
    until(lambda: warnings() == [])  # another one that is compatible remains
