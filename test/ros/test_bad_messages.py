"""Messages that are none, or that no sensor would send: each node tells them and goes on."""

import contextlib
import math
from collections.abc import Callable
from typing import Any

import pytest
from rclpy._rclpy_pybind11 import RCLError

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.joint_command import JointCommandNode
from pneu_rig_ros.nodes.live import LiveNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.position_controller import PositionControllerNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.shadow import ShadowNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records.cdr_decoding import unpack_joint_state, unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import (
    PlantMessages,
    pack_float64,
    pack_string,
    pack_valve_voltages,
    template,
)
from pneu_rig_ros.rig import Sample
from pneu_rig_ros.rig.valve_drive import LARGEST_COMMAND, valve_voltages

from .bystander import until

pytestmark = pytest.mark.live

NODES: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    'valve_command': (ValveCommandNode, {}),
    'plant': (PlantNode, {}),
    'friction_estimator': (FrictionEstimatorNode, {'cylinder': 'cylinder_1'}),
    'shadow': (ShadowNode, {'model': 'cylinder_1'}),
    'live': (LiveNode, {}),
    'joint_command': (JointCommandNode, {}),
    'position_controller': (PositionControllerNode, {}),
    'excitation': (ExcitationNode, {'profile': 'step', 'trigger': 'sample'}),
    'recorder': (RecorderNode, {'output': 'bag'}),
}
WILD = (math.nan, math.inf, -math.inf, 1e308, -1e308)
BAD_BYTES = (b'', b'\0', b'\0\1\0\0', b'\0\1\0\0' + b'\xff' * 60, b'\0\0\0\0' + bytes(8))


JOINT, PRESSURE = template('predicted/joint_states'), template('chamber_1/pressure')
MAKE: dict[str, Callable[[float, int], bytes]] = {
    'u': lambda value, stamp_ns: pack_float64(value),
    'reference': lambda value, stamp_ns: pack_float64(value),
    'valve_voltages': lambda value, stamp_ns: pack_valve_voltages(value, value),
    'rig_description': lambda value, stamp_ns: pack_string(f'name: {value}\n'),
    'joint_states': lambda value, stamp_ns: JOINT.at(stamp_ns, value, value, value),
    'joint_commands': lambda value, stamp_ns: JOINT.at(stamp_ns, value, value, value),
    'chamber_1/pressure': lambda value, stamp_ns: PRESSURE.at(stamp_ns, value),
}


def bad_messages(topic: str) -> list[bytes]:
    """Return messages of a topic that nobody should act upon."""
    wild = [MAKE[topic](value, 10**9 + k * 1_160_000) for k, value in enumerate(WILD)]
    torn = [message[:cut] for message in wild[:1] for cut in range(0, len(message), 3)]
    return [*wild, *torn, *BAD_BYTES]


@pytest.mark.parametrize('name', NODES)
def test_node_goes_on_after_bad_messages(
    name: str,
    context: Any,
    bystander: Any,
    loop_of: Any,
    tmp_path: Any,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    kind, parameters = NODES[name]
    runner = loop_of(kind(context, parameters))
    heard = {subscription.topic.name for subscription in runner.nodes[0].polled_subscriptions}
    for topic in filter(heard.__contains__, MAKE):
        say = bystander.speak(topic)
        until(lambda topic=topic: runner.nodes[0].count_publishers(topic))
        for message in bad_messages(topic):
            with contextlib.suppress(RCLError):  # DDS takes none that are too long
                say(message)
            runner.spin_once()
    for _ in range(20):
        runner.spin_once()
    runner.nodes[0].full_status()


def test_wild_commands_are_refused_and_told_once_a_second(
    context: Any, bystander: Any, loop_of: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    runner = loop_of(ValveCommandNode(context, {'command_timeout': 0.0}))
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    heard: set[tuple[float, float]] = set()

    def followed(value: float) -> bool:
        say(pack_float64(value))
        runner.spin_once()
        heard.update(unpack_valve_voltages(message) for message in voltages.take_all())
        return valve_voltages(value) in heard

    until(lambda: followed(-LARGEST_COMMAND))
    refused = runner.nodes[0].refused
    until(lambda: followed(1e308) or runner.nodes[0].refused >= refused + 50)
    until(lambda: followed(0.34))
    assert heard == {valve_voltages(-9.0), valve_voltages(0.34)}
    warnings = [line for line in capfd.readouterr().err.splitlines() if '1e+308' in line]
    assert 1 <= len(warnings) <= 5
    assert '/u: u is 1e+308 V, allowed are -1000 to 1000 V; keeping -1000 V' in warnings[0]


def test_estimator_tells_no_force_of_positions_that_are_none(
    context: Any, bystander: Any, loop_of: Any
) -> None:
    runner = loop_of(FrictionEstimatorNode(context, {'cylinder': 'cylinder_1'}))
    forces = bystander.hear('friction')
    topics = ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure')
    say = {topic: bystander.speak(topic) for topic in topics}
    until(lambda: runner.nodes[0].count_subscribers('friction'))
    samples, heard = PlantMessages(0.0), []
    for k in range(400):
        position = {100: math.nan, 101: 1e308}.get(k, 0.1)
        packed = samples.pack(Sample(k, position, 0.0, 2e5, 2e5), 10**9 + k * 1_160_000)
        for topic in topics:
            say[topic](packed[topic])
        runner.spin_once()
    until(lambda: (runner.spin_once(), heard.extend(forces.take_all()), len(heard) > 100)[-1])
    assert all(math.isfinite(unpack_joint_state(message).effort) for message in heard)
    assert runner.nodes[0].refused == 2


def test_wild_parameters_are_refused_in_one_line(context: Any) -> None:
    for wild in WILD:
        with pytest.raises(RigError, match='supply_pressure') as told:
            PlantNode(context, {'supply_pressure': wild})
        assert str(told.value).isprintable()
    for name, value in {'cylinder': '../\x1b[2J\n', 'friction': 'x' * 5000, 'seed': -2}.items():
        with pytest.raises(RigError) as told:
            PlantNode(context, {name: value})
        assert str(told.value).isprintable()
