"""Speed-up by a second processor, beside what the machine gives; cost of a task on Dask."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Iterator

import numba
import numpy as np
import pytest
from distributed import LocalCluster

from pneu_rig_ros.batch import run_parallel
from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks, open_executor
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .tasks import count, strokes

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif((os.cpu_count() or 1) < 2, reason='needs two processors'),
]

PAIRS = 7
"""Of measurements with one processor and with two, of which the median counts."""
LEAST_SHARE = 0.75
"""Wanted speed-up, as a share of that of two processes that only count [-]."""
SAMPLES, PLANTS = 8000, 64
TASKS = 60
EMPTY_TASKS = 1000


@pytest.fixture(scope='module')
def two() -> Iterator[Executor]:
    """Return two processes."""
    with open_executor(2) as processes:
        yield processes


def seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def check_speed_up(work: Callable[[int], object], two: Executor, what: str) -> None:
    """Compare the time of work(1) with that of work(2) on two processors."""
    work(2)
    ratios, machine = [], []
    for _ in range(PAIRS):
        ratios.append(seconds(lambda: work(1)) / seconds(lambda: work(2)))
        machine.append(sum(map_tasks(two, count, [0.5, 0.5])) / count(0.5))
    speed_up, wanted = statistics.median(ratios), LEAST_SHARE * statistics.median(machine)
    print(
        f'\n{what}: {speed_up:.2f} ({min(ratios):.2f} to {max(ratios):.2f}) times as fast on '
        f'two processors, counting only: {statistics.median(machine):.2f}'
    )
    assert speed_up > wanted


def test_batch_on_two_threads(two: Executor) -> None:
    held = np.tile(valve_voltages(0.34), (SAMPLES, 1))
    rigs = [load_configuration('cylinder_2', load_mass=0.01 * k) for k in range(PLANTS)]

    def batch(threads: int) -> None:
        run_parallel([Plant(rig.model) for rig in rigs], held, 1.16e-3, threads)

    check_speed_up(batch, two, 'a batch')


def test_tasks_in_two_processes(two: Executor) -> None:
    numba.set_num_threads(1)
    executors = {1: SerialExecutor(), 2: two}
    check_speed_up(lambda n: map_tasks(executors[n], strokes, range(TASKS)), two, 'tasks')


def test_results_are_the_same_bits_on_any_number_of_processes(two: Executor) -> None:
    alone = map_tasks(SerialExecutor(), strokes, range(TASKS))
    assert map_tasks(two, strokes, range(TASKS)) == alone
    with open_executor(3) as three:
        assert map_tasks(three, strokes, range(TASKS)) == alone


def test_scheduler_of_dask_takes_milliseconds_for_a_task() -> None:
    # The scheduler runs in this process, so that its processor time is counted.
    with (
        LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        open_executor(scheduler=cluster.scheduler_address) as workers,
    ):
        map_tasks(workers, abs, range(100))
        busy = time.process_time()
        taken = seconds(lambda: map_tasks(workers, abs, range(EMPTY_TASKS)))
        busy = time.process_time() - busy
    print(
        f'\na task on Dask: {1e3 * busy / EMPTY_TASKS:.1f} ms of processor time of the '
        f'scheduler, {2e3 * taken / EMPTY_TASKS:.1f} ms of a worker'
    )
    assert busy / EMPTY_TASKS < 0.02
