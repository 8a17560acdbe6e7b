"""
The launch files for `launch_test`, in a sourced workspace: `launch_test test/ros/rig_launch.py`.

`test_colcon.py` runs it where launch_testing is installed.
"""

import os
import tempfile
import time
import unittest
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import launch_testing
import rclpy
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare
from launch_testing.actions import ReadyToTest
from launch_testing.asserts import assertExitCodes
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState

from pneu_rig_ros.records import read_recording

PACKAGE = 'pneu_rig_ros'
PATIENCE = 120.0  # s, for a first start, which compiles the plant
SAMPLES = 1000
INTERVAL_NS = 1_160_000
MANAGED = ('plant', 'valve_command', 'friction_estimator', 'recorder')
FOLDER = Path(tempfile.mkdtemp())


@launch_testing.parametrize('name', ['rig', 'lifecycle', 'closed_loop'])
def generate_test_description(name: str) -> LaunchDescription:
    """Return a launch file, as it is installed, that records into a bag of its own."""
    file = PathJoinSubstitution([FindPackageShare(PACKAGE), 'launch', f'{name}.launch.py'])
    arguments = {'output': str(FOLDER / name), 'namespace': name}.items()
    launched = IncludeLaunchDescription(file, launch_arguments=arguments)
    return LaunchDescription([launched, ReadyToTest()])


class TestWhileItRuns(unittest.TestCase):
    """What another node observes."""

    def setUp(self) -> None:
        """Create a node in the domain of the rig."""
        self.context = Context()
        rclpy.init(context=self.context, domain_id=int(os.environ.get('ROS_DOMAIN_ID', '0')))
        self.node = Node('observer', context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def tearDown(self) -> None:
        """Destroy it."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)

    def until(self, condition: Any) -> None:
        """Spin until a condition holds."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, 'took too long'
            self.executor.spin_once(timeout_sec=0.1)

    def test_samples_come_and_every_node_is_active(self, name: str) -> None:
        """Stamps are on the grid of the sampling interval; the lifecycle services answer."""
        stamps: list[int] = []

        def take(sample: JointState) -> None:
            stamps.append(sample.header.stamp.sec * 10**9 + sample.header.stamp.nanosec)

        self.node.create_subscription(JointState, f'/{name}/joint_states', take, 5000)
        self.until(lambda: len(stamps) >= SAMPLES)
        assert {(stamp - stamps[0]) % INTERVAL_NS for stamp in stamps} == {0}
        for managed in MANAGED:
            client = self.node.create_client(GetState, f'/{name}/{managed}/get_state')
            self.until(client.service_is_ready)
            answer = client.call_async(GetState.Request())
            self.until(answer.done)
            assert answer.result().current_state.id == State.PRIMARY_STATE_ACTIVE, managed


@launch_testing.post_shutdown_test()
class TestAfterTheEnd(unittest.TestCase):
    """What is left behind."""

    def test_every_process_ended_with_code_0(self, proc_info: Iterable[Any]) -> None:
        """All are interrupted at the same moment, as by Ctrl-C."""
        assertExitCodes(proc_info)

    def test_no_sample_is_missing_in_the_bag(self, name: str) -> None:
        """The bag is closed and complete, from its first sample on."""
        recording = read_recording(FOLDER / name)
        assert len(recording.time) >= SAMPLES
        assert len(recording.missing['joint_states']) == 0
