"""The topics of ros2_control over DDS, by a twin of its hardware component and its PID."""

import math
import time
from pathlib import Path

import pytest
import yaml
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState

from pneu_rig_ros.nodes.joint_command import JointCommandNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records.cdr_decoding import unpack_float64
from pneu_rig_ros.records.topics import PISTON

from .bystander import PATIENCE, until

pytestmark = pytest.mark.live

FILE = Path(__file__).resolve().parents[2] / 'config' / 'ros2_control.yaml'
GAINS = yaml.safe_load(FILE.read_text())['position_pid']['ros__parameters']['gains'][PISTON]


class HardwareTwin:
    """What JointStateTopicSystem 1.1.0 does on its topics for a joint with one command."""

    def __init__(self, node):
        self.node = node
        self.publisher = node.create_publisher(JointState, 'joint_commands', QoSProfile(depth=1))
        self.subscription = node.create_subscription(
            JointState, 'joint_states', print, qos_profile_sensor_data
        )
        self.position = self.velocity = math.nan

    def read(self):
        while (taken := self.subscription.handle.take_message(JointState, False)) is not None:
            index = taken[0].name.index(PISTON)
            self.position, self.velocity = taken[0].position[index], taken[0].velocity[index]

    def write(self, **values):
        """Publish the fields of the command interfaces alone, NaN before a controller writes."""
        message = JointState(name=[PISTON], **{name: [v] for name, v in values.items()})
        message.header.stamp = self.node.get_clock().now().to_msg()
        self.publisher.publish(message)

    def pid(self, reference):
        """Return the command of pid_controller for a reference at rest."""
        command = GAINS['p'] * (reference - self.position) - GAINS['d'] * self.velocity
        return min(max(command, GAINS['u_clamp_min']), GAINS['u_clamp_max'])


def test_the_chain_moves_the_piston_to_its_reference_and_back(loop_of, context, bystander):
    plant = PlantNode(context, {'cylinder': 'cylinder_1', 'initial_position': 0.1})
    runner = loop_of(plant, JointCommandNode(context), ValveCommandNode(context))
    twin = HardwareTwin(bystander)
    for reference in (0.15, 0.06):
        settled, deadline = [], time.monotonic() + PATIENCE

        def step(reference=reference, settled=settled, deadline=deadline):
            twin.read()
            if math.isnan(twin.position):
                twin.write(velocity=math.nan)
            else:
                twin.write(velocity=twin.pid(reference))
                close = abs(twin.position - reference) < 2e-3 and abs(twin.velocity) < 1e-2
                settled.append(1) if close else settled.clear()
            return len(settled) < 300 and time.monotonic() < deadline

        runner.run(step)
        assert len(settled) == 300
    assert runner.nodes[1].refused == 0


@pytest.mark.parametrize(
    ('command', 'expected'),
    [
        ({'velocity': 0.2}, 0.6),
        ({'effort': -100.0}, -1.0),
        ({'velocity': 0.2, 'effort': 100.0}, 1.6),
        ({'velocity': math.nan, 'effort': 50.0}, 0.5),  # one of two interfaces claimed
        ({'position': 0.1, 'velocity': 0.1}, 0.3),
    ],
)
def test_u_is_the_scaled_command(loop_of, context, bystander, command, expected):
    runner, twin = loop_of(JointCommandNode(context)), HardwareTwin(bystander)
    heard = bystander.hear('u')
    until(
        lambda: runner.nodes[0].count_subscribers('u') and twin.publisher.get_subscription_count()
    )
    twin.write(**command)
    messages = []
    until(lambda: runner.spin_once() or messages.extend(heard.take_all()) or messages)
    assert unpack_float64(messages[0]) == pytest.approx(expected)


def test_what_is_not_a_command_has_no_answer(loop_of, context, bystander):
    runner, twin = loop_of(JointCommandNode(context)), HardwareTwin(bystander)
    node, heard = runner.nodes[0], bystander.hear('u')
    until(lambda: node.count_subscribers('u') and twin.publisher.get_subscription_count())

    def written(message, counted):
        message()
        until(lambda: runner.spin_once() or counted())

    written(lambda: twin.write(velocity=math.nan), lambda: node._idle == 1)
    wrong = (
        lambda: twin.write(position=0.1),
        lambda: twin.write(velocity=math.inf),
        lambda: twin.write(velocity=math.inf, effort=-math.inf),
        lambda: twin.write(velocity=5.98e307, effort=1.7e308),  # whose sum is infinite
        lambda: twin.publisher.publish(JointState(name=['elbow'], velocity=[0.1])),
        lambda: twin.publisher.publish(JointState(name=['elbow', PISTON], velocity=[0.1])),
    )
    for number, message in enumerate(wrong, 1):
        written(message, lambda number=number: node.refused == number)
    assert heard.take() is None
    other = JointState(name=['elbow_', PISTON], velocity=[9.0, 0.1])  # names of any length
    written(lambda: twin.publisher.publish(other), lambda: node.rate.count == 1)
    messages = []
    until(lambda: messages.extend(heard.take_all()) or messages)
    assert [unpack_float64(message) for message in messages] == [pytest.approx(0.3)]
