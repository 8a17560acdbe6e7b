"""config/nodes.yaml against the nodes: every parameter named, every value the default."""

from pathlib import Path

import pytest
import yaml

from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.joint_command import JointCommandNode
from pneu_rig_ros.nodes.position_controller import PositionControllerNode
from pneu_rig_ros.nodes.rig import NODES
from pneu_rig_ros.nodes.shadow import ShadowNode

pytestmark = pytest.mark.live

FILE = Path(__file__).resolve().parents[2] / 'config' / 'nodes.yaml'
OF_CYLINDER = {'supply_pressure', 'load_mass', 'initial_position', 'rest_time'}


@pytest.mark.parametrize(
    'kind', [*NODES, ExcitationNode, JointCommandNode, PositionControllerNode, ShadowNode]
)
def test_file_gives_every_parameter_its_default(kind, context, new_context, tmp_path):
    def node_of(context, name):
        overrides = {'output': str(tmp_path / name)} if kind is NODES[-1] else {}
        return kind(context, overrides)

    plain = node_of(context, 'a')
    loaded = node_of(new_context('--params-file', str(FILE)), 'b')
    written = yaml.safe_load(FILE.read_text())[f'/**/{plain.get_name()}']['ros__parameters']
    own = {name for name in plain._parameters if not name.startswith(('start_type', 'qos_'))}
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
