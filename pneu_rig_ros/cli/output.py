"""What the commands print: tables, values, progress, JSON."""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.errors import printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress, ProgressColumn

    from pneu_rig_ros.analysis.summary import Summary

UNKNOWN = '-'

NAME_WIDTH = 19
"""Width of the first column [character]."""

PIPE_WIDTH = 110
"""Width of a table that is printed into a pipe or file [character]."""

AS_IS: Any = {'highlight': False, 'markup': False, 'emoji': False}
"""Texts are printed as they are: names may have brackets and colons."""


def flag(name: str, help: str) -> Callable[[Any], Any]:
    """Return a decorator that adds a flag, which ``chosen`` reads; the command does not get it."""

    def note(context: click.Context, _: click.Parameter, value: bool) -> None:
        context.meta[name] = value

    return click.option(name, is_flag=True, expose_value=False, callback=note, help=help)


def chosen(name: str) -> bool:
    """Return whether the command that runs, if any, was given a flag."""
    context = click.get_current_context(silent=True)
    return context is not None and context.meta.get(name, False)


def as_text(data: Mapping[str, Any]) -> bool:
    """Print a result as JSON if that is asked for; return whether text is to be printed."""
    if chosen('--json'):
        click.echo(json_text(data))
    return not (chosen('--json') or chosen('--quiet'))


def console(stderr: bool = False, quiet: bool = False) -> Console:
    """Return a terminal that colours nothing by itself and breaks no path."""
    return _terminal()(stderr=stderr, quiet=quiet, soft_wrap=True, **AS_IS)


@cache
def _terminal() -> type[Console]:
    """Return the class of terminals that texts from anybody's file cannot command."""
    from rich.console import Console
    from rich.text import Text

    class Terminal(Console):
        def render_str(self, text: str, **options: Any) -> Text:
            lines = map(printable, text.split('\n'))
            return super().render_str('\n'.join(lines), **options)

    return Terminal


def print_table(
    heads: Sequence[str], rows: Iterable[Sequence[RenderableType]], lines: bool = False
) -> None:
    """
    Print a table as wide as the terminal, with lines broken inside its cells.

    :param heads: of the columns; one that begins with '>' is for numbers, aligned to the right
    :param lines: whether there is a line between two rows
    """
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_lines=lines)
    for head in heads:
        name = head.removeprefix('>')
        table.add_column(name, justify='left' if name == head else 'right', overflow='fold')
    for row in rows:
        table.add_row(*row)
    width = None if console().is_terminal else PIPE_WIDTH
    _terminal()(width=width, **AS_IS).print(table)


def json_text(data: object) -> str:
    """Return plain data and paths as JSON."""
    return json.dumps(data, indent=2, allow_nan=False, default=os.fspath)


def print_values(values: Mapping[str, object]) -> None:
    """Print names and values in two columns; lines of a value are never cut or wrapped."""
    terminal = console()
    for name, value in values.items():
        terminal.print(f'{name:<{NAME_WIDTH}}', style='dim', end='')
        terminal.print(str(value).replace('\n', f'\n{"":<{NAME_WIDTH}}'))


def print_summary(summary: Summary, files: Mapping[str, Path]) -> None:
    """Print the summary of a recording and where its files are."""
    if summary.source is not None:
        origin = f'imported from {summary.source}'
    else:
        origin = f'friction {summary.friction_model}, seed {summary.seed}'
    lost = [f'{topic} {number}' for topic, number in summary.lost.items()]
    half = (len(lost) + 1) // 2
    lines = [', '.join(lost[:half]), ', '.join(lost[half:])]
    print_values(
        {
            'cylinder': f'{summary.cylinder}, {origin}',
            'recorded': f'{summary.duration:.2f} s, {summary.samples} samples',
            'rate': f'{_number(summary.rate, "Hz", 2)} of {1 / summary.interval:.2f} Hz',
            'jitter': f'p50 {_number(summary.jitter_p50 * 1e3, "ms", 3)}, '
            f'p99 {_number(summary.jitter_p99 * 1e3, "ms", 3)}',
            'lost samples': ',\n'.join(filter(None, lines)),
            'travel': f'{summary.travel * 1e3:.1f} mm',
            'stick-slip cycles': len(summary.cycles),
            'peak friction': _number(summary.peak_friction, 'N', 1),
            **files,
        }
    )


def _number(value: float | None, unit: str, digits: int) -> str:
    if value is None or math.isnan(value):
        return UNKNOWN
    return f'{value:.{digits}f} {unit}'


@contextlib.contextmanager
def progress_bar(title: str, total: float, unit: str = '') -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr for the block; yield a callback that takes how much is done."""
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn

    count = f'{{task.completed:5.1f}} of {{task.total:g}} {unit}'
    columns = (
        TextColumn('{task.description}', markup=False),
        BarColumn(),
        TextColumn(count if unit else '{task.completed:g} of {task.total:g}'),
        TimeRemainingColumn(),
    )
    with _progress(*columns) as bar:
        task = bar.add_task(title, total=total)
        yield lambda done: bar.update(task, completed=min(done, total))


@contextlib.contextmanager
def stage_bar() -> Iterator[Callable[[str, float], None]]:
    """Show a bar on stderr for the block; yield a callback that takes stage and fraction [-]."""
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = BarColumn(20), TaskProgressColumn(), TimeElapsedColumn()
    with _progress(*columns, TextColumn('{task.description}')) as bar:
        task = bar.add_task('', total=1.0)
        yield lambda stage, share: bar.update(task, description=stage, completed=share)


def _progress(*columns: ProgressColumn) -> Progress:
    from rich.progress import Progress

    terminal = console(stderr=True)
    disable = chosen('--quiet') or not terminal.is_terminal
    return Progress(*columns, console=terminal, transient=True, disable=disable)
