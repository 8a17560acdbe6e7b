"""A bag played over DDS, by the node and by the command: what is sent, when, and its use."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rclpy.duration import Duration
from std_srvs.srv import SetBool

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.cli import main
from pneu_rig_ros.cli.run import replay
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.replay import ReplayNode
from pneu_rig_ros.nodes.rig_node import COMMON
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.cdr_decoding import unpack_stamp
from pneu_rig_ros.records.playback import Playback
from pneu_rig_ros.records.topics import CLOCK
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .bystander import Bystander, until

pytestmark = pytest.mark.live

FAST = {'rate': 10.0, 'delay': 0.0}


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('replay') / 'bag'
    return simulate(load_configuration('cylinder_1'), 0.3, 4.0, path)


def play(runner: Runner) -> None:
    runner.run(lambda: not runner.nodes[0].done)


def test_what_is_played_is_what_was_recorded(bag, context, bystander, loop_of):
    with Playback(bag) as playback:
        recorded = list(playback.messages())
        heard = {topic: bystander.hear(topic) for topic in playback.topics}
    node = ReplayNode(context, {'bag': str(bag), 'wait_for_subscribers': 1, **FAST})
    play(loop_of(node))
    for publisher in node.publishers:
        publisher.wait_for_all_acked(Duration(seconds=1.0))
    for topic, subscription in heard.items():
        assert list(subscription.take_all()) == [m.cdr for m in recorded if m.topic == topic], (
            topic
        )


def test_friction_of_a_replayed_bag_is_that_of_the_bag(bag, context, tmp_path):
    again = tmp_path / 'again'
    runner = Runner(
        [
            ReplayNode(context, {'bag': str(bag), **FAST}),
            FrictionEstimatorNode(context, {}),
            RecorderNode(context, {'output': str(again)}),
        ]
    )
    play(runner)
    runner.close()
    live, offline = read_recording(again), read_recording(bag)
    assert np.array_equal(live.position, offline.position)
    assert np.array_equal(live.friction, offline.friction, equal_nan=True)
    known = np.isfinite(live.friction)
    assert known.sum() == live.position.size - 50
    # the causal filter is cut off where 0.3 % of its area is left
    difference = live.friction[known] - friction_of(offline)[known]
    assert np.sqrt(np.mean(difference**2)) < 0.05


@pytest.mark.parametrize('rate', [1.0, 4.0])
def test_rate_is_played_over_recorded_time(bag, context, loop_of, rate):
    node = ReplayNode(context, {'bag': str(bag), 'rate': rate, 'delay': 0.0})
    runner = loop_of(node)
    start = time.monotonic()
    runner.run(lambda: node.elapsed < 0.5 * rate)
    elapsed = time.monotonic() - start
    assert elapsed == pytest.approx(0.5, rel=0.3)


def test_clock_runs_with_the_samples_and_pause_stops_them(bag, context, bystander, loop_of):
    clock, samples = bystander.hear(CLOCK), bystander.hear('joint_states')
    node = ReplayNode(context, {'bag': str(bag), 'clock': True, 'delay': 0.2})
    runner = loop_of(node)
    runner.run(lambda: node.elapsed < 0.2)
    answer = bystander.call(runner, SetBool, '/replay/pause', data=True)
    assert answer.message == 'paused'
    stamps = [unpack_stamp(cdr) for cdr in samples.take_all()]
    assert [unpack_stamp(cdr) for cdr in clock.take_all()] == stamps
    for _ in range(30):
        runner.spin_once()
    assert samples.take() is None
    before = node.elapsed
    bystander.call(runner, SetBool, '/replay/pause', data=False)
    runner.run(lambda: node.elapsed < before + 0.1)
    assert unpack_stamp(samples.take()) > stamps[-1]


def test_repeat_begins_anew(bag, context, bystander, loop_of):
    node = ReplayNode(
        context, {'bag': str(bag), 'repeat': True, 'topics': 'u, valve_voltages', **FAST}
    )
    runner, commands = loop_of(node), bystander.hear('u')
    heard: list[bytes] = []
    runner.run(lambda: (heard.extend(commands.take_all()), len(heard) < 3)[1])
    assert not node.done


@pytest.mark.parametrize(
    ('parameters', 'message'),
    [
        ({}, 'bag is empty'),
        ({'bag': '/none'}, '/none does not exist'),
        ({'rate': 0.0}, 'rate'),
        ({'topics': 'speed'}, 'speed is not a topic of a rig'),
    ],
)
def test_a_wrong_start_is_refused_in_one_line(context, bag, parameters, message):
    given = {'bag': str(bag), **parameters} if parameters else {}
    with pytest.raises(RigError) as caught:
        ReplayNode(context, given)
    assert message in str(caught.value)
    assert '\n' not in str(caught.value)


def test_command_plays_into_a_namespace_and_ends_with_the_bag(bag, context):
    watcher = Bystander(context, namespace='/left')
    samples, elsewhere = watcher.hear('joint_states'), Bystander(context).hear('joint_states')
    command = [sys.executable, '-m', 'pneu_rig_ros.cli', 'replay', str(bag)]
    chosen = ['--topic', 'joint_states', '--subscribers', '1']
    process = subprocess.Popen(
        [*command, '--namespace', 'left', *chosen, '--rate', '4'],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    stamps: list[int] = []

    def ended() -> bool:
        over = process.poll() is not None
        stamps.extend(map(unpack_stamp, samples.take_all()))
        return over

    until(ended)
    printed, errors = process.communicate()
    assert process.returncode == 0, errors
    assert stamps == [k * 1_160_000 for k in range(3449)]
    assert elsewhere.take() is None
    assert '4.00 s' in printed
    assert 'Traceback' not in errors
    watcher.destroy_node()


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['--rate', '0'], 'rate'),
        (['--topic', 'speed'], 'speed is not a topic'),
        (['--namespace', 'a b'], "namespace 'a b'"),
    ],
)
def test_what_is_wrong_in_the_command_is_reported_in_one_line(bag, capfd, arguments, message):
    assert main(['replay', str(bag), *arguments]) == 2
    lines = [line for line in capfd.readouterr().err.splitlines() if 'error' in line]
    assert len(lines) == 1
    assert message in lines[0]


@pytest.mark.parametrize(
    ('option', 'parameter'),
    [('rate', 'rate'), ('delay', 'delay'), ('subscribers', 'wait_for_subscribers')],
)
def test_options_have_the_ranges_of_the_node(option, parameter):
    allowed = next(one.type for one in replay.params if one.name == option)
    table = (*ReplayNode.PARAMETERS, *COMMON)
    (declared,) = (one for one in table if one.name == parameter)
    assert (allowed.min, allowed.max) == (declared.low, declared.high)
