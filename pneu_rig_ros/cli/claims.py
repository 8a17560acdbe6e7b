"""`pneu-rig claims`: the paper's statements, measured."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.claims.captions import Summary
    from pneu_rig_ros.claims.experiments import Laboratory, Reading
    from pneu_rig_ros.claims.findings import Row

STDOUT = '-'


@click.command(
    short_help="The paper's statements, each measured: holds or does not",
    epilog='\b\nExamples:\n'
    '  pneu-rig claims\n'
    '  pneu-rig claims --html claims.html\n'
    '  pneu-rig claims --reading plainest --no-neighbours\n'
    '  pneu-rig claims --reading my_reading.yaml --json | jq .[].holds\n'
    '\b\nA reading is a YAML file with what differs from the shipped cylinders:\n'
    '  friction: {stop_velocity: 0.001 m/s, static_friction_reading: follows_clock}\n'
    '  operation: {rest_time: 900.0 s}\n',
)
@click.option(
    '--reading',
    metavar='NAME|FILE',
    help='values for what the paper does not print  [default: those of the shipped cylinders]',
)
@click.option(
    '--html', type=click.Path(path_type=Path), metavar='FILE', help='write a page with all curves'
)
@click.option(
    '--json',
    'as_json',
    is_flag=False,
    flag_value=STDOUT,
    metavar='[FILE|-]',
    help='write plain data for scripts; without FILE print it in place of the table',
)
@click.option('--markdown', is_flag=True, default=None, help='print a short table in Markdown')
@click.option(
    '--neighbours/--no-neighbours',
    default=True,
    help='measure each statement under neighbouring settings too  [default: yes, about a minute]',
)
@options.quiet_option
def claims(
    reading: str | None, html: Path | None, as_json: str | None, markdown: bool | None,
    neighbours: bool, quiet: bool,
) -> None:  # fmt: skip
    """
    Measure every statement of the paper on simulated strokes.

    Prints a row for each: what the paper says, what was measured, whether it holds, and the share
    of neighbouring settings under which it holds: u, supply pressure and each unprinted quantity
    5 % off, starts along the stroke. The exit code is 0 whatever holds.
    """
    page = options.new_file(html, '--html') if html else None
    file = None if as_json in (None, STDOUT) else options.new_file(Path(str(as_json)), '--json')
    if markdown and as_json == STDOUT:
        raise RigError('--markdown does not go with --json without FILE: both print')
    if page and file and page.resolve() == file.resolve():
        raise RigError(f'--html and --json both name {page}; give each a file of its own')

    from pneu_rig_ros.claims.captions import summary
    from pneu_rig_ros.claims.experiments import Laboratory
    from pneu_rig_ros.claims.readings import load_reading

    laboratory = Laboratory(load_reading(reading or 'default'))
    rows = _measure(laboratory, quiet)
    shares = _neighbour_shares(laboratory.reading, quiet) if neighbours else {}
    files = {'page': _page(page, rows, laboratory, shares, quiet)} if page else {}
    text = json.dumps([plain(row, shares) for row in rows], indent=2, allow_nan=False) + '\n'
    if file:
        files['data'] = write_text(file, text)
    if as_json == STDOUT:
        click.echo(text, nl=False)
    elif markdown:
        from pneu_rig_ros.claims.findings import markdown as table

        click.echo(table(rows, shares))
    elif not quiet:
        _print(rows, laboratory.reading, shares, summary(laboratory))
        output.print_values({name: str(path) for name, path in files.items()})


def _measure(laboratory: Laboratory, quiet: bool) -> list[Row]:
    from pneu_rig_ros.claims.statements import STATEMENTS, measure

    rows = []
    with output.step_bar('statements', len(STATEMENTS), quiet) as progress:
        for done, statement in enumerate(STATEMENTS, start=1):
            rows.append(measure(laboratory, statement))
            progress(done)
    return rows


def _neighbour_shares(reading: Reading, quiet: bool) -> dict[int, float]:
    from pneu_rig_ros.claims.neighbours import failures, neighbours
    from pneu_rig_ros.executor import open_executor

    total = len(list(neighbours(reading)))
    with open_executor(None) as processes, output.step_bar('neighbours', total, quiet) as progress:
        fails = failures(reading, processes, progress)
    return {number: 1.0 - len(names) / total for number, names in fails.items()}


def _page(
    page: Path, rows: Sequence[Row], laboratory: Laboratory, shares: Mapping[int, float],
    quiet: bool,
) -> Path:  # fmt: skip
    from pneu_rig_ros.report.claims_figures import drawings
    from pneu_rig_ros.report.claims_page import write_page

    with output.step_bar('figures', len(drawings()), quiet) as progress:
        return write_page(page, rows, laboratory, shares, progress)


def plain(row: Row, shares: Mapping[int, float]) -> dict[str, Any]:
    """Return a row as plain data; ``neighbours`` is a share [-], None if not measured."""
    return {
        'statement': row.statement.number,
        'expected': row.statement.text,
        'measured': [
            {'finding': finding.says, 'measured': finding.measured, 'holds': bool(finding.holds)}
            for finding in row.findings
        ],
        'holds': bool(row.holds),
        'neighbours': shares.get(row.statement.number),
    }


def write_text(path: Path, text: str) -> Path:
    """Write a file; RigError if it cannot be written."""
    try:
        path.write_text(text, encoding='utf-8')
    except OSError as error:
        raise RigError(f'cannot write {path}: {error.strerror}') from error
    return path


def _print(
    rows: Sequence[Row], reading: Reading, shares: Mapping[int, float],
    strokes: Sequence[Summary],
) -> None:  # fmt: skip
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from pneu_rig_ros.claims.captions import stroke_text
    from pneu_rig_ros.claims.readings import printed_values_changed

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_lines=True)
    table.add_column('no.', justify='right')
    table.add_column('the paper says', max_width=30)
    table.add_column('wanted: measured (the tightest, or all that fail)')
    table.add_column('verdict', no_wrap=True)
    if shares:
        table.add_column('neighbours', justify='right')
    for row in rows:
        verdict = Text(*(('holds', 'green') if row.holds else ('does not', 'red')))
        share = [f'{shares[row.statement.number]:.0%}'] if shares else []
        cells = str(row.statement.number), row.statement.text, _measured(row)
        table.add_row(*cells, verdict, *share)
    output.print_table(table)
    terminal = output.console()
    held = sum(row.holds for row in rows)
    terminal.print()
    for line in strokes:
        terminal.print(stroke_text(line))
    terminal.print(f'{held} of {len(rows)} statements hold under the reading {reading.name!r}')
    if changed := printed_values_changed(reading):
        terminal.print(f'which changes values that the paper prints: {", ".join(changed)}')


def _measured(row: Row) -> str:
    """Return the finding with the least margin, or all that fail."""
    failed = [f'NOT {f.says}: {f.measured}' for f in row.findings if not f.holds]
    return '\n'.join(failed) or f'{row.tightest.says}: {row.tightest.measured}'
