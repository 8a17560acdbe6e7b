"""The rig live for an hour on a busy machine: nothing lost, memory flat, its bag readable."""

from __future__ import annotations

import os
import statistics
import time
from collections import Counter, defaultdict
from contextlib import ExitStack
from itertools import pairwise
from multiprocessing import get_context
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np
import psutil
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from benchmarks.live import lost, missed, read_content
from pneu_rig_ros.records.bag import open_bag, storage_files
from pneu_rig_ros.records.cdr_decoding import unpack_stamp
from pneu_rig_ros.records.topics import DIAGNOSTICS

from .live_rig import ProcessRig
from .witness import Witness

pytestmark = [pytest.mark.long, pytest.mark.live, pytest.mark.usefixtures('apart')]

MINUTES = 60.0
"""Unless `--minutes` is given."""
SETTLE = 60.0
"""After it memory shall not grow any more [s]."""
LARGEST_GROWTH, LARGEST_DRIFT = 1.0, 1.0
"""Of the memory of a node [MB], of the stamps against the wall clock [ms]."""
BUSY, IDLE = 5.0, 10.0
"""Seconds in which another process burns one core, and in which it rests."""
LOOK_EVERY, RECENT_NS = 2.0, 3_000_000_000
"""Between two looks into the bag [s], and how much of its end is read [ns]."""


def burn() -> None:
    """Keep one core busy for a third of the time, until killed."""
    while True:
        end = time.monotonic() + BUSY
        while time.monotonic() < end:
            pass
        time.sleep(IDLE)


def watch(bag: Path, stop: Event, seen: Queue[tuple[dict[str, int], list[str]]]) -> None:
    """Read the end of a bag again and again, and all of it each time that it has doubled."""
    os.nice(19)
    looks, failures, size = Counter[str](), [], 0

    def ours() -> int:
        with open_bag(bag) as reader:
            samples = [c for c in reader.connections if c.topic == '/joint_states']
            recent = reader.messages(samples, start=reader.end_time - RECENT_NS)
            stamps = [unpack_stamp(bytes(cdr)) for _, _, cdr in recent]
            assert len({b - a for a, b in pairwise(stamps)}) == 1, 'a sample is missing'
            return int(reader.message_count)

    def mcap() -> int:
        with storage_files(bag)[0].open('rb') as stream:
            found = make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False)
            return sum(1 for _ in found)

    def rosbags() -> int:
        with Reader(storage_files(bag)[0]) as reader:
            return sum(1 for _ in reader.messages())

    known = 0
    while not stop.wait(LOOK_EVERY):
        now = storage_files(bag)[0].stat().st_size
        size, readers = (now, (ours, mcap, rosbags)) if now > 2 * size else (size, (ours,))
        for read in readers:
            looks[read.__name__] += 1
            try:
                count = read()
                assert count >= known, f'{count} messages, {known} were there before'
                known = count
            except Exception as error:  # whatever a reader says: it could not read
                failures.append(f'{read.__name__}: {type(error).__name__} {error}')
    seen.put((dict(looks), failures))


def drift_ms(stamps: np.ndarray, arrivals: np.ndarray) -> float:
    """Return by how much the least delay of the samples, which is free of jitter, has grown."""
    delays = arrivals - stamps
    part = min(delays.size // 3, 50_000)
    return 1e-6 * float(delays[-part:].min() - delays[:part].min())


def growth_mb(held: list[int]) -> float:
    """Return by how much memory [byte] has grown from the first tenth to the last one [MB]."""
    part = max(len(held) // 10, 1)
    return (statistics.median(held[-part:]) - statistics.median(held[:part])) / 2**20


def test_nothing_is_lost_and_memory_does_not_grow(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    seconds = 60.0 * (request.config.getoption('minutes') or MINUTES)
    spawn = get_context('spawn')
    stop, seen, bag = spawn.Event(), spawn.Queue(), tmp_path / 'bag'
    burner = spawn.Process(target=burn, daemon=True)
    watcher = spawn.Process(target=watch, args=(bag, stop, seen), daemon=True)
    held: dict[str, list[int]] = defaultdict(list)
    with (
        ProcessRig(bag) as rig,
        ExitStack() as ended,
        Witness(topics=(DIAGNOSTICS, 'friction')) as witness,
    ):
        witness.hears('friction')
        for process in (burner, watcher):
            process.start()
            ended.callback(process.kill)
        start = time.monotonic()
        while (elapsed := time.monotonic() - start) < seconds:
            witness.listen(1.0)
            witness.received.clear()
            for name, node in rig.nodes.items() if elapsed > min(SETTLE, seconds / 3) else ():
                # Pages of files, which the kernel reads and drops as it likes, do not count.
                memory = psutil.Process(node.process.pid).memory_info()
                held[name].append(memory.rss - memory.shared)
        stop.set()
        looks, failures = seen.get(timeout=120.0)
    content = read_content(bag)
    growth = {name: round(growth_mb(values), 2) for name, values in held.items()}
    drift = drift_ms(np.array(content.stamps), np.array(content.arrivals))
    print(
        f'\n{seconds / 60.0:g} minutes: {len(content.stamps)} samples, '
        f'{content.counts.total()} messages, growth [MB] {growth}, drift {drift:+.3f} ms, '
        f'bag opened {looks}'
    )
    assert (lost(content), missed(content)) == (0, 0)
    assert max(growth.values()) < LARGEST_GROWTH
    assert abs(drift) < LARGEST_DRIFT
    assert failures == []
    assert min(looks.values()) >= 1
