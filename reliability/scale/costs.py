"""What sharing out costs and brings, as ratios and times of one run on one machine."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numba
import numpy as np
from distributed import LocalCluster

from pneu_rig_ros.batch.parallel import run_parallel
from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks, open_executor
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages
from reliability.scale.tasks import megabytes, nothing, spin, strokes, trial

EMPTY, LARGE, MEGABYTES = 1000, 20, 10
"""Empty tasks, and tasks with so many MB to carry."""
SPIN = 1.0
"""Time for which processors are tried out [s]."""
SAMPLES, PLANTS = 8000, 64
"""Of the batch: intervals of 1.16 ms, and plants."""
COMPILE = (
    'from pneu_rig_ros.diagnosis.hypothesis import Hypothesis;'
    'from pneu_rig_ros.rig import load_configuration as load;'
    "m = load('cylinder_1').model; p = Hypothesis(m).plant(m);"
    'import numpy as np; p.run(np.full((2, 2), 2.5), 1e-3)'
)
"""The plant of a diagnosis, with every effect of the library."""


class Pair(NamedTuple):
    """The same work with one processor and with two, one right after the other [s]."""

    one: float
    two: float

    @property
    def ratio(self) -> float:
        """How many times faster two are [-]."""
        return self.one / self.two


def seconds(work: Callable[[], Any]) -> float:
    """Return how long something takes [s]."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def batch_pairs(count: int) -> Iterator[Pair]:
    """Yield the batch on one thread and on two."""
    held = np.tile(valve_voltages(0.34), (SAMPLES, 1))

    def run(threads: int) -> float:
        rigs = [load_configuration('cylinder_2', load_mass=0.01 * k) for k in range(PLANTS)]
        plants = [Plant(rig.model) for rig in rigs]
        return seconds(lambda: run_parallel(plants, held, 1.16e-3, threads))

    run(2)
    for _ in range(count):
        yield Pair(run(1), run(2))


def process_pairs(count: int, tasks: int, two: Executor) -> Iterator[Pair]:
    """Yield strokes in this process on one thread and in two processes of one thread each."""
    map_tasks(two, strokes, range(4))
    numba.set_num_threads(1)
    for _ in range(count):
        alone = seconds(lambda: map_tasks(SerialExecutor(), strokes, range(tasks)))
        yield Pair(alone, seconds(lambda: map_tasks(two, strokes, range(tasks))))


def machine_ratio(two: Executor) -> float:
    """Return what two processors give just now, in what one gives [-]."""
    one = spin(SPIN)
    return sum(map_tasks(two, spin, [SPIN, SPIN])) / one


def start_up() -> dict[str, float]:
    """Return how long two processes take to start, and to their first result [s]."""
    begin = time.perf_counter()
    with open_executor(2) as two:
        started = time.perf_counter() - begin
        first = seconds(lambda: map_tasks(two, strokes, range(2)))
        again = seconds(lambda: map_tasks(two, strokes, range(2)))
    return {'start_s': started, 'load_s': max(first - again, 0.0)}


def way() -> dict[str, float]:
    """Return what a task costs a Dask worker and the scheduler, and each MB of its result [s]."""
    # the scheduler runs in this process, so that its processor time is included
    with (
        LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        open_executor(scheduler=cluster.scheduler_address) as two,
    ):
        map_tasks(two, nothing, range(100))
        busy = time.process_time()
        empty = seconds(lambda: map_tasks(two, nothing, range(EMPTY))) / EMPTY
        busy = (time.process_time() - busy) / EMPTY
        large = seconds(lambda: map_tasks(two, megabytes, [MEGABYTES] * LARGE)) / LARGE
    return {
        'latency_s': 2 * empty,
        'overhead_s': busy,
        'megabyte_s': max(large - empty, 0.0) / MEGABYTES,
    }


def compilation() -> float:
    """Return how long a machine compiles the plant of a diagnosis, once [s]."""
    with tempfile.TemporaryDirectory(prefix='pneu-rig-') as folder:
        environment = os.environ | {'XDG_CACHE_HOME': folder}
        command = [sys.executable, '-c', COMPILE]
        return seconds(lambda: subprocess.run(command, env=environment, check=True))


def trials(count: int, two: Executor, progress: Callable[[int], None]) -> dict[str, float]:
    """Return how long blind trials take, and how long the whole of them [s]."""
    map_tasks(two, trial, [0, 1])  # each worker loads its plants
    begin = time.perf_counter()
    done = map_tasks(two, trial, range(2, count + 2), progress=progress)
    return {
        'count': count,
        'mean_s': statistics.mean(one.seconds for one in done),
        'longest_s': max(one.seconds for one in done),
        'answer_bytes': statistics.mean(one.size for one in done),
        'wall_s': time.perf_counter() - begin,
    }
