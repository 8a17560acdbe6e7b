"""A bag played into a running rig as `ros2 bag play` does: all topics, in the QoS of the bag."""

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.rosbag2 import Reader

from pneu_rig_ros.nodes.rig import NODES
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.topics import message_class
from pneu_rig_ros.records.topics import SAMPLE_TOPICS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .bystander import Bystander, gather

pytestmark = pytest.mark.live

U, DURATION = 0.34, 4.0
INTERVAL_NS = 5_000_000
"""Slow enough for one process that has all the nodes and the player."""


def player(node: Bystander, bag: Path) -> Iterator[bool]:
    """Publish what is due, each time that the next value is asked for; True until the end."""
    information = yaml.safe_load((bag / 'metadata.yaml').read_text())
    publishers = {}
    for entry in information['rosbag2_bagfile_information']['topics_with_message_count']:
        topic = entry['topic_metadata']
        (offered,) = topic['offered_qos_profiles']
        quality = QoSProfile(
            depth=offered['depth'],
            reliability=ReliabilityPolicy[offered['reliability'].upper()],
            durability=DurabilityPolicy[offered['durability'].upper()],
        )
        kind = message_class(topic['type'])
        publishers[topic['name']] = node.create_publisher(kind, topic['name'], quality)
    with Reader(bag) as reader:
        begin = time.monotonic_ns() + 500_000_000 - reader.start_time
        for connection, log_time, cdr in reader.messages():
            while time.monotonic_ns() < begin + log_time:
                yield True
            publishers[connection.topic].publish(bytes(cdr))
    yield False


def test_rig_goes_on_and_says_that_there_is_another_source(
    context: Any, bystander: Bystander, tmp_path: Path
) -> None:
    slow = replace(load_configuration('cylinder_2'), interval_ns=INTERVAL_NS)
    bag = simulate(slow, U, DURATION, tmp_path / 'bag')
    recorded = {'output': str(tmp_path / 'recorded')}
    parameters: list[dict[str, Any]] = [{'interval_ns': INTERVAL_NS}, {}, {}, recorded]
    nodes = [node(context, given) for node, given in zip(NODES, parameters, strict=True)]
    runner = Runner(nodes)
    forces = bystander.hear('friction')
    gather(runner, [forces], 1)
    playing, due = player(bystander, bag), 0.0
    said: dict[str, set[str]] = {node.get_name(): set() for node in nodes}

    def going_on() -> bool:
        nonlocal due
        if time.monotonic() > due:
            due = time.monotonic() + 0.5
            for node in nodes:
                said[node.get_name()] |= set(node.full_status().message.split('; '))
        return next(playing)

    runner.run(going_on)
    lost = nodes[3].status().values['lost']
    list(forces.take_all())
    gather(runner, [forces], 50)  # of the rig alone again
    runner.close()
    several = 'comes from several publishers'
    assert {f'/{topic} {several}' for topic in SAMPLE_TOPICS} <= said['friction_estimator']
    assert f'/joint_states {several}' in said['recorder']
    assert lost == 0
    with Reader(tmp_path / 'recorded') as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
    with Reader(bag) as reader:
        played = {c.topic: c.msgcount for c in reader.connections}
    assert all(counts[topic] >= count for topic, count in played.items())
