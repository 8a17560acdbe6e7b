"""Parameters of the nodes: described, in config/nodes.yaml with their defaults, checked."""

from pathlib import Path

import pytest
import yaml

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.joint_command import JointCommandNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.position_controller import PositionControllerNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.rig import NODES
from pneu_rig_ros.nodes.shadow import ShadowNode

pytestmark = pytest.mark.live

FILE = Path(__file__).resolve().parents[2] / 'config' / 'nodes.yaml'
OF_CYLINDER = {'supply_pressure', 'load_mass', 'initial_position', 'rest_time'}


KINDS = (*NODES, ExcitationNode, JointCommandNode, PositionControllerNode, ShadowNode)


def node_of(kind, context, output):
    return kind(context, {'output': str(output)} if kind is RecorderNode else {})


def names(node):
    return {name for name in node._parameters if not name.startswith(('start_type', 'qos_'))}


@pytest.mark.parametrize('kind', KINDS)
def test_every_parameter_is_described_with_unit_and_range(kind, context, tmp_path, loop_of):
    node = node_of(kind, context, tmp_path / 'bag')
    loop_of(node)
    ours = names(node) - {'use_sim_time'}
    assert {'realtime_priority', 'wait_for_subscribers'} <= ours
    for name in ours:
        descriptor, value = node.describe_parameter(name), node.get_parameter(name).value
        assert len(descriptor.description) > 10, name
        if isinstance(value, float | int) and not isinstance(value, bool):
            assert descriptor.description.endswith(']'), name
            assert descriptor.floating_point_range or descriptor.integer_range, name


@pytest.mark.parametrize('kind', KINDS)
def test_file_gives_every_parameter_its_default(kind, context, new_context, tmp_path):
    plain = node_of(kind, context, tmp_path / 'a')
    loaded = node_of(kind, new_context('--params-file', str(FILE)), tmp_path / 'b')
    written = yaml.safe_load(FILE.read_text())[f'/**/{plain.get_name()}']['ros__parameters']
    own = names(plain)
    missing = own - set(written)
    assert missing <= (OF_CYLINDER if plain.get_name() == 'plant' else set())
    assert set(written) <= own
    for name in own - {'output'}:
        assert loaded.get_parameter(name).value == plain.get_parameter(name).value, name
        if name in written:
            assert written[name] == plain.get_parameter(name).value, name
    for node in (plain, loaded):
        node.close()
        node.destroy_node()


@pytest.mark.parametrize(
    ('kind', 'parameters', 'message'),
    [
        (PlantNode, {'speed': 2.0}, 'speed 2 needs simulated time'),
        (PlantNode, {'speed': 1e-6, 'use_sim_time': True}, 'allowed 0'),
        (PlantNode, {'cylinder': 'cylinder_9'}, 'cylinder_9'),
        (PlantNode, {'friction': 'none'}, 'none'),
        (PlantNode, {'sensors': 'broken'}, 'broken'),
        (PlantNode, {'load_mass': -1.0}, 'load_mass'),
        (PlantNode, {'load_mass': 3}, 'load_mass'),
        (PlantNode, {'supply_pressure': float('nan')}, 'supply_pressure'),
        (PlantNode, {'initial_position': 9.0}, 'initial_position'),
        (PositionControllerNode, {'profile': 'step'}, 'drives u, allowed is one that drives'),
        (PositionControllerNode, {'law': 'fuzzy'}, 'allowed pid, sliding_mode'),
        (PositionControllerNode, {'proportional_gain': -1.0}, 'proportional_gain'),
        (ExcitationNode, {'profile': 'stairs'}, 'staircase'),
    ],
)
def test_a_wrong_start_is_refused_in_one_line(kind, context, parameters, message):
    with pytest.raises(RigError) as caught:
        kind(context, parameters)
    assert message in str(caught.value)
    assert '\n' not in str(caught.value)
