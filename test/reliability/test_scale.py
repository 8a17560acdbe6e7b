"""Work shared out: same bits on any number of workers, a killed one, a cluster, an interrupt."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest
from distributed import Client
from long import tasks
from terminal import Terminal

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks, open_executor

COMMAND = [sys.executable, '-m', 'pneu_rig_ros.cli', 'sweep', '--cylinder', 'cylinder_1']
PATIENCE = 60.0  # s
WORKED = 1.5  # s of processor time: a worker has done more than to start


@pytest.fixture(scope='module')
def processes() -> Iterator[Executor]:
    """Return two processes that tasks are shared out to."""
    with open_executor(2) as two:
        yield two


def test_results_come_in_the_order_of_the_tasks_with_what_they_share(processes: Executor) -> None:
    told: list[int] = []
    powers = map_tasks(processes, pow, range(200), 3, progress=told.append)
    assert powers == [number**3 for number in range(200)]
    assert told == list(range(1, 201))
    assert map_tasks(processes, pow, []) == []


def test_error_of_a_task_is_raised_as_it_is_here(processes: Executor) -> None:
    for place in (processes, SerialExecutor()):
        with pytest.raises(ValueError, match="could not convert string to float: 'x'"):
            map_tasks(place, float, ['1', 'x', '2'])


def test_killed_worker_costs_no_more_than_was_under_way(
    processes: Executor, tmp_path: Path
) -> None:
    """And its results are the same bits as those of this process."""
    journal, fatal, count = tmp_path / 'journal', 3, 6
    results = map_tasks(processes, tasks.strokes_with_a_kill, range(count), journal, fatal)
    assert results == map_tasks(SerialExecutor(), tasks.strokes, range(count))
    assert len(set(map(str, results))) > count // 2
    begun = journal.read_text().split()
    again = {number for number in begun if begun.count(number) > 1}
    assert str(fatal) in again
    assert len(again) <= 2  # a task for each of two processes
    assert len(begun) == count + len(again)


def test_a_task_that_ends_its_workers_is_told(processes: Executor) -> None:
    with pytest.raises(RigError, match='enough memory'):
        map_tasks(processes, os._exit, [1])
    assert map_tasks(processes, abs, range(3)) == [0, 1, 2]


def free_port() -> int:
    """Return a port that nothing listens at."""
    with socket.socket() as place:
        place.bind(('127.0.0.1', 0))
        return int(place.getsockname()[1])


@contextmanager
def dask(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program of Dask meanwhile."""
    command = [sys.executable, '-m', 'dask', *arguments]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def await_connection(port: int) -> None:
    """Wait until something listens at a port of this host."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        with socket.socket() as place:
            if place.connect_ex(('127.0.0.1', port)) == 0:
                return
        time.sleep(0.1)
    raise AssertionError(f'nothing listens at {port}')


def test_sweep_on_a_cluster_gives_the_table_of_this_process(
    tmp_path: Path, terminal: Terminal
) -> None:
    port = free_port()
    address = f'tcp://127.0.0.1:{port}'
    own = ['--host', '127.0.0.1', '--no-dashboard']
    arguments = ['sweep', '--u', '0.4,0.6', '--longest', '5', '--json']
    with dask('scheduler', *own, '--port', str(port)):
        await_connection(port)
        line = terminal.refusal(*arguments, '--scheduler', address)
        assert line == f'--scheduler {address}: it has no workers'
        worker = ['--nthreads', '1', '--local-directory', str(tmp_path)]
        with dask('worker', address, *own, *worker):
            await_worker(address)
            shared = terminal.run(*arguments, '--scheduler', address)
    alone = terminal.run(*arguments)
    assert shared == alone
    assert alone.code == 0
    assert len(json.loads(alone.out)['strokes']) == 2


def await_worker(address: str) -> None:
    """Wait until a cluster has a worker."""
    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(1, timeout=PATIENCE)


def test_wrong_address_is_refused_in_one_line_also_where_something_else_listens(
    terminal: Terminal,
) -> None:
    with socket.socket() as mute:
        mute.bind(('127.0.0.1', 0))
        mute.listen()
        for address in ('nowhere', f'tcp://127.0.0.1:{mute.getsockname()[1]}'):
            line = terminal.refusal('sweep', '--scheduler', address)
            assert line.startswith(f'--scheduler {address}: no Dask')


@pytest.mark.parametrize('when', [pytest.param('starting', marks=pytest.mark.long), 'working'])
def test_interrupt_leaves_no_worker_behind(when: str, tmp_path: Path) -> None:
    out = tmp_path / 'table.csv'
    process = subprocess.Popen(
        [*COMMAND, '--u', '0.3:0.5:5000', '--workers', '2', '--out', str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | {'TMPDIR': str(tmp_path)},
    )
    family = await_workers(process.pid, busy=when == 'working')
    os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C in a terminal does
    printed, told = process.communicate(timeout=PATIENCE)
    assert (process.returncode, printed, told.strip()) == (130, '', 'pneu-rig: interrupted')
    _, alive = psutil.wait_procs(family, timeout=PATIENCE)
    assert alive == []
    assert list(tmp_path.iterdir()) == []


def await_workers(pid: int, busy: bool) -> list[psutil.Process]:
    """Wait for two workers, and if wanted until they have worked; return all children."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        children = psutil.Process(pid).children(recursive=True)
        if sum(is_worker(one, busy) for one in children) >= 2:
            return children
        time.sleep(0.05)
    raise AssertionError('no workers came')


def is_worker(process: psutil.Process, busy: bool) -> bool:
    """Tell a worker, busy if wanted, from the short commands that libraries run and forget."""
    try:
        if 'spawn_main' not in ' '.join(process.cmdline()):
            return False
        return not busy or process.cpu_times().user > WORKED
    except psutil.NoSuchProcess:  # ended since it was listed, reaped or not yet
        return False
