"""Controllers over DDS, in lock step with the plant at 862 Hz of simulated time."""

import itertools
import time

import numpy as np
import pytest
from tracking import tracking

from pneu_rig_ros.control.controller import (
    NONE,
    Compensation,
    Pid,
    PositionController,
)
from pneu_rig_ros.control.excitation import load_excitation
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.position_controller import PositionControllerNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.cdr_decoding import unpack_float64, unpack_joint_state
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .bystander import Bystander, gather

pytestmark = pytest.mark.live

INTERVAL = 1_160_000
PLANT = {'use_sim_time': True, 'speed': 0.0, 'cylinder': 'cylinder_1'}
STEP = """
drives: reference
shape: step
before: 0.02 m
after: 0.1 m
delay: 0.3 s
hold: 10.0 s
"""


@pytest.fixture
def step(tmp_path):
    path = tmp_path / 'step.yaml'
    path.write_text(STEP)
    return path


def lock_step(context, *others) -> Runner:
    """Return a loop of plant, controller and valve command, in the order of their messages."""
    plant = PlantNode(context, {**PLANT, 'initial_position': 0.02})
    valves = ValveCommandNode(context, {'use_sim_time': True, 'command_timeout': 0.0})
    return Runner([plant, *others, valves])


def control(context, bystander: Bystander, step, seconds: float, **parameters):
    """Return times [s], references, positions and commands of a run in closed loop."""
    given = {'use_sim_time': True, 'profile': str(step), **parameters}
    runner = lock_step(context, PositionControllerNode(context, given))
    subscriptions = [bystander.hear(topic) for topic in ('joint_states', 'reference', 'u')]
    heard = gather(runner, subscriptions, round(seconds * 1e9 / INTERVAL))
    runner.close()
    joints = [unpack_joint_state(cdr) for cdr in heard[0]]
    numbers = [[unpack_float64(cdr) for cdr in messages] for messages in heard[1:]]
    times = np.array([joint.stamp_ns for joint in joints]) * 1e-9
    return times, *map(np.array, (numbers[0], [joint.position for joint in joints], numbers[1]))


def test_every_message_of_the_loop_wakes_it(context):
    """If only the answer to the plant did, a command would wait for 20 ms."""
    runner = lock_step(context)
    late = time.monotonic() + 10.0
    while not all(node.ready() for node in runner.nodes) and time.monotonic() < late:
        time.sleep(0.01)
    awaited = [one.topic.name for one in runner.nodes[0].awaited()]
    runner.close()
    assert awaited == ['valve_voltages', 'u']


def test_a_sample_that_waits_for_the_first_command_wakes_nothing(context):
    """Else the loop would take a whole processor until there is a command."""
    valves = {'use_sim_time': True, 'trigger': 'sample'}
    runner = Runner([PlantNode(context, PLANT), ValveCommandNode(context, valves)])
    cycles, end = itertools.count(), time.monotonic() + 2.0
    runner.run(lambda: next(cycles) >= 0 and time.monotonic() < end)
    runner.close()
    assert next(cycles) < 300  # one every 20 ms, and some when the sample comes


LOW = {'proportional_gain': 60.0, 'integral_gain': 60.0, 'derivative_gain': 2.0}


@pytest.mark.parametrize(
    ('gains', 'compensation'), [({}, True), (LOW, False)], ids=['as shipped', 'bare']
)
def test_loop_over_dds_is_the_loop_without_it_to_the_last_bit(
    context, bystander, step, gains, compensation
):
    """So that limit cycles and their end are those of test/control."""
    times, reference, position, command = control(
        context, bystander, step, 2.0, compensation=compensation, **gains
    )
    excitation = load_excitation(step)
    rig = Rig(load_configuration('cylinder_1', initial_position=0.02))
    law = Pid(*gains.values())
    controller = PositionController(law, Compensation() if compensation else NONE)
    for k in range(len(times)):
        sample = rig.sample
        wanted = excitation.level(round(times[k] * 1e9) * 1e-9)
        interval = INTERVAL * 1e-9 if k else 0.0
        u = controller.update(interval, wanted, sample.position, sample.velocity)
        assert (reference[k], position[k], command[k]) == (wanted, sample.position, u), k
        rig.step(*valve_voltages(u))


def test_sliding_mode_reaches_the_reference(context, bystander, step):
    _, reference, position, _ = control(context, bystander, step, 4.0, law='sliding_mode')
    late = slice(round(3e9 / INTERVAL), None)
    figures = tracking(reference[late], position[late], INTERVAL * 1e-9)
    assert figures.max_error < 1e-3
    assert figures.slips == 0


def test_controller_listens_to_a_reference_and_holds_its_setpoint_before(context, bystander):
    node = PositionControllerNode(
        context, {'use_sim_time': True, 'setpoint': 0.03, 'law': 'sliding_mode'}
    )
    runner = lock_step(context, node)
    joints = bystander.hear('joint_states')
    say = bystander.speak('reference')
    before = gather(runner, [joints], 1500)[0]
    say(pack_float64(float('nan')))
    say(pack_float64(0.06))
    after = gather(runner, [joints], 2500)[0]
    runner.close()
    assert unpack_joint_state(before[-1]).position == pytest.approx(0.03, abs=1e-3)
    assert unpack_joint_state(after[-1]).position == pytest.approx(0.06, abs=1e-3)


def test_excitation_plays_its_profile_on_the_samples_stamps(context, tmp_path):
    profile = tmp_path / 'stairs.yaml'
    profile.write_text(
        '{drives: u, shape: staircase, levels: [0.0 V, 0.4 V, -0.4 V], hold: 0.2 s}'
    )
    bag = tmp_path / 'bag'
    given = {'use_sim_time': True}
    player = ExcitationNode(context, {**given, 'profile': str(profile)})
    recorder = RecorderNode(context, {**given, 'output': str(bag)})
    runner = lock_step(context, player, recorder)
    runner.run(lambda: runner.nodes[0].rate.count < round(0.8e9 / INTERVAL))
    assert player.status().message == 'finished'
    runner.close()
    record = read_recording(bag)
    levels = np.array([0.0, 0.4, -0.4, 0.0])
    time = record.time[:-1]
    u = levels[np.minimum((time / 0.2 + 1e-9).astype(int), 3)]
    expected = np.array([valve_voltages(value) for value in u])
    # a sample's answer belongs to the interval after it, so each one is known exactly
    assert np.array_equal(record.voltage_1[:-1], expected[:, 0])
    assert np.array_equal(record.voltage_2[:-1], expected[:, 1])
