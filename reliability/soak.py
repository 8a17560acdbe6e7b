"""
Soak: the rig live for a long time on a busy machine, and what became of every sample.

Four node processes at 862 Hz, all topics recorded, a command that moves the piston to and fro,
beside them a process that burns one core for a third of the time and one that reads the bag again
and again. What is told of losses is proven from the bag.
"""

from __future__ import annotations

import contextlib
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import click
import psutil
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from benchmarks.__main__ import machine
from pneu_rig_ros.cli import output
from pneu_rig_ros.nodes.loop_timer import PeriodicTimer
from pneu_rig_ros.nodes.startup import await_first_sample
from pneu_rig_ros.nodes.topics import create_publisher
from pneu_rig_ros.records.cdr import pack_float64
from reliability import figures
from reliability.live_rig import ORDER, ProcessRig, own_domain
from reliability.soak_bag import Content, read_content
from reliability.witness import STROKE, U

COMMAND_PERIOD_NS = 20_000_000
SETTLE = 60.0
"""After it memory shall not grow any more [s]."""

MEGABYTE = 2**20
GROWTH_LIMIT, DRIFT_LIMIT = 1.0, 1.0
"""Wanted: growth of memory [MB] and drift of the clock [ms] below it."""


@dataclass
class Soak:
    """What one run showed."""

    minutes: float
    samples: int
    messages: int
    lost: dict[str, int]
    growth_mb: dict[str, float]
    held_mb: dict[str, float]
    drift_ms: float
    rate_hz: float
    looks: dict[str, int]
    unreadable: list[str]
    oldest_s: float
    others_percent: float
    machine: str = field(default_factory=machine)

    @property
    def met(self) -> bool:
        """Whether all that is wanted was so."""
        return (
            not any(self.lost.values())
            and max(self.growth_mb.values()) < GROWTH_LIMIT
            and abs(self.drift_ms) < DRIFT_LIMIT
            and not self.unreadable
        )


def run(minutes: float, progress: Callable[[float], None] = lambda _: None) -> Soak:
    """
    Run the rig for some minutes and evaluate its bag.

    :param progress: told the elapsed time [s]
    """
    with tempfile.TemporaryDirectory(prefix='pneu_rig_soak_') as folder:
        bag = Path(folder) / 'bag'
        memory = Memory(min(SETTLE, 20.0 * minutes))
        with ProcessRig(bag) as rig:
            await_first_sample(rig.check)
            numbers = {name: node.number for name, node in rig.nodes.items()}
            with _beside('reliability.burner'), _watched(bag) as seen:
                load = Load()
                commands = _drive(60.0 * minutes, numbers, memory, progress)
                others = load.others_percent()
        content = read_content(bag)
    return _judged(minutes, content, memory, seen, commands, others)


class Load:
    """What other programs take of the processor, those of the soak left out."""

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._all, self._own = _busy_seconds(), _own_seconds()

    def others_percent(self) -> float:
        """Return it since this was made [% of one core]."""
        busy, own = _busy_seconds() - self._all, _own_seconds() - self._own
        return 100.0 * (busy - own) / (time.monotonic() - self._start)


def _busy_seconds() -> float:
    times = psutil.cpu_times()
    return float(sum(times) - times.idle - times.iowait - times.guest - times.guest_nice)


def _own_seconds() -> float:
    me = psutil.Process()
    return sum(sum(p.cpu_times()[:2]) for p in (me, *me.children(recursive=True)))


class Memory:
    """
    Memory that processes hold over time.

    Pages of files, programs and libraries, which the kernel reads and drops as it likes, are left
    out.

    :param settle: time after which it is to be flat [s]
    """

    def __init__(self, settle: float) -> None:
        self._settle = settle
        self._start = time.monotonic()
        self._seen: dict[str, list[int]] = {}

    def note(self, numbers: dict[str, int]) -> None:
        """Note the memory of processes by name [bytes]."""
        if time.monotonic() - self._start > self._settle:
            for name, number in numbers.items():
                memory = psutil.Process(number).memory_info()
                self._seen.setdefault(name, []).append(memory.rss - memory.shared)

    def growth_mb(self) -> dict[str, float]:
        """Return by how much it has grown from the first tenth to the last one [MB]."""
        return {
            name: (_middle(seen[-_tenth(seen) :]) - _middle(seen[: _tenth(seen)])) / MEGABYTE
            for name, seen in self._seen.items()
        }

    def held_mb(self) -> dict[str, float]:
        """Return the last value [MB]."""
        return {name: seen[-1] / MEGABYTE for name, seen in self._seen.items()}


def _tenth(values: list[int]) -> int:
    return max(len(values) // 10, 1)


def _middle(values: list[int]) -> float:
    return float(statistics.median(values))


def _drive(
    seconds: float, numbers: dict[str, int], memory: Memory, progress: Callable[[float], None]
) -> int:
    """Command the piston to and fro, note memory once a second; return how many commands."""
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = Node('soak', context=context)
    publisher = create_publisher(node, 'u')
    start, pace, count = time.monotonic(), PeriodicTimer(COMMAND_PERIOD_NS), 0
    try:
        while (elapsed := time.monotonic() - start) < seconds:
            if publisher.get_subscription_count() >= 2:
                publisher.publish(pack_float64(U if elapsed // STROKE % 2 else -U))
                count += 1
            if count % 50 == 0:
                memory.note(numbers)
            progress(elapsed)
            pace.wait()
        publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=5.0))
    finally:
        node.destroy_node()
        context.try_shutdown()
    return count


@contextlib.contextmanager
def _beside(module: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Run a module of this folder beside the block."""
    command = [sys.executable, '-m', module, *arguments]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


@contextlib.contextmanager
def _watched(bag: Path) -> Iterator[dict[str, Any]]:
    """Have the bag read while the block runs; what was seen is in the dictionary afterwards."""
    seen: dict[str, Any] = {}
    with _beside('reliability.bag_watch', str(bag)) as process:
        yield seen
        answer, _ = process.communicate('stop\n')
        seen |= json.loads(answer)


def _judged(
    minutes: float,
    content: Content,
    memory: Memory,
    seen: dict[str, Any],
    commands: int,
    others: float,
) -> Soak:
    return Soak(
        minutes=minutes,
        samples=content.samples,
        messages=content.messages,
        lost=content.lost | {'u': commands - content.counts['/u']},
        growth_mb=memory.growth_mb(),
        held_mb=memory.held_mb(),
        drift_ms=content.drift_ms,
        rate_hz=content.rate_hz,
        looks=seen['looks'],
        unreadable=seen['failures'],
        oldest_s=seen['oldest_s'],
        others_percent=others,
    )


def text(soak: Soak) -> str:
    """Return what the page says."""
    growth = ', '.join(f'{name} {soak.growth_mb[name]:+.2f}' for name in ORDER)
    sizes = ', '.join(f'{soak.held_mb[name]:.0f}' for name in ORDER)
    held = f'of {sizes} MB, without pages of files'
    looks = ', '.join(f'{name} {count}' for name, count in soak.looks.items())
    rows = {
        f'of {soak.samples} samples, {soak.messages} messages: lost': sum(soak.lost.values()),
        'rate [Hz]': f'{soak.rate_hz:.3f}',
        f'growth of memory after the first minute [MB] ({held})': growth,
        'drift of the stamps against the wall clock [ms]': f'{soak.drift_ms:+.3f}',
        f'bag opened while it was recorded ({looks} times): unreadable': len(soak.unreadable),
        'age of the newest message in it, at most [s]': f'{soak.oldest_s:.2f}',
        'other programs on this computer [% of one core]': f'{soak.others_percent:.0f}',
    }
    table = '\n'.join(f'| {name} | {value} |' for name, value in rows.items())
    return (
        f'`make soak`: {soak.minutes:g} minutes live at 862 Hz, four processes, all topics '
        'recorded, another process burning one core for a third of the time. Nothing lost means: '
        'no gap between the stamps of any topic, and as many messages in the bag as were '
        f'published.\n\n| figure | measured |\n| --- | --- |\n{table}\n\n{soak.machine}.'
    )


@click.command()
@click.option('--minutes', default=30.0, show_default=True, help='how long')
def soak(minutes: float) -> None:
    """Run the rig for a long time on a busy machine; prove that nothing is lost."""
    own_domain()
    with output.progress_bar('soak', 60.0 * minutes) as progress:
        result = run(minutes, progress)
    click.echo(text(result))
    for failure in result.unreadable:
        click.echo(failure, err=True)
    figures.keep('soak', asdict(result) | {'met': result.met}, text(result))
    if not result.met:
        raise SystemExit(1)
