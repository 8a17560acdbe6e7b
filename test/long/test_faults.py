"""What a live rig does when it is killed, stopped, flooded, starved or started twice."""

from __future__ import annotations

import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import psutil
import pytest
import rclpy
from std_msgs.msg import Float64, String

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.qos import qos_profile
from pneu_rig_ros.nodes.topics import create_publisher
from pneu_rig_ros.records import Recording, read_recording, repair
from pneu_rig_ros.records.bag import open_bag, storage_files
from pneu_rig_ros.records.cdr_decoding import unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.records.topics import DIAGNOSTICS, TOPICS
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .live_rig import ORDER, ProcessRig, until
from .witness import ERROR, WARN, WATCHED, U, Witness, missing

pytestmark = [pytest.mark.long, pytest.mark.live, pytest.mark.usefixtures('apart')]

KILLS = 20
"""Of each node, unless `--kills` is given."""
SECOND_NS = 1_000_000_000
LONGEST_WAY = 20.0
"""On a busy machine, of a message that the witness has, to the recorder [s]."""
PAUSE = 2.0
"""Longest time without a sample in which the rig is said to go on [s]."""
DISK_SIZE = 1_500_000
"""[byte]: three seconds of the rig."""
ANSWERS = {
    'plant': 'joint_states',
    'valve_command': 'valve_voltages',
    'friction_estimator': 'friction',
}
"""By which a node shows that it is back."""
PUBLISHED = {f'/{topic}' for topic in WATCHED if topic != DIAGNOSTICS}


@pytest.fixture
def kills(request: pytest.FixtureRequest) -> int:
    """Return how often each node is killed."""
    return int(request.config.getoption('kills') or KILLS)


def recorded(rig: ProcessRig, witness: Witness) -> Recording:
    """Return the record of the newest bag, once it holds what came up to now."""
    bag, now = rig.newest_bag(), time.time_ns()

    def there() -> bool:
        try:
            with open_bag(bag) as reader:
                return int(reader.end_time) > now
        except RigError:  # a busy machine may stop the recorder within a chunk for seconds
            return False

    witness.until(there, f'{bag} is written')
    return read_recording(bag)


def missing_samples(record: Recording) -> int:
    """Count the missing stamps of each topic between its first and its last one."""
    count = 0
    for stamps in record.missing.values():
        present = np.setdiff1d(record.stamps, stamps, assume_unique=True)
        count += int(((stamps > present[0]) & (stamps < present[-1])).sum())
    return count


def begun(rig: ProcessRig, before: Path | None = None) -> bool:
    """Return whether a bag, not the one before, has messages of all topics of the rig."""
    newest = rig.newest_bag()
    if newest == before or not storage_files(newest):
        return False
    with open_bag(newest) as reader:
        return {c.topic for c in reader.connections if c.msgcount} >= PUBLISHED


@pytest.mark.parametrize('name', ANSWERS)
def test_killed_node_is_started_anew_and_nothing_else_is_lost(
    name: str, rig: ProcessRig, witness: Witness, kills: int
) -> None:
    chance, deaths, back = random.Random(kills), [], []
    witness.until(partial(begun, rig), 'a bag with all topics')
    witness.received.clear()
    for _ in range(kills):
        witness.listen(chance.uniform(0.3, 1.5))
        os.kill(rig.nodes[name].process.pid, signal.SIGKILL)
        deaths.append(time.time_ns())
        witness.until(rig.nodes[name].revive, f'{name} can be restarted')
        witness.listen(0.1)  # for what it had sent before
        witness.hears(ANSWERS[name])
        back.append(1e-9 * (time.time_ns() - deaths[-1]))
    end, patience = time.time_ns(), time.monotonic() + LONGEST_WAY
    lost = {'all': 1}
    while lost and time.monotonic() < patience:  # it may be under way to the recorder
        witness.listen(1.0)
        lost = missing(witness.received, rig.newest_bag(), end, deaths)
    count = sum(map(len, witness.received.values()))
    print(f'\n{name} killed {kills} times: back after {max(back):.1f} s, {count} messages')
    assert lost == {}
    recorded(rig, witness)


def test_killed_recorder_has_written_all_but_the_last_second(
    rig: ProcessRig, witness: Witness, kills: int
) -> None:
    chance, count = random.Random(kills), 0
    for _ in range(kills):
        witness.until(partial(begun, rig), 'a bag with all topics')
        bag, recorder = rig.newest_bag(), rig.nodes['recorder']
        witness.received.clear()
        witness.listen(chance.uniform(1.5, 3.0))
        os.kill(recorder.process.pid, signal.SIGKILL)
        until_ns = time.time_ns() - SECOND_NS
        witness.until(recorder.revive, 'the recorder can be restarted')
        repair(bag)
        assert missing(witness.received, bag, until_ns) == {}
        count += sum(m.time_ns <= until_ns for ms in witness.received.values() for m in ms)
        witness.until(partial(begun, rig, bag), f'a bag after {bag}')
    print(f'\nrecorder killed {kills} times: {count} messages proven')
    assert count > 0


def test_late_listeners_and_recorders_get_the_descriptions(
    rig: ProcessRig, witness: Witness
) -> None:
    latched = [name for name, topic in TOPICS.items() if topic.transient_local]
    with Witness(commands=False, topics=latched) as late:
        late.until(lambda: all(late.received[name] for name in latched), 'descriptions')
    os.kill(rig.nodes['recorder'].process.pid, signal.SIGKILL)
    witness.until(rig.nodes['recorder'].revive, 'the recorder can be restarted')
    witness.until(partial(begun, rig, rig.bag), 'a second bag')
    assert read_recording(rig.newest_bag()).configuration is not None


def test_processes_that_stand_still_get_everything_afterwards(
    rig: ProcessRig, witness: Witness
) -> None:
    numbers = [rig.nodes[name].process.pid for name in ORDER[1:]]
    for number in numbers:
        os.kill(number, signal.SIGSTOP)
    witness.listen(3.0)
    for number in numbers:
        os.kill(number, signal.SIGCONT)
    witness.hears('friction')
    witness.listen(2.0)
    assert int(witness.said['recorder'].values['lost']) == 0
    assert missing_samples(recorded(rig, witness)) == 0


def test_wrong_quality_of_service_is_told_while_it_is_there(
    rig: ProcessRig, witness: Witness
) -> None:
    kept = qos_profile(TOPICS['rig_description'])
    publisher = witness.node.create_publisher(String, 'rig_description', 1)  # not kept
    subscription = witness.node.create_subscription(Float64, 'position', lambda _: None, kept)
    concerned = 'friction_estimator', 'recorder', 'plant'
    for node in concerned:
        witness.reports(node, WARN, 'incompatible QoS')
    witness.node.destroy_publisher(publisher)
    witness.node.destroy_subscription(subscription)
    witness.until(
        lambda: not any('incompatible QoS' in witness.said[node].message for node in concerned),
        'the warning ends',
    )
    rig.check()


def test_second_rig_of_the_same_names_gives_way(
    rig: ProcessRig, witness: Witness, tmp_path: Path
) -> None:
    with ProcessRig(tmp_path / 'second') as second:
        witness.until(
            lambda: all(n.process.poll() is not None for n in second.nodes.values()),
            'the second ends',
        )
        assert {node.process.poll() for node in second.nodes.values()} == {2}
        assert len(second.errors('plant')) == 1
    assert not (tmp_path / 'second').exists()
    rig.check()
    witness.listen(1.0)
    # a sample of another rig between the others would be refused
    assert missing_samples(recorded(rig, witness)) == 0


def test_of_two_publishers_the_newest_command_counts(rig: ProcessRig, witness: Witness) -> None:
    other_u, other, due = -0.5, create_publisher(witness.node, 'u'), 0.0
    witness.until(lambda: other.get_subscription_count() >= 2, 'subscribers of u')
    witness.received.clear()

    def followed(since_ns: int = 0) -> set[tuple[float, float]]:
        voltages = witness.received['valve_voltages']
        return {unpack_valve_voltages(m.cdr) for m in voltages if m.time_ns > since_ns}

    def own(voltages: tuple[float, float]) -> bool:
        return any(math.dist(voltages, valve_voltages(u)) < 0.01 for u in (U, -U))

    def both() -> bool:
        nonlocal due
        if time.monotonic() > due:
            due = time.monotonic() + 0.05
            other.publish(pack_float64(other_u))
        return valve_voltages(other_u) in followed() and any(map(own, followed()))

    def alone() -> bool:
        recent = followed(time.time_ns() - SECOND_NS // 2)
        return bool(recent) and all(map(own, recent))

    witness.until(both, 'both are followed')
    witness.until(
        lambda: both() and 'several publishers' in witness.said['valve_command'].message, 'told'
    )
    witness.node.destroy_publisher(other)
    witness.until(alone, 'the first alone is followed')


def publish_commands(rate: float, seconds: float) -> None:
    """Flood `u` in lumps of one millisecond."""
    rclpy.init()
    node = rclpy.create_node('flooder')
    publisher, message = node.create_publisher(Float64, 'u', 10), pack_float64(U)
    while publisher.get_subscription_count() < 2:
        time.sleep(0.01)
    start, sent = time.monotonic(), 0
    while (elapsed := time.monotonic() - start) < seconds:
        for _ in range(int(elapsed * rate) - sent):
            publisher.publish(message)
            sent += 1
        time.sleep(0.001)
    rclpy.shutdown()


def test_flood_of_commands_costs_no_sample(rig: ProcessRig, witness: Witness) -> None:
    arrived, answered = 0.0, 0.0
    witness.silent = True
    flooder = get_context('spawn').Process(target=publish_commands, args=(20e3, 3.0))
    flooder.start()
    try:
        witness.reports('valve_command', WARN, 'times a second')
        while flooder.is_alive():
            witness.turn()
            values = witness.said['valve_command'].values
            arrived = max(arrived, float(values['commands [Hz]']))
            answered = max(answered, float(values['rate [Hz]']))
    finally:
        flooder.kill()
    witness.silent = False
    witness.listen(2.5)
    print(f'\n{arrived:.0f} commands/s arrived, {answered:.0f}/s answered')
    assert answered <= 2100
    assert int(witness.said['recorder'].values['lost']) == 0
    assert missing_samples(recorded(rig, witness)) == 0


def test_removed_bag_is_told_and_the_rig_goes_on(rig: ProcessRig, witness: Witness) -> None:
    shutil.rmtree(rig.bag)
    witness.listen(1.0)
    assert witness.hears('joint_states') < PAUSE
    rig.nodes['recorder'].stop()
    assert rig.nodes['recorder'].process.poll() == 2
    assert len(rig.errors('recorder')) == 1


def test_full_disk_ends_the_recording_and_keeps_it(tmp_path: Path) -> None:
    disk, kept = tmp_path / 'disk', tmp_path / 'kept'
    disk.mkdir()
    mount = ['mount', '-t', 'tmpfs', '-o', f'size={DISK_SIZE}', 'pneu_rig', str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip('here no small disk can be mounted')
    try:
        with ProcessRig(disk / 'bag') as rig, Witness() as witness:
            witness.reports('recorder', ERROR, 'No space left on device')
            assert witness.hears('joint_states') < PAUSE
            (line,) = [one for one in rig.log('recorder').splitlines() if 'No space' in one]
            full_ns = round(float(line.split('[')[2].split(']')[0]) * 1e9)
            rig.nodes['recorder'].stop()
            assert rig.nodes['recorder'].process.poll() == 2
        shutil.copytree(disk / 'bag', kept)
    finally:
        subprocess.run(['umount', str(disk)], check=True)
    (kept / 'bag.mcap').rename(kept / 'kept.mcap')
    repair(kept)
    assert missing(witness.received, kept, full_ns - SECOND_NS) == {}
    assert read_recording(kept).duration > 1.0


@pytest.mark.parametrize('bag', ['/proc/none/bag', 'file/bag'])
def test_folder_that_cannot_be_written_is_told_at_the_start(bag: str, tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    with ProcessRig(tmp_path / bag, only=('recorder',)) as rig:
        recorder = rig.nodes['recorder'].process
        until(lambda: recorder.poll() is not None, 'the recorder ends')
        assert recorder.returncode == 2
        assert len(rig.errors('recorder')) == 1


def test_nodes_end_with_a_killed_demonstration(tmp_path: Path) -> None:
    file = tmp_path / 'bag' / 'bag.mcap'
    command = [sys.executable, '-m', 'pneu_rig_ros.cli', 'demo', '--duration', '600']
    with subprocess.Popen(
        [*command, '--out', str(file.parent)], stderr=subprocess.DEVNULL
    ) as demo:
        until(lambda: file.exists() and file.stat().st_size > 300_000, 'it records')
        nodes = psutil.Process(demo.pid).children(recursive=True)
        demo.kill()
        demo.wait()
        until(lambda: not any(map(psutil.Process.is_running, nodes)), 'its nodes end')
    assert len(nodes) >= 4
    assert (file.parent / 'metadata.yaml').exists()
    assert read_recording(file.parent).missing['joint_states'].size == 0


def test_live_page_starts_a_killed_plant_anew() -> None:
    command = [sys.executable, '-m', 'pneu_rig_ros.cli', 'live', '--start', 'cylinder_2']
    with (
        subprocess.Popen(
            [*command, '--port', '0'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as live,
        Witness() as witness,
    ):
        witness.hears('friction')
        children = psutil.Process(live.pid).children(recursive=True)
        (plant,) = [p for p in children if 'pneu_rig_ros.nodes.plant' in p.cmdline()]
        plant.kill()
        witness.listen(0.3)
        witness.hears('joint_states')
        witness.hears('friction')
        live.send_signal(signal.SIGINT)
        _, errors = live.communicate(timeout=60)
    assert errors.count('is restarted') == 1
    assert live.returncode == 0


def test_wall_clock_that_is_set_leaves_stamps_and_log_times_even(tmp_path: Path) -> None:
    compiler, library, clock = shutil.which('cc'), tmp_path / 'clock.so', tmp_path / 'clock'
    if compiler is None:
        pytest.skip('the clock of a process cannot be set without a C compiler, cc')
    source = Path(__file__).with_name('wall_clock.c')
    subprocess.run([compiler, '-shared', '-fPIC', '-o', library, source, '-ldl'], check=True)
    clock.write_text('+0')
    faked = {'LD_PRELOAD': str(library), 'WALL_CLOCK_FILE': str(clock)}
    environment = dict.fromkeys(('plant', 'recorder'), faked)
    with ProcessRig(tmp_path / 'bag', environment=environment) as rig, Witness() as witness:
        witness.hears('friction')
        for jump in ('+3600', '-3600'):
            (tmp_path / 'new').write_text(jump)
            (tmp_path / 'new').replace(clock)
            for node in ('plant', 'recorder'):
                witness.reports(node, WARN, f'set by {jump}.')
            rig.check()
        witness.listen(1.0)
    record = read_recording(tmp_path / 'bag')
    assert {b - a for a, b in pairwise(record.stamps.tolist())} == {record.interval_ns}
    assert missing_samples(record) == 0
    assert float(np.ptp(record.arrival_ns - record.stamps)) < SECOND_NS


@pytest.mark.parametrize('arguments', [['pneu_rig_ros.nodes.plant'], ['pneu_rig_ros.cli', 'demo']])
def test_middleware_that_is_not_installed_is_told(arguments: list[str], tmp_path: Path) -> None:
    asked = {**os.environ, 'RMW_IMPLEMENTATION': 'rmw_nowhere_cpp'}
    command = [sys.executable, '-m', *arguments]
    done = subprocess.run(
        command, env=asked, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
