"""The plant over DDS: exact stamps, simulated time, services, parameters."""

import itertools
import time

import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.records.cdr_decoding import (
    unpack_float64,
    unpack_fluid_pressure,
    unpack_joint_state,
    unpack_stamp,
    unpack_string,
)
from pneu_rig_ros.records.cdr_encoding import pack_valve_voltages
from pneu_rig_ros.records.topics import CLOCK
from pneu_rig_ros.rig import configuration_from_yaml

from .bystander import Bystander, gather, until

pytestmark = pytest.mark.live

INTERVAL = 1_160_000
SIMULATED = {'use_sim_time': True, 'speed': 20.0}
SUBSCRIBED = {'wait_for_subscribers': 1}


@pytest.fixture
def start(context, loop_of):
    """Start a plant with parameters; return its runner."""
    return lambda **parameters: loop_of(PlantNode(context, parameters))


def stamps(messages: list[bytes]) -> list[int]:
    return [unpack_stamp(message) for message in messages]


def test_stamps_are_exact_multiples_of_the_interval_from_the_start(start, bystander):
    subscriptions = [bystander.hear(t) for t in ('joint_states', 'chamber_1/pressure', 'position')]
    before = time.time_ns()
    runner = start()
    joints, pressures, positions = gather(runner, subscriptions, 200)
    assert before < stamps(joints)[0] < time.time_ns()
    assert {b - a for a, b in itertools.pairwise(stamps(joints))} == {INTERVAL}
    common = set(stamps(joints)) & set(stamps(pressures))
    assert len(common) > 100
    assert len(positions) == 200


def test_all_topics_of_a_sample_agree(start, bystander):
    topics = ('joint_states', 'position', 'velocity', 'chamber_1/pressure', 'chamber_2/pressure')
    subscriptions = [bystander.hear(topic) for topic in (*topics, CLOCK)]
    heard = gather(start(**SIMULATED, **SUBSCRIBED), subscriptions, 100)
    for index, (joint, x, v, p1, p2, clock) in enumerate(zip(*heard, strict=True)):
        reading = unpack_joint_state(joint)
        assert reading[:3] == (index * INTERVAL, unpack_float64(x), unpack_float64(v))
        assert {unpack_stamp(p1), unpack_stamp(p2), unpack_stamp(clock)} == {index * INTERVAL}
        assert 9e4 < unpack_fluid_pressure(p1).pressure < 1.1e6
        assert unpack_fluid_pressure(p2).variance > 0


@pytest.mark.parametrize(('speed', 'expected'), [(4.0, 4.0), (0.5, 0.5)])
def test_speed_is_simulated_over_real_time(start, bystander, speed, expected):
    runner = start(use_sim_time=True, speed=speed)
    samples = [bystander.hear('joint_states')]
    gather(runner, samples, 1)
    begin = time.monotonic()
    count = round(400 * speed)
    gather(runner, samples, count)
    elapsed = time.monotonic() - begin
    # Wide, as a busy machine delays and catches up; a speed that is not obeyed is further off.
    assert count * INTERVAL * 1e-9 / elapsed == pytest.approx(expected, rel=0.4)


def test_voltages_move_the_piston_and_junk_is_refused(start, bystander):
    runner = start(initial_position=0.0, **SIMULATED)
    say = bystander.speak('valve_voltages')
    position = bystander.hear('position')
    for junk in (b'\x00\x01\x00\x00', pack_valve_voltages(float('nan'), 0.0)):
        say(junk)
    at_rest = gather(runner, [position], 200)[0]
    say(pack_valve_voltages(3.5, 1.5))
    moved = gather(runner, [position], 2000)[0]
    assert unpack_float64(at_rest[-1]) < 1e-3
    assert unpack_float64(moved[-1]) > 0.01


def test_two_rigs_in_two_namespaces(new_context, loop_of):
    runners = {}
    for name in ('rig_a', 'rig_b'):
        context = new_context('-r', f'__ns:=/{name}')
        seed = 1 if name == 'rig_a' else 2
        runners[name] = loop_of(PlantNode(context, {'seed': seed}))
    heard = {}
    for name, runner in runners.items():
        watcher = Bystander(new_context(), namespace=f'/{name}')
        heard[name] = gather(runner, [watcher.hear('chamber_1/pressure')], 50)
        assert watcher.count_publishers('/joint_states') == 0
        watcher.destroy_node()
    assert heard['rig_a'] != heard['rig_b']


def test_reset_goes_back_to_the_initial_state_while_time_goes_on(start, bystander):
    runner = start(**SIMULATED, sensors='ideal')
    say = bystander.speak('valve_voltages')
    joints = bystander.hear('joint_states')
    say(pack_valve_voltages(3.5, 1.5))
    moved = gather(runner, [joints], 1500)[0]
    assert unpack_joint_state(moved[-1]).position > 1e-3
    assert bystander.call(runner, Trigger, '/plant/reset').success
    after = gather(runner, [joints], 200)[0]
    positions = [unpack_joint_state(message).position for message in after]
    drop = next(i for i, (a, b) in enumerate(itertools.pairwise(positions)) if b < a - 1e-4)
    assert positions[drop + 1] == unpack_joint_state(moved[0]).position
    everything = stamps(moved) + stamps(after)
    later = [stamp for stamp in everything if stamp >= stamps(after)[0]]
    assert {b - a for a, b in itertools.pairwise(later)} == {INTERVAL}


@pytest.mark.parametrize('simulated', [True, False])
def test_pause_stops_simulated_time_and_leaves_a_hole_in_real_time(start, bystander, simulated):
    runner = start(**(SIMULATED if simulated else {}))
    joints = bystander.hear('joint_states')
    gather(runner, [joints], 50)
    answer = bystander.call(runner, SetBool, '/plant/pause', data=True)
    assert (answer.success, answer.message) == (True, 'paused')
    before = stamps(list(joints.take_all()))
    for _ in range(50):
        runner.spin_once()
    assert list(joints.take_all()) == []
    bystander.call(runner, SetBool, '/plant/pause', data=False)
    after = stamps(gather(runner, [joints], 50)[0])
    hole = after[0] - before[-1]
    assert hole % INTERVAL == 0
    assert (hole == INTERVAL) == simulated
    assert {b - a for a, b in itertools.pairwise(after)} == {INTERVAL}


def test_set_up_is_validated_and_described_anew_at_run_time(start, bystander):
    runner = start(**SIMULATED)
    descriptions = bystander.hear('rig_description')
    until(lambda: (runner.spin_once(), descriptions.take())[1])

    def change(name, value):
        changes = [Parameter(name, value=value).to_parameter_msg()]
        service = '/plant/set_parameters'
        return bystander.call(runner, SetParameters, service, parameters=changes).results[0]

    assert change('supply_pressure', 5e5).successful
    described = configuration_from_yaml(unpack_string(next(descriptions.take_all())), 'test')
    assert described.model.operation.supply_pressure == 5e5
    for name, value in [
        ('supply_pressure', -1.0),
        ('load_mass', float('nan')),
        ('load_mass', float('inf')),
        ('initial_position', 0.1),
        ('seed', 3),
        ('supply_pressure', 'high'),
    ]:
        result = change(name, value)
        assert not result.successful
        assert result.reason
    assert list(descriptions.take_all()) == []
