"""What the commands print: a summary, progress, plain data."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.errors import printable

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from pneu_rig_ros.analysis.summary import Summary

NOT_KNOWN = '-'

NAME_WIDTH = 19
"""Width of the first column [character]."""

PIPE_WIDTH = 110
"""Width of a table that is printed into a pipe or file [character]."""


def console(stderr: bool = False, quiet: bool = False) -> Console:
    """Return a terminal that colours nothing by itself and breaks no path."""
    from rich.console import Console

    return Console(stderr=stderr, quiet=quiet, highlight=False, markup=False, soft_wrap=True)


def print_table(table: Table) -> None:
    """Print a table with lines broken inside its cells, as wide as the terminal."""
    from rich.console import Console

    width = None if console().is_terminal else PIPE_WIDTH
    Console(highlight=False, markup=False, width=width).print(table)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """
    Return a table of texts.

    :param heads: of the columns; one that begins with '>' is for numbers, set right
    """
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for head in heads:
        name = head.removeprefix('>')
        made.add_column(name, justify='left' if name == head else 'right', overflow='fold')
    for row in rows:
        made.add_row(*row)
    return made


def print_json(data: Mapping[str, Any]) -> None:
    """Print plain data for scripts."""
    click.echo(json.dumps(data, indent=2, allow_nan=False))


def print_values(rows: Mapping[str, str]) -> None:
    """
    Print names and values in two columns; values are never cut or wrapped.

    They may come from anybody's file: of them nothing but text reaches the terminal.
    """
    terminal = console()
    for name, value in rows.items():
        terminal.print(f'{name:<{NAME_WIDTH}}', style='dim', end='')
        terminal.print('\n'.join(map(printable, value.split('\n'))))


def print_summary(summary: Summary, files: Mapping[str, Path]) -> None:
    """Print the summary of a record and where its files are."""
    rows = {
        'cylinder': f'{summary.cylinder}, {_plant(summary)}',
        'recorded': f'{summary.duration:.2f} s, {summary.samples} samples',
        'rate': f'{_number(summary.rate, "Hz", 2)} of {1 / summary.interval:.2f} Hz',
        'jitter': f'p50 {_number(summary.jitter_p50 * 1e3, "ms", 3)}, '
        f'p99 {_number(summary.jitter_p99 * 1e3, "ms", 3)}',
        'lost samples': lost_text(summary.lost),
        'travel': f'{summary.travel * 1e3:.1f} mm',
        'stick-slip cycles': str(len(summary.cycles)),
        'peak friction': _number(summary.peak_friction, 'N', 1),
    }
    rows |= {name: str(path) for name, path in files.items()}
    print_values(rows)


def _plant(summary: Summary) -> str:
    if summary.source is not None:
        return f'imported from {summary.source}'
    return f'friction {summary.friction_model}, seed {summary.seed}'


def tell_summary(summary: Summary, files: Mapping[str, Path], as_json: bool) -> None:
    """Print the summary of a record and where its files are, as text or as plain data."""
    if as_json:
        print_json({name: str(path) for name, path in files.items()} | summary.to_dict())
    else:
        print_summary(summary, files)


def lost_text(lost: Mapping[str, int]) -> str:
    """Return the losses of each topic, two lines at most."""
    texts = [f'{topic} {number}' for topic, number in lost.items()]
    half = (len(texts) + 1) // 2
    lines = [', '.join(texts[:half]), ', '.join(texts[half:])]
    return f',\n{"":<{NAME_WIDTH}}'.join(line for line in lines if line)


def _number(value: float | None, unit: str, digits: int) -> str:
    if value is None or math.isnan(value):
        return NOT_KNOWN
    return f'{value:.{digits}f} {unit}'


@contextlib.contextmanager
def progress_bar(
    title: str, total: float, quiet: bool = False
) -> Iterator[Callable[[float], None]]:  # fmt: skip
    """Show a bar on stderr while the block runs; yield what to tell the time [s] to."""
    with _bar(title, total, '{task.completed:5.1f} of {task.total:g} s', quiet) as tell:
        yield lambda done: tell(min(done, total))


@contextlib.contextmanager
def step_bar(
    title: str, total: int, quiet: bool = False
) -> Iterator[Callable[[int], None]]:  # fmt: skip
    """Show a bar on stderr while the block runs; yield what to tell the steps done to."""
    with _bar(title, total, '{task.completed:g} of {task.total:g}', quiet) as tell:
        yield tell


@contextlib.contextmanager
def stage_bar(quiet: bool = False) -> Iterator[Callable[[str, float], None]]:
    """Show a bar on stderr while the block runs; yield what to tell the stage and the share to."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
    from rich.progress import TimeElapsedColumn as Elapsed

    terminal = console(stderr=True)
    bar = Progress(
        BarColumn(20),
        TaskProgressColumn(),
        Elapsed(),
        TextColumn('{task.description}'),
        console=terminal,
        transient=True,
        disable=quiet or not terminal.is_terminal,
    )
    with bar:
        task = bar.add_task('', total=1.0)
        yield lambda stage, share: bar.update(task, description=stage, completed=share)


@contextlib.contextmanager
def _bar(
    title: str, total: float, count: str, quiet: bool = False
) -> Iterator[Callable[[float], None]]:
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    terminal = console(stderr=True)
    bar = Progress(
        TextColumn('{task.description}'),
        BarColumn(),
        TextColumn(count),
        TimeRemainingColumn(),
        console=terminal,
        transient=True,
        disable=quiet or not terminal.is_terminal,
    )
    with bar:
        task = bar.add_task(title, total=total)
        yield lambda done: bar.update(task, completed=done)
