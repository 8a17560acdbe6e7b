"""Two nodes of one name, also on a computer too busy for prompt discovery."""

import os
import signal
import subprocess
import sys
import time

import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import duplicate_names
from pneu_rig_ros.nodes.duplicate_names import hold_name
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.runner import Runner

from .bystander import DOMAIN, until

HOLD = """
import sys, time
from pneu_rig_ros.nodes.duplicate_names import hold_name
held = hold_name(sys.argv[1])
print(held is not None, flush=True)
time.sleep(60)
"""


@pytest.fixture
def holder():
    """Return a process that holds the name of a plant of these tests and publishes nothing."""
    command = [sys.executable, '-c', HOLD, f'{DOMAIN}:/plant']
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == 'True\n'
        yield process
        process.kill()


@pytest.fixture
def runner(context):
    made = Runner([PlantNode(context, {})])
    yield made
    made.destroy()


def test_a_name_is_held_once_and_free_when_its_process_is_killed(holder) -> None:
    name = f'{DOMAIN}:/plant'
    assert hold_name(name) is None
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    with hold_name(name):
        assert hold_name(name) is None
    assert hold_name(name) is not None


def test_a_duplicate_on_this_computer_is_waited_for_though_it_publishes_late(
    holder, runner, monkeypatch
) -> None:
    late = time.monotonic() + duplicate_names.TIMEOUT_IN_GRAPH + 0.5

    def deaf_at_first() -> list[str]:
        return ['/plant'] if time.monotonic() > late else []

    monkeypatch.setattr(runner.duplicates, 'update', deaf_at_first)
    with pytest.raises(RigError, match='another /plant is running'):
        runner.duplicates.check(lambda: True)


def test_a_duplicate_that_died_is_not_waited_for(holder, runner) -> None:
    os.kill(holder.pid, signal.SIGKILL)
    until(lambda: holder.poll() is not None)
    start = time.monotonic()
    runner.duplicates.check(lambda: True)
    assert time.monotonic() - start < duplicate_names.TIMEOUT_ON_HOST


def test_the_check_for_duplicates_can_be_stopped(holder, runner) -> None:
    end = time.monotonic() + duplicate_names.TIMEOUT + 0.5
    runner.duplicates.check(lambda: time.monotonic() < end)
    assert time.monotonic() < end + 5.0


@pytest.mark.live
def test_of_two_that_start_at_the_same_moment_one_ends() -> None:
    command = [sys.executable, '-m', 'pneu_rig_ros.nodes.plant']
    with (
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as one,
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as other,
    ):
        both = one, other
        try:
            until(lambda: any(process.poll() is not None for process in both))
            time.sleep(2.0)  # the other could end too
            (ended,) = (process for process in both if process.poll() is not None)
            assert ended.returncode == 2
            assert 'another /plant is running' in ended.stderr.read()
        finally:
            for process in both:
                process.kill()
