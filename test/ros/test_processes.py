"""The nodes as the user starts them: processes, signals, exit codes."""

import itertools
import resource
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import Reader
from std_srvs.srv import SetBool

from pneu_rig_ros.nodes import OWNER
from pneu_rig_ros.nodes.embedding import hold_command
from pneu_rig_ros.nodes.topics import PolledSubscription
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.bag import open_bag
from pneu_rig_ros.records.cdr_decoding import unpack_stamp
from pneu_rig_ros.records.cdr_encoding import template
from pneu_rig_ros.records.topics import DIAGNOSTICS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .bystander import Bystander, until

pytestmark = pytest.mark.live

INTERVAL = 1_160_000

SIDE_NODES = ('excitation', 'joint_command', 'position_controller', 'shadow', 'replay')
NODES = ('plant', 'valve_command', 'friction_estimator', 'recorder', 'rig', *SIDE_NODES)
PARAMETERS = {
    'recorder': ['output:={}'],
    'rig': ['recorder:output:={}'],
    'replay': ['bag:={}', 'repeat:=true'],
}

CONTROLLER = Path(__file__).resolve().parents[2] / 'examples' / 'own_controller.py'

FILE_LIMIT = 300_000
"""Largest file of a process, which stands for a full disk [byte]."""


@pytest.fixture
def start() -> Iterator:
    """Start nodes as processes; those still running at the end are killed."""
    processes: list[subprocess.Popen] = []

    def run(
        node: str,
        *parameters: str,
        namespace: str = '',
        file: Path | None = None,
        log_level: str = '',
        limit: int = resource.RLIM_INFINITY,
    ) -> subprocess.Popen:
        arguments = [part for parameter in parameters for part in ('-p', parameter)]
        arguments += ['-r', f'__ns:=/{namespace}'] if namespace else []
        arguments += ['--params-file', str(file)] if file else []
        arguments += ['--log-level', log_level] if log_level else []
        command = [sys.executable, '-m', f'pneu_rig_ros.nodes.{node}', '--ros-args', *arguments]
        processes.append(
            subprocess.Popen(
                command,
                stderr=subprocess.PIPE,
                text=True,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
            )
        )
        return processes[-1]

    yield run
    for process in processes:
        process.kill()
        process.communicate()


def stop(process: subprocess.Popen, number: int = signal.SIGINT) -> str:
    """Send a signal, twice as an impatient user does; return what the process had to say."""
    process.send_signal(number)
    process.send_signal(number)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 0, errors
    assert 'Traceback' not in errors
    return errors


def contents(bag: Path) -> tuple[Counter, list[int]]:
    counts: Counter = Counter()
    stamps = []
    with Reader(bag) as reader:
        for connection, _, cdr in reader.messages():
            counts[connection.topic] += 1
            if connection.topic == '/joint_states':
                stamps.append(unpack_stamp(bytes(cdr)))
    return counts, stamps


def test_lock_step_of_the_page_goes_on_when_all_are_there(start, bystander):
    plant = start('plant', 'use_sim_time:=true', 'speed:=0.0', 'paused:=true')
    valves = start('valve_command', 'use_sim_time:=true', 'command_timeout:=0.0')
    controller = subprocess.Popen([sys.executable, str(CONTROLLER)])
    try:
        samples = bystander.hear('joint_states')
        found = (
            ('u', 'valve_voltages'),
            (bystander.count_publishers, bystander.count_subscribers),
        )
        until(lambda: all(count(topic) for topic, count in itertools.product(*found)))
        until(lambda: bystander.count_subscribers('joint_states') == 2)  # this node and another
        time.sleep(2.0)  # they find each other as this node finds them
        assert samples.take() is None
        bystander.call(None, SetBool, '/plant/pause', data=False)
        heard: list[int] = []
        until(lambda: heard.extend(map(unpack_stamp, samples.take_all())) or len(heard) > 500)
        assert heard == list(range(0, len(heard) * INTERVAL, INTERVAL))
    finally:
        controller.kill()
        controller.wait()
    stop(plant)
    stop(valves)


def test_four_processes_lose_nothing_and_stop_cleanly(start, tmp_path, bystander):
    bag = tmp_path / 'bag'
    recorder = start('recorder', f'output:={bag}')
    estimator = start('friction_estimator', 'wait_for_subscribers:=1')
    valves = start('valve_command', 'wait_for_subscribers:=2')
    plant = start('plant', 'wait_for_subscribers:=1')
    samples = bystander.hear('joint_states')
    until(samples.take)
    heard = []
    hold_command(0.34, 1.0, heard.append)
    for process in (plant, valves, estimator):
        stop(process, signal.SIGTERM)
    assert str(bag) in stop(recorder)
    counts, stamps = contents(bag)
    assert heard[0] < 0.1
    assert heard[-1] == 1.0
    # of commands that wait the newest is answered, and u = 0 may come before the first one
    assert 2 <= counts['/valve_voltages'] <= counts['/u'] + 1
    sampled = ('/position', '/velocity', '/chamber_1/pressure', '/chamber_2/pressure')
    assert {counts[topic] for topic in sampled} == {len(stamps)}
    assert {b - a for a, b in itertools.pairwise(stamps)} == {INTERVAL}


def test_recorder_without_space_says_so_until_it_ends_with_code_2(start, tmp_path, bystander):
    bag = tmp_path / 'bag'
    recorder = start('recorder', f'output:={bag}', limit=FILE_LIMIT)
    diagnostics, samples = bystander.hear(DIAGNOSTICS), bystander.speak('joint_states')
    message, states = template('friction'), []

    def failed_for_seconds() -> bool:
        for k in range(10):  # what is written at a time is a fraction of the limit
            samples(message.at(k, 0.0))
        time.sleep(0.02)
        for cdr in diagnostics.take_all():
            (status,) = deserialize_message(cdr, DiagnosticArray).status
            values = {item.key: item.value for item in status.values}
            states.append((status.level, values['recording'], status.message))
        return len([level for level, *_ in states if level == DiagnosticStatus.ERROR]) >= 2

    until(failed_for_seconds)
    recorder.send_signal(signal.SIGINT)
    _, errors = recorder.communicate(timeout=30)
    assert recorder.returncode == 2
    assert states[0][:2] == (DiagnosticStatus.OK, 'True')
    assert states[-1][:2] == (DiagnosticStatus.ERROR, 'False')
    failure = f'cannot write the bag {bag}: File too large; recording has ended'
    assert failure in states[-1][2]
    said = [line for line in errors.splitlines() if failure in line]
    assert len(said) == 2  # then, and at the end
    assert 'Traceback' not in errors
    with open_bag(bag) as reader:
        assert len(list(reader.messages())) > 100


def each_with_one_signal() -> Iterator:
    """Yield nodes with a signal: in short one of the two for each, in turn."""
    signals = itertools.cycle([signal.SIGINT, signal.SIGTERM])
    for node, usual in zip(NODES, signals, strict=False):
        for number in (signal.SIGINT, signal.SIGTERM):
            marks = [] if number == usual else [pytest.mark.long]
            yield pytest.param(node, number, marks=marks)


@pytest.mark.parametrize(('node', 'number'), list(each_with_one_signal()))
def test_two_signals_end_a_node_cleanly(node, number, start, tmp_path, bystander):
    bag = tmp_path / 'bag'
    if node == 'replay':
        simulate(load_configuration('cylinder_2'), 0.34, 1.0, bag)
    process = start(node, *(word.format(bag) for word in PARAMETERS.get(node, [])))
    until(bystander.hear(DIAGNOSTICS).take)
    lines = stop(process, number).splitlines()
    assert all(str(bag) in line for line in lines), lines  # where it records
    assert bool(lines) == (node in ('recorder', 'rig'))


def test_log_level_of_ros_holds(start, tmp_path, bystander):
    """Without one a recorder says where it records, as the test above has it."""
    bag = tmp_path / 'bag'
    diagnostics = bystander.hear(DIAGNOSTICS)
    recorder = start('recorder', f'output:={bag}', log_level='recorder:=warn')
    until(diagnostics.take)
    assert str(bag) not in stop(recorder)


def half_a_second(samples: PolledSubscription) -> Callable[[], bool]:
    """Return a check that so many samples were heard; on a busy machine it takes longer."""
    heard: list[bytes] = []

    def enough() -> bool:
        heard.extend(samples.take_all())
        return len(heard) > 0.5e9 / INTERVAL

    return enough


def test_two_rigs_in_two_namespaces_keep_apart(start, tmp_path, context):
    rigs = {'left': 'cylinder_1', 'right': 'cylinder_3'}
    processes, bags = [], {}
    for name, cylinder in rigs.items():
        bags[name] = tmp_path / name
        file = tmp_path / f'{name}.yaml'
        given = {'recorder': {'output': str(bags[name])}, 'plant': {'cylinder': cylinder}}
        file.write_text(
            yaml.safe_dump({f'/**/{node}': {'ros__parameters': p} for node, p in given.items()})
        )
        processes.append(start('rig', namespace=name, file=file))
    for name in rigs:
        watcher = Bystander(context, namespace=f'/{name}')
        until(half_a_second(watcher.hear('joint_states')))
        watcher.destroy_node()
    hold_command(0.4, 0.5, namespace='left')
    for process in processes:
        stop(process)
    for name, cylinder in rigs.items():
        record = read_recording(bags[name])
        assert record.configuration is not None
        assert record.configuration.name == cylinder
        assert bool(record.counts.get('u')) == (name == 'left')
        assert record.missing['joint_states'].size == 0
        assert record.counts['joint_states'] > 0.5e9 / INTERVAL
        assert record.counts['friction'] == record.counts['joint_states'] - 50


@pytest.mark.parametrize(
    ('node', 'parameter', 'told'),
    [
        ('plant', 'cylinder:=cylinder_9', 'cylinder_9'),
        ('recorder', 'output:=/proc/none', '/proc/none'),
        pytest.param('plant', 'load_mass:=heavy', 'load_mass', marks=pytest.mark.long),
        pytest.param(
            'plant', 'interval_ns:=1', 'interval_ns: 1 ns is not within', marks=pytest.mark.long
        ),
        pytest.param(
            'valve_command',
            'trigger:=never',
            "'never', allowed command, sample",
            marks=pytest.mark.long,
        ),
        pytest.param('friction_estimator', 'load_mass:=-1.0', 'load_mass', marks=pytest.mark.long),
    ],
)
def test_a_wrong_parameter_is_one_line_and_exit_code_2(start, node, parameter, told):
    refused(start(node, parameter), told)


def test_a_wrong_log_level_is_one_line_and_exit_code_2(start):
    refused(start('valve_command', log_level='loud'), 'loud')


def refused(process, told):
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 2
    lines = [line for line in errors.splitlines() if line.startswith('Error: ')]
    assert len(lines) == 1
    assert told in lines[0]
    assert 'Traceback' not in errors


IN_A_CALLBACK = """
import ctypes, signal, sys
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.rig_node import RigNode

class Compiling(RigNode):
    NAME = 'compiling'

    def __init__(self, context):
        super().__init__(context)
        signal.raise_signal(signal.{signal}) if {outside} else None
        ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.{signal}))()

    def update(self):
        raise AssertionError('the node should have ended')

sys.exit(runner.main([Compiling]))
"""


@pytest.mark.parametrize(
    ('name', 'outside'),
    [
        ('SIGINT', True),
        ('SIGTERM', False),
        pytest.param('SIGINT', False, marks=pytest.mark.long),
        pytest.param('SIGTERM', True, marks=pytest.mark.long),
    ],
)
def test_signal_while_a_node_loads_ends_it_without_a_word(name: str, outside: bool) -> None:
    """A callback of the compiler swallows the exception that a signal raises in it."""
    code = IN_A_CALLBACK.format(signal=name, outside=outside)
    done = subprocess.run(
        [sys.executable, '-c', code],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


@pytest.mark.parametrize('code', [0, 2])
def test_process_whose_nodes_cannot_be_destroyed_ends_with_its_code(code: int) -> None:
    """Fast DDS may hang at that, and rclpy holds the interpreter lock meanwhile."""
    hang = f"""
import ctypes
from pneu_rig_ros.nodes.runner import exit_after
exit_after(1, {code})
ctypes.PyDLL(None).sleep(60)
"""
    done = subprocess.run([sys.executable, '-c', hang], timeout=30)
    assert done.returncode == code


SCRIPT = 'from pneu_rig_ros.nodes.{} import main; raise SystemExit(main())'


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('by', ['script', 'module'])
@pytest.mark.parametrize('node', ['plant', 'recorder'])
def test_signal_while_a_node_imports_ends_it_without_a_word(
    node: str, by: str, number: int, tmp_path: Path
) -> None:
    script = tmp_path / node  # as pip and colcon write them
    script.write_text(SCRIPT.format(node))
    words = [str(script)] if by == 'script' else ['-m', f'pneu_rig_ros.nodes.{node}']
    process = subprocess.Popen(
        [sys.executable, '-X', 'importtime', *words],  # a line for each module
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    while not (line := process.stderr.readline()).endswith(' numpy\n'):
        assert line, 'ended before the signal'
    process.send_signal(number)
    _, rest = process.communicate(timeout=30)
    assert process.returncode == 0, rest
    assert [line for line in rest.splitlines() if not line.startswith('import time:')] == []
    assert f'pneu_rig_ros.nodes.{node}\n' not in rest  # it was not complete


@pytest.mark.parametrize('name', ['SIGINT', 'SIGTERM'])
def test_other_program_that_imports_the_nodes_keeps_its_handlers(name: str) -> None:
    code = f"""
import signal
before = signal.getsignal(signal.{name})
import pneu_rig_ros.nodes.plant
assert signal.getsignal(signal.{name}) is before
"""
    subprocess.run([sys.executable, '-c', code], timeout=60, check=True)


def test_node_ends_with_the_process_that_owns_it(start, monkeypatch, bystander):
    monkeypatch.setenv(OWNER, '1')  # not this process, as if the owner had been killed
    plant = start('plant')
    _, errors = plant.communicate(timeout=30)
    assert plant.returncode == 0, errors
    assert errors == ''
