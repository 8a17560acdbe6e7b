"""
The files for ros2_control, which has no wheel: what its parsers and controllers would read.

Names of plugins and parameters are those of joint_state_topic_hardware_interface 1.1.0 and of
the branch jazzy of ros2_controllers.
"""

import io
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from yourdfpy import URDF

from pneu_rig_ros.records.topics import PISTON, TOPICS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.urdf import controlled_description
from pneu_rig_ros.rig.yaml_file import shipped

ROOT = Path(__file__).resolve().parents[2]
CONTROLLERS = yaml.safe_load((ROOT / 'config' / 'ros2_control.yaml').read_text())
ALLOWED = {
    'joint_state_broadcaster/JointStateBroadcaster': {'joints', 'interfaces'},
    'forward_command_controller/ForwardCommandController': {'joints', 'interface_name'},
    'pid_controller/PidController': {
        'dof_names',
        'command_interface',
        'reference_and_state_interfaces',
        'gains',
    },
}
GAINS = {'p', 'i', 'd', 'u_clamp_max', 'u_clamp_min'}
READ = {'position', 'velocity', 'effort'}
"""All that the hardware component reads of a JointState."""


def control_tag(cylinder: str = 'cylinder_2', namespace: str = 'rig') -> ElementTree.Element:
    text = controlled_description(load_configuration(cylinder), namespace)
    (tag,) = ElementTree.fromstring(text).findall('ros2_control')
    return tag


def interfaces(kind: str) -> set[str]:
    """Return 'piston/velocity' ... of all command or state interfaces."""
    return {
        f'{joint.get("name")}/{interface.get("name")}'
        for joint in control_tag().findall('joint')
        for interface in joint.findall(f'{kind}_interface')
    }


def parameters(controller: str) -> dict[str, object]:
    return dict(CONTROLLERS[controller]['ros__parameters'])


def types() -> dict[str, str]:
    manager = parameters('controller_manager')
    return {name: entry['type'] for name, entry in manager.items() if isinstance(entry, dict)}


@pytest.mark.parametrize('name', shipped('cylinder_*.yaml'))
def test_urdf_of_each_cylinder_is_valid_and_names_its_joint(name: str) -> None:
    text = controlled_description(load_configuration(name), 'rig')
    assert URDF.load(io.BytesIO(text.encode()), build_scene_graph=True).validate()
    names = [entry.get('name') for entry in control_tag(name).findall('joint')]
    assert names == [
        PISTON
    ]  # ros2_control refuses a fixed joint; test_urdf has its kind and limits


@pytest.mark.parametrize(('namespace', 'prefix'), [('rig', '/rig'), ('/a/b/', '/a/b'), ('', '')])
def test_hardware_speaks_the_topics_of_the_rig(namespace: str, prefix: str) -> None:
    hardware = control_tag(namespace=namespace).find('hardware')
    assert hardware is not None
    plugin = hardware.findtext('plugin')
    assert plugin == 'joint_state_topic_hardware_interface/JointStateTopicSystem'
    given = {entry.get('name'): entry.text for entry in hardware.findall('param')}
    for parameter, topic in (
        ('joint_commands_topic', 'joint_commands'),
        ('joint_states_topic', 'joint_states'),
    ):
        assert given.pop(parameter) == f'{prefix}/{topic}'
        assert TOPICS[topic].type == 'sensor_msgs/msg/JointState'
    assert float(str(given.pop('trigger_joint_command_threshold'))) < 0.0
    assert not given


def test_interfaces_are_those_that_the_hardware_fills() -> None:
    tag = control_tag()
    assert tag.get('type') == 'system'
    assert not tag.findall('sensor') + tag.findall('gpio')  # they would stay NaN
    assert {name.split('/')[1] for name in interfaces('state')} <= READ
    # the hardware component compares each command with the state of the same name
    assert interfaces('command') <= interfaces('state')


def test_controllers_claim_what_the_urdf_has() -> None:
    of_type = {kind: name for name, kind in types().items()}
    assert set(of_type) == set(ALLOWED)
    assert set(types()) | {'controller_manager'} == set(CONTROLLERS)
    for kind, name in of_type.items():
        given = parameters(name)
        assert set(given) == ALLOWED[kind]
        joints = given.get('joints', given.get('dof_names'))
        command = given.get('interface_name', given.get('command_interface'))
        states = given.get('interfaces', given.get('reference_and_state_interfaces', []))
        assert joints == [PISTON]
        assert command is None or f'{PISTON}/{command}' in interfaces('command')
        assert {f'{PISTON}/{state}' for state in states} <= interfaces('state')
    gains = parameters(of_type['pid_controller/PidController'])['gains']
    assert set(gains[PISTON]) == GAINS
