"""All readers tried for a given time, each in processes of its own; what became of it."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

GUIDED, RANDOM, DAMAGE = 'guided', 'random', 'damage'
SHARES: dict[str, dict[str, float]] = {
    'configuration': {RANDOM: 1, GUIDED: 1},
    'excitation': {RANDOM: 1, GUIDED: 1},
    'reading': {RANDOM: 1, GUIDED: 1},
    'system': {RANDOM: 1, GUIDED: 1},
    'mapping': {RANDOM: 1, GUIDED: 1},
    'conditions': {RANDOM: 1, GUIDED: 1},
    'quantity': {RANDOM: 1, GUIDED: 2},
    'description': {RANDOM: 1, GUIDED: 1},
    'table': {RANDOM: 2, GUIDED: 3},
    'bag': {RANDOM: 1, GUIDED: 3, DAMAGE: 4},
    'sealed bag': {RANDOM: 1, DAMAGE: 4},
    'cut bag': {DAMAGE: 4},
    'metadata': {RANDOM: 1, DAMAGE: 2},
    'foreign bag': {RANDOM: 1, GUIDED: 2, DAMAGE: 4},
    'cdr': {RANDOM: 1, GUIDED: 1},
}
"""Reader -> method -> its share of the time."""

START_UP = 240.0
"""On a busy machine a process may need so much longer than the time for its inputs [s]."""
OFFSETS_PER_SECOND = {'bag': 20.0, 'sealed bag': 30.0, 'cut bag': 400.0, 'metadata': 500.0,
                      'foreign bag': 100.0}  # fmt: skip
"""Damaged bags that a process gets through, about [1/s]; of more offsets some are left out."""
OFFSETS = {'bag': 1500, 'sealed bag': 3000, 'cut bag': 24_000, 'metadata': 18_000,
           'foreign bag': 9000}  # fmt: skip


class Run(NamedTuple):
    """One process."""

    reader: str
    method: str
    seconds: float


def plan(seconds: float) -> list[Run]:
    """Return what to run in a given time [s]."""
    whole = sum(sum(shares.values()) for shares in SHARES.values())
    return [
        Run(reader, method, seconds * share / whole)
        for reader, shares in SHARES.items()
        for method, share in shares.items()
    ]


def carry_out(runs: list[Run], seed: int, progress: Callable[[float], None]) -> Iterator[Any]:
    """Yield reader, method and tally of each run."""
    done = 0.0
    for run in runs:
        yield {'reader': run.reader, 'method': run.method, **_tally(run, seed)}
        done += run.seconds
        progress(done)


def _tally(run: Run, seed: int) -> dict[str, Any]:
    if run.method == DAMAGE:
        seed = max(1, round(OFFSETS[run.reader] / (OFFSETS_PER_SECOND[run.reader] * run.seconds)))
    command = [sys.executable, '-m', 'reliability.fuzz.child', run.method, run.reader,
               f'{run.seconds:.1f}', str(seed)]  # fmt: skip
    nothing = {'accepted': 0, 'refused': 0, 'slowest': 0.0, 'memory': 0}
    try:
        ended = subprocess.run(
            command, capture_output=True, text=True, errors='replace',
            timeout=run.seconds + START_UP,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return {**nothing, 'failures': {'process': f'{run.reader}: hangs'}}
    told = [line for line in ended.stdout.splitlines() if line.startswith('{"accepted"')]
    if not told or (ended.returncode and run.method != GUIDED):
        said = ' '.join(ended.stderr.split())[-300:]
        return {**nothing, 'failures': {'process': f'ended with {ended.returncode}: {said}'}}
    tally: dict[str, Any] = json.loads(told[-1])
    return tally


def summary(tallies: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures of all runs by reader."""
    readers: dict[str, Any] = {}
    for tally in tallies:
        row = readers.setdefault(
            tally['reader'],
            {'tried': 0, 'refused': 0, 'slowest_s': 0.0, 'memory_mb': 0, 'failures': []},
        )
        row['tried'] += tally['accepted'] + tally['refused'] + len(tally['failures'])
        row['refused'] += tally['refused']
        row['slowest_s'] = round(max(row['slowest_s'], tally['slowest']), 2)
        row['memory_mb'] = max(row['memory_mb'], round(tally['memory'] / 2**20))
        row['failures'] += list(tally['failures'].values())
    return readers


def text(readers: dict[str, Any], minutes: float) -> str:
    """Return the figures as Markdown."""
    tried = sum(row['tried'] for row in readers.values())
    failed = sum(len(row['failures']) for row in readers.values())
    rows = [
        f'| {name} | {row["tried"]:,} | {row["refused"]:,} | {row["slowest_s"]} '
        f'| {row["memory_mb"]} | {len(row["failures"])} |'
        for name, row in readers.items()
    ]
    head = (
        f'`make fuzz` ({minutes:g} minutes): {tried:,} inputs, {failed} failures. An input is '
        'refused by one printable line, or read; then the result is held against what else knows '
        'it: itself, written and read again; the decoder of rosbags; the bag before a bit was '
        'changed. None may take 5 s or 1 GB. Inputs are valid ones with something cut, doubled, '
        'changed or put in, by hypothesis and, guided by the coverage of the code, by atheris; '
        'bags are also cut off at each offset, have each byte changed, lengths made huge, and '
        'chunks of some kB that would become 2 GB.'
    )
    return '\n'.join([
        head, '',
        '| reader | tried | refused | slowest [s] | peak memory [MB] | failures |',
        '| --- | --- | --- | --- | --- | --- |', *rows,
    ])  # fmt: skip
