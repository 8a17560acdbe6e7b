"""`pneu-rig replay` as its user runs it."""

import os
import subprocess
import sys

import pytest

from pneu_rig_ros.cli import main
from pneu_rig_ros.cli.run import replay
from pneu_rig_ros.nodes.replay import ReplayNode
from pneu_rig_ros.nodes.rig_node import COMMON
from pneu_rig_ros.records.cdr_decoding import unpack_stamp
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .bystander import Bystander, until

pytestmark = pytest.mark.live


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.mktemp('replay') / 'bag'
    return simulate(load_configuration('cylinder_1'), 0.3, 1.0, path)


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
        env=dict(os.environ),
    )
    stamps: list[int] = []

    def ended() -> bool:
        over = process.poll() is not None
        stamps.extend(map(unpack_stamp, samples.take_all()))
        return over

    until(ended)
    told, errors = process.communicate()
    assert process.returncode == 0, errors
    assert stamps == [k * 1_160_000 for k in range(863)]
    assert elsewhere.take() is None
    assert '1.00 s' in told
    assert 'Traceback' not in errors
    watcher.destroy_node()


@pytest.mark.parametrize(
    ('arguments', 'told'),
    [
        (['--rate', '0'], 'rate'),
        (['--topic', 'speed'], 'speed is not a topic'),
        (['--namespace', 'a b'], "namespace 'a b'"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(bag, capfd, arguments, told):
    assert main(['replay', str(bag), *arguments]) == 2
    lines = [line for line in capfd.readouterr().err.splitlines() if 'error' in line]
    assert len(lines) == 1
    assert told in lines[0]


@pytest.mark.parametrize(
    ('option', 'parameter'),
    [('rate', 'rate'), ('delay', 'delay'), ('subscribers', 'wait_for_subscribers')],
)
def test_options_have_the_ranges_of_the_node(option, parameter):
    allowed = next(one.type for one in replay.params if one.name == option)
    table = (*ReplayNode.PARAMETERS, *COMMON)
    (declared,) = (one for one in table if one.name == parameter)
    assert (allowed.min, allowed.max) == (declared.low, declared.high)
