"""The demonstration, live: four processes, all of the record, a clean end whatever happens."""

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from terminal import Terminal

from pneu_rig_ros.demo import held_signals
from pneu_rig_ros.records import read_recording

from .test_commands import until

pytestmark = pytest.mark.live


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)


def children(process: subprocess.Popen[str]) -> Iterator[tuple[str, int]]:
    """Yield name and process number of the nodes that a demonstration has started."""
    for task in Path(f'/proc/{process.pid}/task').iterdir():
        for number in map(int, (task / 'children').read_text().split()):
            words = Path(f'/proc/{number}/cmdline').read_text().split('\0')
            yield next(w.rpartition('.')[2] for w in words if 'pneu_rig_ros.nodes.' in w), number


def recording(bag: Path, size: int = 50_000) -> bool:
    file = bag / f'{bag.name}.mcap'
    return file.exists() and file.stat().st_size > size


def gone(numbers: list[int]) -> bool:
    return not any(Path(f'/proc/{number}').exists() for number in numbers)


def test_stroke_is_recorded_from_the_first_to_the_last_sample(terminal: Terminal) -> None:
    arguments = ('--duration', 2.5, '--seed', 9, '--supply-pressure', 6e5, '--out', 'a stroke: 1')
    with terminal.start('demo', *arguments) as process:
        out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    bag = terminal.directory / 'a stroke: 1'
    for line in (
        'rate  ',
        'jitter  ',
        'lost samples',
        'stick-slip cycles',
        'peak friction',
        'bag                a stroke: 1\n',
        'picture            a stroke: 1/stroke.png\n',
    ):
        assert line in out
    assert 20_000 < (bag / 'stroke.png').stat().st_size < 200_000
    data = json.loads(terminal.output('info', bag, '--json'))
    assert set(data['lost'].values()) == {0}
    assert data['seed'] == '9'
    assert data['peak_friction'] > 15.0
    record = read_recording(bag)
    # without a loss; how fast samples arrive depends on what else runs: see make bench
    assert record.duration > 2.5
    assert record.configuration is not None
    assert record.configuration.model.operation.supply_pressure == 6e5
    # The stroke lies within the record: u is 0 before and after it.
    assert record.voltage_1[0] == record.voltage_1[-1] < record.voltage_1.max()


def test_interrupted_demonstration_closes_the_bag(terminal: Terminal) -> None:
    with terminal.start('demo', '--duration', 600, '--out', 'bag') as process:
        until(lambda: recording(terminal.directory / 'bag'), process)
        numbers = [number for _, number in children(process)]
        os.kill(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert 'recorded up to here: bag' in err
    assert 'Traceback' not in err
    assert len(numbers) == 4
    assert gone(numbers)
    assert read_recording(terminal.directory / 'bag').position.size > 50


@pytest.mark.parametrize(
    'victim', [pytest.param('friction_estimator', marks=pytest.mark.long), 'recorder']
)
def test_dead_node_is_named_and_the_bag_is_whole(terminal: Terminal, victim: str) -> None:
    with terminal.start('demo', '--duration', 600, '--out', 'bag') as process:
        until(lambda: recording(terminal.directory / 'bag', 200_000), process)  # samples, too
        nodes = dict(children(process))
        os.kill(nodes[victim], signal.SIGKILL)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 2
    last = err.splitlines()[-1]
    assert last == f'pneu-rig: error: the node {victim} has stopped: it was killed by SIGKILL'
    assert gone(list(nodes.values()))
    assert read_recording(terminal.directory / 'bag').position.size > 50


def test_impossible_domain_is_told_before_anything_starts(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', '9999')
    with terminal.start('demo', '--out', 'bag') as process:
        _, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert 'ROS_DOMAIN_ID=9999: must be a whole number from 0 to 232' in err
    assert not (terminal.directory / 'bag').exists()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signal_that_comes_where_exceptions_are_lost_is_kept(number: int) -> None:
    class Swallowing:
        def __del__(self) -> None:
            os.kill(os.getpid(), number)

    before = signal.getsignal(number)
    with held_signals() as received:
        Swallowing()
    assert received == [number]
    assert signal.getsignal(number) is before
