"""A node beside its twin, on a computer too busy for them to see each other at once."""

import os
import signal
import subprocess
import sys
import time

import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import twins
from pneu_rig_ros.nodes.host_claim import HostClaim
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.runner import Runner

from .bystander import DOMAIN, until

HOLD = """
import sys, time
from pneu_rig_ros.nodes.host_claim import HostClaim
claim = HostClaim(sys.argv[1])
print(claim.held_elsewhere(), flush=True)
time.sleep(60)
"""


@pytest.fixture
def holder():
    """Return a process that holds the place of a plant of these tests and says nothing."""
    command = [sys.executable, '-c', HOLD, f'{DOMAIN}:/plant']
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == 'False\n'
        yield process
        process.kill()


@pytest.fixture
def runner(context):
    made = Runner([PlantNode(context, {})])
    yield made
    made.withdraw()


def test_a_name_is_held_once_and_free_when_its_process_is_killed(holder) -> None:
    claim = HostClaim(f'{DOMAIN}:/plant')
    assert claim.held_elsewhere()
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert not claim.held_elsewhere()
    assert not claim.held_elsewhere()  # it is this one's
    assert HostClaim(f'{DOMAIN}:/plant').held_elsewhere()
    claim.release()
    assert not HostClaim(f'{DOMAIN}:/plant').held_elsewhere()


def test_a_twin_on_this_computer_is_waited_for_though_it_speaks_late(
    holder, runner, monkeypatch
) -> None:
    late = time.monotonic() + twins.HEARING + 0.5
    listen = runner.twins.listen

    def deaf_at_first() -> None:
        listen()
        runner.nodes[0].has_twin = time.monotonic() > late

    monkeypatch.setattr(runner.twins, 'listen', deaf_at_first)
    with pytest.raises(RigError, match='another /plant is running'):
        runner.twins.give_way(lambda: True)


def test_a_twin_that_died_is_not_waited_for(holder, runner) -> None:
    os.kill(holder.pid, signal.SIGKILL)
    until(lambda: holder.poll() is not None)
    start = time.monotonic()
    runner.twins.give_way(lambda: True)
    assert time.monotonic() - start < twins.HEARING_HERE


def test_whoever_waits_for_a_twin_can_be_stopped(holder, runner) -> None:
    end = time.monotonic() + twins.FIRST_SIGHT + 0.5
    runner.twins.give_way(lambda: time.monotonic() < end)
    assert time.monotonic() < end + 5.0


@pytest.mark.live
def test_of_two_that_start_at_the_same_moment_one_gives_way() -> None:
    command = [sys.executable, '-m', 'pneu_rig_ros.nodes.plant']
    with (
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as one,
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as other,
    ):
        both = one, other
        try:
            until(lambda: any(process.poll() is not None for process in both))
            time.sleep(2.0)  # the other could give way too
            (ended,) = (process for process in both if process.poll() is not None)
            assert ended.returncode == 2
            assert 'another /plant is running' in ended.stderr.read()
        finally:
            for process in both:
                process.kill()
