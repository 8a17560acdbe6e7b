"""What other ROS tools expect in messages: frames that exist, an id of the hardware."""

import io
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from yourdfpy import URDF

from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.topics import message_class
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records.cdr_decoding import unpack_string, unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.records.topics import DIAGNOSTICS, TOPICS

from .bystander import Bystander, gather, until

pytestmark = pytest.mark.live

STAMPED = {
    'joint_states': 'base',
    'friction': 'base',
    'chamber_1/pressure': 'cylinder',
    'chamber_2/pressure': 'cylinder',
}


@pytest.mark.parametrize('namespace', ['', 'left'])
def test_headers_name_links_of_the_robot_and_diagnostics_the_rig(
    new_context: Any, loop_of: Any, namespace: str
) -> None:
    context = new_context('-r', f'__ns:=/{namespace}') if namespace else new_context()
    watcher = Bystander(context, namespace=f'/{namespace}')
    names = (*STAMPED, 'robot_description', DIAGNOSTICS)
    subscriptions = {name: watcher.hear(name) for name in names}
    nodes = [PlantNode(context), ValveCommandNode(context), FrictionEstimatorNode(context)]
    runner = loop_of(*nodes)
    ids: set[str] = set()
    messages = {}
    for name, subscription in subscriptions.items():
        cdr = gather(runner, [subscription], 1)[0][0]
        messages[name] = deserialize_message(cdr, message_class(TOPICS[name].type))
        if name == 'robot_description':
            links = set(URDF.load(io.BytesIO(unpack_string(cdr).encode())).link_map)
    for cdr in gather(runner, [subscriptions[DIAGNOSTICS]], len(nodes))[0]:
        array: Any = deserialize_message(cdr, DiagnosticArray)
        ids |= {status.hardware_id for status in array.status}
    watcher.destroy_node()
    prefix = f'{namespace}/' if namespace else ''
    for name, link in STAMPED.items():
        assert messages[name].header.frame_id == f'{prefix}{link}'
        assert link in links
    assert ids == {f'pneu_rig/{namespace}'.rstrip('/')}


def test_parameters_are_described_and_the_time_source_stays(
    context: Context, bystander: Bystander, loop_of: Any
) -> None:
    runner = loop_of(PlantNode(context))

    names = ['supply_pressure', 'friction', 'seed', 'speed']
    service = 'plant/describe_parameters'
    answer = bystander.call(runner, DescribeParameters, service, names=names)
    supply, friction, seed, speed = answer.descriptors
    assert (supply.floating_point_range[0].to_value, supply.read_only) == (1.1e6, False)
    assert "one of '', coulomb_viscous, lugre" in friction.additional_constraints
    assert seed.integer_range[0].from_value == -1
    assert 'use_sim_time' in speed.additional_constraints
    assert all(one.read_only for one in (friction, seed, speed))
    change = Parameter('use_sim_time', value=True).to_parameter_msg()
    service = 'plant/set_parameters'
    (result,) = bystander.call(runner, SetParameters, service, parameters=[change]).results
    assert 'fixed while the node runs' in result.reason


def test_valves_are_told_to_shut_before_any_command(
    context: Context, bystander: Bystander, loop_of: Any
) -> None:
    gather(loop_of(ValveCommandNode(context)), [bystander.hear('valve_voltages')], 1)


def test_nodes_and_topics_are_remapped(new_context: Any, loop_of: Any) -> None:
    remaps = ['-r', 'u:=/bench/command', '-r', 'valve_voltages:=/bench/volts']
    context = new_context(*remaps, '-r', 'valve_command:__node:=valves')
    driver, watcher = Bystander(context), Bystander(new_context())
    voltages, statuses = driver.hear('valve_voltages'), driver.hear(DIAGNOSTICS)
    runner = loop_of(ValveCommandNode(context, {'command_timeout': 0.0}))
    driver.speak('u')(pack_float64(1.0))
    (cdr,), (status,) = gather(runner, [voltages, statuses], 1)
    array: Any = deserialize_message(status, DiagnosticArray)
    assert unpack_valve_voltages(cdr)[0] > 3.0
    assert [item.name for item in array.status] == ['/valves']
    until(lambda: watcher.count_publishers('/bench/command'))
    until(lambda: watcher.count_publishers('/bench/volts'))
    assert {'u', 'valve_voltages'}.isdisjoint(
        name.strip('/') for name, _ in watcher.get_topic_names_and_types()
    )
    driver.destroy_node()
    watcher.destroy_node()
