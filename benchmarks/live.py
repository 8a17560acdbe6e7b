"""
The rig live over DDS: rate, missed ticks, lost samples, tick error, processor time, highest rate.

Four nodes in their own processes, or composed in one, under a command that moves the piston to
and fro. Everything but the processor time comes from the bag that the recorder wrote.
"""

import json
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import psutil
from rosbags.rosbag2 import Reader

from pneu_rig_ros.demo import NodeProcess, Value, check_all
from pneu_rig_ros.nodes.embedding import await_first_sample, hold_command
from pneu_rig_ros.nodes.timing import claim_realtime_priority
from pneu_rig_ros.records.cdr_decoding import unpack_stamp
from pneu_rig_ros.records.cdr_encoding import typestore

SEPARATE = ('recorder', 'friction_estimator', 'valve_command', 'plant')
COMPOSED = ('rig',)
PUBLISHED = {
    'plant': ('joint_states', 'position', 'velocity', 'chamber_1/pressure', 'chamber_2/pressure'),
    'valve_command': ('valve_voltages',),
    'friction_estimator': ('friction',),
}
WAIT_FOR: dict[str, Value] = {
    'plant:wait_for_subscribers': 1,
    'valve_command:wait_for_subscribers': 2,
    'friction_estimator:wait_for_subscribers': 1,
}
"""So that the bag begins with sample 0 and losses are seen from the start."""

U = 0.34
STROKE_SECONDS = 10.0
WARM_UP_SECONDS = 2.0
PRIORITY = 50
LADDER_HZ = (2500, 3000, 3500, 4000, 4500, 5000, 6000, 7000, 8000)
LADDER_SECONDS = 10.0
ATTEMPTS = 2
STEADY = 500
RATE_TOLERANCE = 1e-3
PROFILE = Path(__file__).resolve().parents[1] / 'config' / 'fastdds.xml'


class Run(NamedTuple):
    """What one run showed."""

    rate_hz: float
    missed: int
    lost: int
    tick_error_p99_ms: float
    cpu_percent: float


def run(seconds: float = 60.0) -> dict[str, Any]:
    """Measure the live rig for `seconds` [s] in each arrangement; return the figures by name."""
    results: dict[str, Any] = measure(SEPARATE, seconds)._asdict()
    results['composed_cpu_percent'] = measure(COMPOSED, seconds).cpu_percent
    if realtime_permitted():
        urgent = measure(SEPARATE, seconds, priority=PRIORITY)
        results['realtime_tick_error_p99_ms'] = urgent.tick_error_p99_ms
    results['max_rate_hz'] = highest_rate()
    return results


def highest_rate() -> float:
    """Return the highest rate [Hz] of the ladder that is held without a loss, 0 if none is."""
    held = 0.0
    for rate in LADDER_HZ:
        if not any(_holds(rate) for _ in range(ATTEMPTS)):
            break
        held = float(rate)
    return held


def _holds(rate: float) -> bool:
    outcome = measure(SEPARATE, LADDER_SECONDS, interval_ns=round(1e9 / rate))
    exact = abs(outcome.rate_hz / rate - 1.0) < RATE_TOLERANCE
    return exact and not outcome.lost and not outcome.missed


def realtime_permitted() -> bool:
    """Return whether this user may run under SCHED_FIFO."""
    with ThreadPoolExecutor() as thread:  # which has the priority, not this one
        return thread.submit(claim_realtime_priority, PRIORITY).result() is None


def measure(nodes: Sequence[str], seconds: float, priority: int = 0, interval_ns: int = 0) -> Run:
    """Run the nodes for `seconds` [s] and evaluate their bag."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(PROFILE)
    with tempfile.TemporaryDirectory() as folder:
        parameters: dict[str, Value] = {
            'recorder:output': str(Path(folder, 'bag')),
            'plant:realtime_priority': priority,
            'plant:interval_ns': interval_ns,
            **WAIT_FOR,
        }
        started = [NodeProcess(name, parameters, Path(folder, name)) for name in nodes]
        try:
            await_first_sample(partial(check_all, started))
            time.sleep(WARM_UP_SECONDS)
            cpu = _drive(started, seconds)
        finally:
            # In reverse order, so that the recorder sees the others out.
            failed = [node.name for node in reversed(started) if not node.stop()]
        if failed:
            raise RuntimeError(f'nodes ended with an error: {failed}')
        return _evaluate(Path(folder, 'bag'), cpu)


def _drive(nodes: Sequence[NodeProcess], seconds: float) -> float:
    """Move the piston to and fro for `seconds` [s]; return what the nodes take of a core [%]."""
    before, start = _processor_seconds(nodes), time.monotonic()
    u = U
    while (left := start + seconds - time.monotonic()) > 0.0:
        hold_command(u, min(STROKE_SECONDS, left))
        u = -u
    return 100.0 * (_processor_seconds(nodes) - before) / (time.monotonic() - start)


def _processor_seconds(nodes: Sequence[NodeProcess]) -> float:
    times = (psutil.Process(node.process.pid).cpu_times() for node in nodes)
    return float(sum(each.user + each.system for each in times))


class Content(NamedTuple):
    """What is read of a bag: messages by topic, stamps and arrivals of the samples, reports."""

    counts: Counter[str]
    stamps: list[int]
    arrivals: list[int]
    reports: dict[str, dict[str, str]]


def read_content(bag: Path) -> Content:
    """Read all messages of a bag."""
    content = Content(Counter(), [], [], {})
    with Reader(bag) as reader:
        for connection, arrival, cdr in reader.messages():
            content.counts[connection.topic] += 1
            if connection.topic == '/joint_states':
                content.stamps.append(unpack_stamp(bytes(cdr)))
                content.arrivals.append(arrival)
            elif connection.topic == '/diagnostics':
                message: Any = typestore().deserialize_cdr(cdr, connection.msgtype)
                for status in message.status:
                    values = {item.key: item.value for item in status.values}
                    content.reports[status.name] = values
    return content


def _evaluate(bag: Path, cpu_percent: float) -> Run:
    content = read_content(bag)
    span = content.arrivals[-1] - content.arrivals[0]
    return Run(
        rate_hz=(len(content.stamps) - 1) / (span * 1e-9),
        missed=missed(content),
        lost=lost(content),
        tick_error_p99_ms=float(content.reports['/plant']['tick error p99 [ms]']),
        cpu_percent=cpu_percent,
    )


def missed(content: Content) -> int:
    """Count ticks without a sample: holes between stamps, and those the plant is behind by."""
    stamps, arrivals = content.stamps, content.arrivals
    interval = min(b - a for a, b in pairwise(stamps))
    holes = (stamps[-1] - stamps[0]) // interval + 1 - len(stamps)
    # The least delay of many messages is free of jitter; if it grows, the plant falls behind.
    delays = [arrival - stamp for arrival, stamp in zip(arrivals, stamps, strict=True)]
    behind = (min(delays[-STEADY:]) - min(delays[:STEADY])) // interval
    return holes + max(behind, 0)


def lost(content: Content) -> int:
    """Count the published messages that are not in the bag."""
    return sum(
        int(content.reports[f'/{node}']['published']) - content.counts[f'/{topic}']
        for node, topics in PUBLISHED.items()
        for topic in topics
    )


if __name__ == '__main__':
    print(json.dumps(run(*map(float, sys.argv[1:])), indent=2))
