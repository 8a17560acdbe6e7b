"""The model beside the rig over DDS: quiet when it is right, a warning when it is not."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.replay import ReplayNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.shadow import ShadowNode
from pneu_rig_ros.records.cdr_decoding import unpack_fluid_pressure, unpack_joint_state
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .bystander import Bystander

pytestmark = pytest.mark.live

SECONDS = 8.0
TOPICS = [
    f'{prefix}/{topic}'
    for prefix in ('predicted', 'residual')
    for topic in ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure')
]


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.mktemp('shadow') / 'bag'
    return simulate(load_configuration('cylinder_2'), 0.34, SECONDS, path)


def shadow(context, bag, **parameters):
    """Play a bag past a shadow; return its last status and all that it published."""
    watcher = Bystander(context)
    said = {topic: watcher.hear(topic) for topic in [*TOPICS, 'joint_states']}
    player = ReplayNode(context, {'bag': str(bag), 'rate': 5.0, 'delay': 0.3})
    node = ShadowNode(context, parameters)
    runner = Runner([player, node])
    heard = {topic: [] for topic in said}

    def listen() -> bool:
        for topic, subscription in said.items():
            heard[topic].extend(subscription.take_all())
        return not player.done

    runner.run(listen)
    node.update()
    listen()
    status = node.status()
    runner.close()
    watcher.destroy_node()
    return status, heard


def test_the_true_model_predicts_and_leaves_noise(context, bag):
    status, heard = shadow(context, bag)
    assert status.level == DiagnosticStatus.OK, status
    assert status.values['model'] == 'cylinder_2'
    measured = {r.stamp_ns: r for r in map(unpack_joint_state, heard['joint_states'])}
    predicted = list(map(unpack_joint_state, heard['predicted/joint_states']))
    left = list(map(unpack_joint_state, heard['residual/joint_states']))
    assert len(predicted) == len(left) > 0.97 * len(measured)
    for model, rest in zip(predicted, left, strict=True):
        assert rest.stamp_ns == model.stamp_ns
        assert measured[model.stamp_ns].position - model.position == rest.position
    assert max(abs(model.effort) for model in predicted) > 5.0
    assert np.median(np.abs([rest.position for rest in left])) < 1e-4
    for chamber in (1, 2):
        off = map(unpack_fluid_pressure, heard[f'residual/chamber_{chamber}/pressure'])
        assert np.median(np.abs([reading.pressure for reading in off])) < 300.0


def test_a_wrong_model_raises_a_diagnostic(context, bag, tmp_path):
    model = tmp_path / 'weak.yaml'
    text = load_configuration('cylinder_2').to_yaml()
    before = 'breakaway_force: 22.0 N'
    assert before in text
    # breaks away early, and so rests elsewhere
    model.write_text(text.replace(before, 'breakaway_force: 10.0 N'))
    status, _ = shadow(context, bag, model=str(model))
    assert status.level == DiagnosticStatus.WARN
    assert 'position' in status.message
    assert 'outside the noise band' in status.message


def test_conditions_are_those_of_the_rig_whatever_the_model_says(context, bag, tmp_path):
    model = tmp_path / 'elsewhere.yaml'
    model.write_text(
        load_configuration('cylinder_2', supply_pressure=5e5, load_mass=3.0).to_yaml()
    )
    status, _ = shadow(context, bag, model=str(model))
    assert status.level == DiagnosticStatus.OK, status


def test_the_command_drives_the_model_as_the_voltages_do(context, bag):
    status, heard = shadow(context, bag, input='u')
    assert status.level == DiagnosticStatus.OK, status
    assert len(heard['predicted/joint_states']) > 0.97 * SECONDS / 1.16e-3


def test_predictions_are_recorded_beside_the_measured(context, bag, tmp_path):
    from rosbags.rosbag2 import Reader

    path = tmp_path / 'with_shadow'
    nodes = [
        ReplayNode(context, {'bag': str(bag), 'rate': 5.0, 'delay': 0.3}),
        ShadowNode(context, {}),
        RecorderNode(context, {'output': str(path)}),
    ]
    runner = Runner(nodes)
    runner.run(lambda: nodes[0].elapsed < 1.0)
    runner.close()
    with Reader(path) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
    assert all(counts[f'/{topic}'] > 500 for topic in TOPICS)
