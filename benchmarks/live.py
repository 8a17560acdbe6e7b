"""
The rig live over DDS: rate, missed ticks, lost samples, tick error, processor time, highest rate.

Four nodes in their own processes, or composed in one, under a command that moves the piston to
and fro. Everything but the processor time comes from the bag that the recorder wrote.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rosbags.rosbag2 import Reader

from pneu_rig_ros.nodes.constant_command import hold_command
from pneu_rig_ros.nodes.loop_timer import claim_realtime_priority
from pneu_rig_ros.nodes.topics import PolledSubscription
from pneu_rig_ros.records.cdr import typestore, unpack_stamp

SEPARATE = ('recorder', 'friction_estimator', 'valve_command', 'plant')
COMPOSED = ('rig',)
PUBLISHED = {
    'plant': ('joint_states', 'position', 'velocity', 'chamber_1/pressure', 'chamber_2/pressure'),
    'valve_command': ('valve_voltages',),
    'friction_estimator': ('friction',),
}
WAIT_FOR = {
    'plant:wait_for_subscribers': 1,
    'valve_command:wait_for_subscribers': 2,
    'friction_estimator:wait_for_subscribers': 1,
}
"""So that the bag begins with sample 0 and losses are seen from the start."""

U = 0.34
STROKE_SECONDS = 10.0
WARM_UP_SECONDS = 2.0
START_TIMEOUT = 60.0
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
    tick_error_p50_ms: float
    tick_error_p99_ms: float
    tick_error_max_ms: float
    cpu_percent: float
    cpu_percent_by_node: dict[str, float]


def run(seconds: float = 60.0) -> dict[str, Any]:
    """Measure the live rig for `seconds` [s] in each arrangement; return the figures by name."""
    separate = measure(SEPARATE, seconds)
    composed = measure(COMPOSED, seconds)
    results: dict[str, Any] = separate._asdict()
    results['composed_rate_hz'] = composed.rate_hz
    results['composed_missed'] = composed.missed
    results['composed_lost'] = composed.lost
    results['composed_cpu_percent'] = composed.cpu_percent
    results['composed_tick_error_p99_ms'] = composed.tick_error_p99_ms
    if realtime_permitted():
        urgent = measure(SEPARATE, seconds, priority=PRIORITY)
        results['realtime_tick_error_p50_ms'] = urgent.tick_error_p50_ms
        results['realtime_tick_error_p99_ms'] = urgent.tick_error_p99_ms
        results['realtime_tick_error_max_ms'] = urgent.tick_error_max_ms
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
    trouble: list[str | None] = []
    attempt = threading.Thread(target=lambda: trouble.append(claim_realtime_priority(PRIORITY)))
    attempt.start()
    attempt.join()
    return trouble == [None]


def measure(nodes: Sequence[str], seconds: float, priority: int = 0, interval_ns: int = 0) -> Run:
    """Run the nodes for `seconds` [s] and evaluate their bag."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(PROFILE)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        parameters = {
            'recorder:output': bag,
            'plant:realtime_priority': priority,
            'plant:interval_ns': interval_ns,
            **WAIT_FOR,
        }
        arguments = [
            part for key, value in parameters.items() for part in ('-p', f'{key}:={value}')
        ]
        with _processes(nodes, arguments) as processes:
            _await_samples()
            with _driven():
                cpu = _processor_percent(processes, seconds)
        return _evaluate(bag, cpu)


def _await_samples() -> None:
    """Return when samples are coming, and starting up has died away."""
    context = Context()
    rclpy.init(context=context)
    node = Node('benchmark', context=context)
    subscription = PolledSubscription(node, 'joint_states')
    deadline = time.monotonic() + START_TIMEOUT
    while subscription.take() is None:
        if time.monotonic() > deadline:
            raise RuntimeError(f'no sample {START_TIMEOUT:g} s after the start')
        time.sleep(0.02)
    node.destroy_node()
    context.try_shutdown()
    time.sleep(WARM_UP_SECONDS)


@contextmanager
def _driven() -> Iterator[None]:
    stop = threading.Event()
    driver = threading.Thread(target=_to_and_fro, args=(stop,))
    driver.start()
    try:
        yield
    finally:
        stop.set()
        driver.join()


class _Stopped(Exception):
    """Ends a drive half way."""


def _to_and_fro(stop: threading.Event) -> None:
    def progress(_: float) -> None:
        if stop.is_set():
            raise _Stopped

    u = U
    with suppress(_Stopped):
        while True:
            hold_command(u, STROKE_SECONDS, progress)
            u = -u


@contextmanager
def _processes(
    nodes: Sequence[str], arguments: Sequence[str]
) -> Iterator[dict[str, subprocess.Popen[bytes]]]:
    """Start the nodes, end them in reverse order, so that the recorder sees the others out."""
    started = {node: _start(node, arguments) for node in nodes}
    try:
        yield started
    finally:
        for process in reversed(started.values()):
            process.send_signal(signal.SIGINT)
            process.wait(timeout=30)
    failed = {node: p.returncode for node, p in started.items() if p.returncode}
    if failed:
        raise RuntimeError(f'nodes ended with an error: {failed}')


def _start(node: str, arguments: Sequence[str]) -> subprocess.Popen[bytes]:
    command = [sys.executable, '-m', f'pneu_rig_ros.nodes.{node}', '--ros-args', *arguments]
    return subprocess.Popen([*command, '--log-level', 'warn'])


def _processor_percent(
    processes: dict[str, subprocess.Popen[bytes]], seconds: float
) -> dict[str, float]:
    """Return the share of one core [%] that each process takes during `seconds` [s]."""
    before, start = _processor_seconds(processes), time.monotonic()
    time.sleep(seconds)
    after, elapsed = _processor_seconds(processes), time.monotonic() - start
    return {node: 100.0 * (after[node] - before[node]) / elapsed for node in processes}


def _processor_seconds(processes: dict[str, subprocess.Popen[bytes]]) -> dict[str, float]:
    ticks = os.sysconf('SC_CLK_TCK')
    seconds = {}
    for node, process in processes.items():
        fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
        seconds[node] = (int(fields[11]) + int(fields[12])) / ticks
    return seconds


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


def _evaluate(bag: Path, cpu: dict[str, float]) -> Run:
    content = read_content(bag)
    plant = content.reports['/plant']
    span = content.arrivals[-1] - content.arrivals[0]
    return Run(
        rate_hz=(len(content.stamps) - 1) / (span * 1e-9),
        missed=missed(content),
        lost=lost(content),
        tick_error_p50_ms=float(plant['tick error p50 [ms]']),
        tick_error_p99_ms=float(plant['tick error p99 [ms]']),
        tick_error_max_ms=float(plant['tick error max [ms]']),
        cpu_percent=sum(cpu.values()),
        cpu_percent_by_node=cpu,
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
