"""All four nodes in lock step: the bag against the plant, the offline run and a second run."""

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.context import Context
from rosbags.rosbag2 import Reader

from pneu_rig_ros.analysis.friction import CausalFriction, ForceBalance
from pneu_rig_ros.nodes.rig import NODES
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.records.cdr_decoding import unpack_joint_state
from pneu_rig_ros.records.cdr_encoding import (
    PlantMessages,
    pack_float64,
    pack_string,
    pack_valve_voltages,
)
from pneu_rig_ros.records.description import describe
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages
from pneu_rig_ros.simulate import simulate

from .bystander import Bystander

pytestmark = pytest.mark.live

SAMPLES = 1500
U = 0.34
OVERRIDES = {'seed': 5, 'load_mass': 1.0}
INTERVAL = 1_160_000

Bag = dict[str, list[tuple[int, bytes]]]


def record(context: Context, path: Path, **plant: object) -> None:
    """Run the whole rig in lock step from one command on; record SAMPLES samples or more."""
    simulated = {'use_sim_time': True}
    parameters = [
        {'speed': 0.0, **OVERRIDES, **plant},
        {'trigger': 'sample', 'command_timeout': 0.0},
        {},
        {'output': str(path)},
    ]
    nodes = [node(context, {**simulated, **p}) for node, p in zip(NODES, parameters, strict=True)]
    runner = Runner(nodes)
    controller = Bystander(context)
    controller.speak('u', subscribers=2)(pack_float64(U))
    runner.run(lambda: nodes[0].rate.count < SAMPLES)
    runner.close()
    controller.destroy_node()


def read(path: Path) -> Bag:
    bag: Bag = defaultdict(list)
    with Reader(path) as reader:
        for connection, time, cdr in reader.messages():
            bag[connection.topic].append((time, bytes(cdr)))
    return bag


@pytest.fixture
def recorded(new_context: Callable[..., Context], tmp_path: Path) -> Path:
    path = tmp_path / 'live'
    record(new_context(), path)
    return path


def test_bag_is_complete_and_equal_to_what_the_plant_computes(recorded):
    bag = read(recorded)
    configuration = load_configuration('cylinder_2', **OVERRIDES)
    rig = Rig(configuration)
    messages = PlantMessages(rig.sensors.pressure_variance, clock=True)
    expected: Bag = defaultdict(list)
    for index in range(len(bag['/joint_states'])):
        for topic, cdr in messages.pack(rig.sample, index * INTERVAL).items():
            expected[f'/{topic.lstrip("/")}'].append((index * INTERVAL, cdr))
        rig.step(*valve_voltages(U))
    assert len(bag['/joint_states']) >= SAMPLES
    for topic, sent in expected.items():
        assert bag[topic] == sent, topic
    answers = len(bag['/valve_voltages'])
    command = pack_valve_voltages(*valve_voltages(U))
    assert bag['/valve_voltages'] == [(k * INTERVAL, command) for k in range(answers)]
    assert len(bag['/joint_states']) - 1 <= answers
    assert bag['/u'] == [(0, pack_float64(U))]
    assert bag['/rig_description'] == [(0, pack_string(describe(configuration)))]


def test_live_friction_equals_the_causal_estimate_of_the_record(recorded):
    bag = read(recorded)
    configuration = load_configuration('cylinder_2', **OVERRIDES)
    causal = CausalFriction(ForceBalance.of(configuration), INTERVAL * 1e-9)
    rig = Rig(configuration)
    expected = []
    for index in range(len(bag['/joint_states'])):
        sample = rig.sample
        force = causal.push(sample.position, sample.pressure_1, sample.pressure_2)
        if force is not None:
            expected.append(((index - causal.delay_samples) * INTERVAL, force))
        rig.step(*valve_voltages(U))
    readings = [unpack_joint_state(cdr) for _, cdr in bag['/friction']]
    assert [(reading.stamp_ns, reading.effort) for reading in readings] == expected


def test_two_runs_in_lock_step_are_identical(recorded, new_context, tmp_path):
    again = tmp_path / 'again'
    record(new_context(), again)
    first, second = read(recorded), read(again)
    for topic in TOPICS.values():
        name = f'/{topic.name.lstrip("/")}'
        if name != '/diagnostics' and not topic.extra:  # the former tells of real time
            pairs = zip(first[name], second[name], strict=False)
            assert first[name], name
            assert all(a == b for a, b in pairs), name


def test_offline_run_writes_the_same_messages(recorded, tmp_path):
    live = read(recorded)
    seconds = (SAMPLES - 1) * INTERVAL * 1e-9
    configuration = load_configuration('cylinder_2', **OVERRIDES)
    offline = read(simulate(configuration, U, seconds, tmp_path / 'offline'))
    assert len(offline['/joint_states']) == SAMPLES
    for name, messages in offline.items():
        assert live[name][: len(messages)] == messages, name


def test_other_readers_read_the_same_values(recorded):
    bag = read(recorded)
    with next(recorded.glob('*.mcap')).open('rb') as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        decoded = reader.iter_decoded_messages(topics=['/joint_states', '/valve_voltages'])
        heard = defaultdict(list)
        for _, channel, _, message in decoded:
            heard[channel.topic].append(message)
    joints = [unpack_joint_state(cdr) for _, cdr in bag['/joint_states']]
    assert [m.position[0] for m in heard['/joint_states']] == [j.position for j in joints]
    assert [m.velocity[0] for m in heard['/joint_states']] == [j.velocity for j in joints]
    assert {tuple(m.data) for m in heard['/valve_voltages']} == {valve_voltages(U)}


def test_metadata_say_what_was_recorded(recorded):
    with Reader(recorded) as reader:
        custom = reader.storage.metadata.custom
    assert custom['cylinder'] == 'cylinder_2'
    assert custom['seed'].startswith('5')
    assert custom['configuration'].endswith(
        load_configuration('cylinder_2', **OVERRIDES).to_yaml()
    )
    assert custom['git_revision']
