"""Eq. 1 over DDS, and what happens to commands that are none, late or missing."""

import math
import time

import pytest

from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records.cdr_decoding import unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import pack_float64, template
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .bystander import gather, until

pytestmark = pytest.mark.live

AT_REST = valve_voltages(0.0)


@pytest.fixture
def start(context, loop_of):
    """Start the node with parameters; return its runner."""
    return lambda **parameters: loop_of(ValveCommandNode(context, parameters))


def answers(runner, voltages, count):
    return [unpack_valve_voltages(message) for message in gather(runner, [voltages], count)[0]]


@pytest.mark.parametrize('wrong', [math.nan, math.inf, -math.inf, 1e308, -1000.1])
def test_each_command_is_answered_and_a_wrong_one_leaves_the_last(start, bystander, wrong):
    runner = start(command_timeout=0.0, wait_for_subscribers=1)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    commands = [0.34, -0.34, 0.0, 1000.0, wrong, b'', 1.0]
    taken = runner.nodes[0]._command_rate
    for number, u in enumerate(commands, 1):
        say(u if isinstance(u, bytes) else pack_float64(u))
        until(lambda n=number: runner.spin_once() or taken.count == n)
        if u not in (wrong, b''):
            assert answers(runner, voltages, 1) == [valve_voltages(u)]
    assert runner.nodes[0].refused == 2
    assert voltages.take() is None


def test_in_simulated_time_a_wrong_command_is_answered_with_the_last(start, bystander):
    """Lock step would wait for ever."""
    runner = start(use_sim_time=True, command_timeout=0.0)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    until(lambda: runner.nodes[0].count_subscribers('valve_voltages'))
    expected = valve_voltages(0.0)
    for u in (math.nan, 0.34, math.inf, b''):
        say(u if isinstance(u, bytes) else pack_float64(u))
        if u == 0.34:
            expected = valve_voltages(u)
        assert answers(runner, voltages, 1) == [expected]
    assert runner.nodes[0].refused == 3


def test_of_commands_that_wait_the_newest_is_answered(start, bystander):
    runner = start(command_timeout=0.0, wait_for_subscribers=1)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    until(lambda: runner.nodes[0].ready())
    for u in (0.1, 0.2, math.nan, 0.3, math.nan):
        say(pack_float64(u))
    subscription = runner.nodes[0].polled_subscriptions[0]
    arrived = []
    until(lambda: arrived.extend(subscription.take_all()) or len(arrived) == 5)
    subscription.take_all = lambda: [arrived.pop(0) for _ in list(arrived)]
    runner.spin_once()
    assert answers(runner, voltages, 1) == [valve_voltages(0.3)]
    assert voltages.take() is None


def test_without_a_first_command_u_is_set_to_zero_once(start, bystander):
    runner = start(command_timeout=0.2)
    voltages = bystander.hear('valve_voltages')
    until(lambda: runner.nodes[0].count_subscribers('valve_voltages'))
    assert answers(runner, voltages, 1) == [AT_REST]
    for _ in range(100):
        runner.spin_once()
    assert voltages.take() is None


def test_u_falls_to_zero_once_when_no_command_comes(start, bystander):
    runner = start(command_timeout=0.2)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    until(lambda: runner.nodes[0].count_subscribers('valve_voltages'))
    begin = time.monotonic()
    say(pack_float64(0.34))
    assert answers(runner, voltages, 2) == [valve_voltages(0.34), AT_REST]
    assert time.monotonic() - begin > 0.2
    for _ in range(100):
        runner.spin_once()
    assert voltages.take() is None


def test_a_wrong_command_does_not_count_as_one(start, bystander):
    runner = start(command_timeout=0.2)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    say(pack_float64(0.34))
    heard = []

    def fallen():
        say(pack_float64(math.nan))
        runner.spin_once()
        heard.extend(unpack_valve_voltages(message) for message in voltages.take_all())
        return AT_REST in heard

    until(fallen)


def test_triggered_by_samples_it_answers_each_from_the_first_command_on(start, bystander):
    runner = start(trigger='sample', command_timeout=0.05, wait_for_subscribers=1)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    sample, message = bystander.speak('joint_states'), template('friction')
    for index in range(10):
        sample(message.at(index * 10_000_000, 0.0))
    for _ in range(20):
        runner.spin_once()
    assert voltages.take() is None
    say(pack_float64(0.34))
    # Samples every 10 ms of simulated time: the command is 50 ms old at the sixth sample.
    expected = [valve_voltages(0.34)] * 6 + [AT_REST] * 4
    assert answers(runner, voltages, 10) == expected


def test_command_is_timed_out_by_samples_whose_stamps_jump_back(start, bystander):
    """As when a simulation is restarted after 10 s, and whatever sent the command has ended."""
    runner = start(trigger='sample', command_timeout=0.05, wait_for_subscribers=1)
    voltages, say = bystander.hear('valve_voltages'), bystander.speak('u')
    sample, message = bystander.speak('joint_states'), template('friction')
    taken = runner.nodes[0]._command_rate
    say(pack_float64(0.34))
    until(lambda: runner.spin_once() or taken.count == 1)
    sample(message.at(10_000_000_000, 0.0))
    assert answers(runner, voltages, 1) == [AT_REST]
    say(pack_float64(0.34))
    until(lambda: runner.spin_once() or taken.count == 2)
    for index in range(10):
        sample(message.at(index * 10_000_000, 0.0))
    expected = [valve_voltages(0.34)] * 6 + [AT_REST] * 4
    assert answers(runner, voltages, 10) == expected
